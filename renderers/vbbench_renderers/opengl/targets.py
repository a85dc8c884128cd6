"""The pictures that are drawn into, and how they come back."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import moderngl

FINENESS = 2
"""Samples a pixel, in each direction."""


class Targets:
    """A fine picture of colour, and of person and depth together; and the same at the size that is asked for."""

    def __init__(self, context: "moderngl.Context", size: tuple[int, int], resolve: "moderngl.VertexArray") -> None:
        fine = (FINENESS * size[0], FINENESS * size[1])
        self.size = size
        self._resolve = resolve
        self._fine_parts = [context.texture(fine, 4), context.texture(fine, 2, dtype="f4")]
        self._fine_parts[1].filter = (context.NEAREST, context.NEAREST)
        self._parts = [context.texture(size, 4), context.texture(size, 2, dtype="f4")]
        self._depth = context.depth_renderbuffer(fine)
        self.fine = context.framebuffer(self._fine_parts, self._depth)
        self._plain = context.framebuffer(self._parts)
        self._picture = np.empty((size[1], size[0], 4), np.uint8)
        self._truth = np.empty((size[1], size[0], 2), np.float32)

    def read(self) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """[H, W, 4] colours, and [H, W, 2] column of the person (−1 for none) and depth; valid until the next call."""
        self._plain.use()
        for unit, part in enumerate(self._fine_parts):
            part.use(unit)
        self._resolve.render(vertices=3)
        self._plain.read_into(self._picture, components=4, attachment=0)
        self._plain.read_into(self._truth, components=2, attachment=1, dtype="f4")
        return self._picture, self._truth

    def release(self) -> None:
        """Give back the memory."""
        for part in (self.fine, self._plain, self._depth, *self._fine_parts, *self._parts):
            part.release()
