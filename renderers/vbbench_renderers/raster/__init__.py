"""A renderer that needs no GL: exact rays, a z-buffer and deferred shading."""

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench_renderers.raster.renderer import RasterRenderer

__all__ = ["RasterRenderer"]
