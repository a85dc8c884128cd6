"""What the parts of a façade agree on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray
from vbbench_renderers.surroundings.layers import Layer
from vbbench_renderers.surroundings.quads import Quads, quads


@dataclass(frozen=True, kw_only=True)
class Front:
    """A façade.

    Parameters
    ----------
    wall, panes : layers of the wall and of the windows.
    colour, trim : [3] linear RGB of wall and mouldings.
    bays : [B + 1] borders of the bays, m from the left.
    floors : [F + 1] heights of the upper floors and of the eaves, m.
    window : width and height of a window, m.
    """

    wall: Layer
    panes: Layer
    colour: FloatArray
    trim: FloatArray
    bays: FloatArray
    floors: FloatArray
    window: tuple[float, float]


def upright(x0: ArrayLike, x1: ArrayLike, z0: ArrayLike, z1: ArrayLike, y: float = 0.0) -> FloatArray:
    """[N, 4, 3] rectangles that face the walking area, at depth y, m."""
    left, right, low, high = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(value, float)) for value in (x0, x1, z0, z1))
    )
    level = np.full(left.shape, y)
    corners = [(left, level, low), (right, level, low), (right, level, high), (left, level, high)]
    return np.asarray(np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1))


def graded(colour: ArrayLike, foot: float, head: float) -> FloatArray:
    """[1, 4, 3] colours of a rectangle that is darkened at its foot and at its head."""
    return np.asarray(np.asarray(colour) * np.array([foot, foot, head, head])[None, :, None])


def wall(front: Front, corners: FloatArray, tile: float, foot: float = 1.0, head: float = 1.0) -> Quads:
    """Rectangles of wall."""
    return quads(corners, graded(front.colour, foot, head), layer=front.wall, tile=tile)
