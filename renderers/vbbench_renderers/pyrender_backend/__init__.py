"""Backend ``pyrender``: the common scene-graph renderer, for comparison and for machines set up for it."""

from vbbench_renderers.pyrender_backend.renderer import PyrenderRenderer

__all__ = ["PyrenderRenderer"]
