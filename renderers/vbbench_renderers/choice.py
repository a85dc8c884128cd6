"""The default renderer, registered as ``auto``: the published import path of the backend that needs no driver."""

from vbbench_renderers.raster import RasterRenderer as AutoRenderer

__all__ = ["AutoRenderer"]
