"""The pictures that are drawn into, and how they are read back."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import moderngl

FINE = 2
"""Samples per pixel in each direction of a finely sampled picture; one of them is the pixel's centre."""


class Targets:
    """Layers of one size of picture: people, their surroundings, and both together.

    Parameters
    ----------
    context : current while this is used.
    size : width and height in px.
    fine_place : whether the surroundings too are sampled finely; people always are.
    """

    def __init__(self, context: "moderngl.Context", size: tuple[int, int], fine_place: bool) -> None:
        fine = (FINE * size[0], FINE * size[1])
        place = fine if fine_place else size
        self.size, self.fine_place = size, fine_place
        self._layers = [
            context.texture(fine, 4),
            context.texture(fine, 2, dtype="f4"),
            context.texture(place, 4),
            context.texture(place, 1, dtype="f4"),
        ]
        for layer in self._layers[1::2]:
            layer.filter = (context.NEAREST, context.NEAREST)
        for layer in self._layers:
            layer.repeat_x = layer.repeat_y = False
        self._whole = [context.texture(size, 4), context.texture(size, 2, dtype="f4")]
        self._depths = [context.depth_renderbuffer(fine), context.depth_renderbuffer(place)]
        self.people = context.framebuffer(self._layers[:2], self._depths[0])
        self.place = context.framebuffer(self._layers[2:], self._depths[1])
        self._frame = context.framebuffer(self._whole)
        self._picture = np.empty((size[1], size[0], 4), np.uint8)
        self._truth = np.empty((size[1], size[0], 2), np.float32)

    def shift(self, fine: bool) -> tuple[float, float]:
        """The shift, in clip units, that puts one of a layer's samples on every pixel's centre."""
        return (0.5 / self.size[0], 0.5 / self.size[1]) if fine else (0.0, 0.0)

    def read(self, compose: "moderngl.VertexArray") -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """[H, W, 4] colours, and [H, W, 2] column of the person (−1 for none) and depth; valid until the next call."""
        self._frame.use()
        for unit, layer in enumerate(self._layers):
            layer.use(unit)
        compose.render(vertices=3)
        self._frame.read_into(self._picture, components=4, attachment=0)
        self._frame.read_into(self._truth, components=2, attachment=1, dtype="f4")
        return self._picture, self._truth
