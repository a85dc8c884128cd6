"""A renderer that needs no GL: exact rays, a z-buffer and deferred shading, compiled by numba."""

from vbbench_renderers.raster.renderer import RasterRenderer

__all__ = ["RasterRenderer"]
