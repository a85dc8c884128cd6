"""Smooth edges: on people, and where the z-buffer has an edge; elsewhere textures stay sharp."""

import numpy as np
from numba import prange
from numpy.typing import NDArray

from vbbench.kernels import kernel, parallel_kernel
from vbbench.sequence import NOBODY
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.filling import STRIP

Image = NDArray[np.uint8]
STEP = 0.05
"""Neighbours whose depths differ by more than this share are on different surfaces."""
LEAST = 24.0
"""Edges with less contrast (sum of three bands, 0 … 765) stay as they are."""


@parallel_kernel
def finish(
    nearness: Float32, limbs: Int32, owners: Int32, colours: Image, closed: bool, rgb: Image, depth: Float32, ids: Int32
) -> None:
    """Turn columns into a picture with smooth edges.

    The direction of an edge is that along which brightness changes least; colours are the mean of three
    places along it (after Lottes 2009, "FXAA").

    Parameters
    ----------
    nearness, limbs : [W, H] see `vbbench_renderers.raster.filling.fill`.
    owners : [N + 1] id of each limb's person, `NOBODY` for surroundings, less for the sky.
    colours : [W, H, 3] sRGB.
    closed : whether the first column follows the last one.
    rgb, depth, ids : [H, W, 3], [H, W] and [H, W], written; see `vbbench.pictures.rendering.Picture`.
    """
    width = len(nearness)
    for strip in prange((width + STRIP - 1) // STRIP):
        for column in range(strip * STRIP, min(width, (strip + 1) * STRIP)):
            left, right = column - 1, column + 1
            if closed:
                left, right = left % width, right % width
            _finish_column(
                nearness, limbs, owners, colours, max(left, 0), column, min(right, width - 1), rgb, depth, ids
            )


@kernel
def _finish_column(
    nearness: Float32,
    limbs: Int32,
    owners: Int32,
    colours: Image,
    left: int,
    column: int,
    right: int,
    rgb: Image,
    depth: Float32,
    ids: Int32,
) -> None:
    height = nearness.shape[1]
    for row in range(height):
        near, owner = nearness[column, row], owners[limbs[column, row]]
        depth[row, column], ids[row, column] = np.float32(1.0) / near, max(owner, NOBODY)
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        if (
            owner >= 0
            or _differ(nearness[left, row], near, owners[limbs[left, row]], owner)
            or _differ(nearness[right, row], near, owners[limbs[right, row]], owner)
            or _differ(nearness[column, above], near, owners[limbs[column, above]], owner)
            or _differ(nearness[column, below], near, owners[limbs[column, below]], owner)
        ):
            _mix(colours, left, column, right, above, row, below, rgb)
        else:
            for band in range(3):
                rgb[row, column, band] = colours[column, row, band]


@kernel
def _differ(near: float, other: float, owner: int, other_owner: int) -> bool:
    """Whether two pixels show different surfaces."""
    return owner != other_owner or abs(near - other) > STEP * max(near, other)


@kernel
def _brightness(colours: Image, column: int, row: int) -> float:
    return float(colours[column, row, 0]) + float(colours[column, row, 1]) + float(colours[column, row, 2])


@kernel
def _mix(colours: Image, left: int, column: int, right: int, above: int, row: int, below: int, picture: Image) -> None:
    """The colour of a pixel on an edge; positions in between are mixed from the 3 x 3 neighbourhood."""
    nw, ne = _brightness(colours, left, above), _brightness(colours, right, above)
    sw, se = _brightness(colours, left, below), _brightness(colours, right, below)
    along_x, along_y = (sw + se) - (nw + ne), (nw + sw) - (ne + se)
    size = max(abs(along_x), abs(along_y))
    x, y = (abs(along_x) / size, abs(along_y) / size) if size >= LEAST else (0.0, 0.0)
    ahead_x, back_x = (right, left) if along_x > 0.0 else (left, right)
    ahead_y, back_y = (below, above) if along_y > 0.0 else (above, below)
    for band in range(3):
        here = float(colours[column, row, band])
        ahead = _between(
            here, colours[ahead_x, row, band], colours[column, ahead_y, band], colours[ahead_x, ahead_y, band], x, y
        )
        back = _between(
            here, colours[back_x, row, band], colours[column, back_y, band], colours[back_x, back_y, band], x, y
        )
        picture[row, column, band] = int(0.34 * here + 0.33 * (ahead + back) + 0.5)


@kernel
def _between(here: float, beside: float, over: float, across: float, x: float, y: float) -> float:
    """Bilinear between four neighbours."""
    return (1.0 - y) * ((1.0 - x) * here + x * beside) + y * ((1.0 - x) * over + x * across)
