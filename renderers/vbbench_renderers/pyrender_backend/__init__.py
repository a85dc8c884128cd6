"""Backend ``pyrender``: the common scene-graph renderer, for comparison and for machines set up for it."""

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench_renderers.pyrender_backend.renderer import PyrenderRenderer

__all__ = ["PyrenderRenderer"]
