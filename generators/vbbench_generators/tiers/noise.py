"""Visible parts of people, noise of boxes, and their rounding.

Boxes are rounded to multiples of 2^−b px, so that large datasets compress. A float64 of a panorama has some 40 random
bits below a thousandth of a pixel, which no compressor saves; rounding sets them to zero.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench.parsing.numbers import Checked, Within
from vbbench_generators import _core


@dataclass(frozen=True, kw_only=True)
class Outline:
    """Outline of a standing person as steps, in units of the height.

    Parameters
    ----------
    half, top : from the axis outwards, each step's half width and height above the ground.
    """

    half: tuple[float, ...] = (0.05, 0.12)
    top: tuple[float, ...] = (1.0, 0.80)

    def __post_init__(self) -> None:
        half, top = np.array(self.half), np.array(self.top)
        if half.shape != top.shape or not half.size or np.any(np.diff(half, prepend=0.0) <= 0.0):
            raise ValueError(f"half = {list(self.half)} must grow from above 0, with one top for each")
        if np.any(np.diff(top) >= 0.0) or top[0] != 1.0 or top[-1] <= 0.0:
            raise ValueError(f"top = {list(self.top)} must fall from 1 and stay above 0")


@dataclass(frozen=True)
class Showing:
    """Visible parts of people.

    Parameters
    ----------
    visible : [T, K] visible share of the outline's area in the picture; NaN where the outline is outside.
    boxes : [T, K, 3] boxes (u, v, l) in px of the visible parts; NaN where nothing is visible.
    widths : [T, K] widths of these boxes, in px.
    """

    visible: FloatArray
    boxes: FloatArray
    widths: FloatArray


def see(
    positions: FloatArray, heights: FloatArray, poses: FloatArray, camera: Camera, outline: Outline | None = None
) -> Showing:
    """Visible parts of people in a moving camera.

    Parameters
    ----------
    positions, heights : [T, K, 2] and [K] in m of all people who can hide others; NaN = absent.
    poses : [T, 3] (x, y, yaw) of the camera in m and rad.
    camera : the camera; borders of its picture cut people off, but a panorama has none.
    outline : outline of all people.
    """
    relative = world_to_relative(positions, poses)
    figures = _figures(relative, np.broadcast_to(heights, relative.shape[:-1]), camera)
    return see_figures(figures, np.ascontiguousarray(camera.depth(relative)), camera, outline or Outline())


def see_figures(figures: FloatArray, distances: FloatArray, camera: Camera, outline: Outline) -> Showing:
    """Visible parts of people at ``figures`` in the picture.

    Parameters
    ----------
    figures : [T, K, 3] (u, row of the feet, l) in px; NaN = absent.
    distances : [T, K] in m, which decide who hides whom; NaN = absent.
    camera, outline : as in `see`.
    """
    columns, rows = camera.picture_size
    wraps = camera.period is not None
    halves, tops = np.array(outline.half), np.array(outline.top)
    bottom = np.inf if wraps else float(rows)
    visible, boxes = _core.sweep(np.ascontiguousarray(figures), distances, halves, tops, int(columns), bottom, wraps)
    boxes[..., 0] = camera.wrap_column(boxes[..., 0])
    return Showing(visible, boxes[..., :3], boxes[..., 3])


def _figures(relative: FloatArray, heights: FloatArray, camera: Camera) -> FloatArray:
    """Figures [T, K, 3] (u, row of the feet, l) in px, without borders of the picture; NaN behind the camera."""
    figures = camera.project_unbounded(relative, heights)
    if camera.cylinder is None:
        figures[..., 1] = camera.project_unbounded(relative, np.zeros(heights.shape))[..., 1]
    else:  # the same but for the last bit, which stays as it was in datasets that were made before
        scale = camera.cylinder[0] / camera.depth(relative)
        figures[..., 1] = figures[..., 1] - scale * (camera.mount_height - 0.5 * heights) + scale * camera.mount_height
    return figures


def enough(showing: Showing, least: float) -> BoolArray:
    """Mask [T, K] of people whose visible share is at least ``least``."""
    shown: BoolArray = showing.visible >= least
    return shown & ~np.isnan(showing.boxes[..., 2])


SHORTEST_BOX = 1.0
"""No box gets shorter than this, in px, by noise."""


def add_pixel_noise(boxes: FloatArray, camera: Camera, pixel_std: float, rng: np.random.Generator) -> FloatArray:
    """Gaussian noise of ``pixel_std`` px on the column, top and bottom of boxes [T, K, 3] (u, v, l) in px."""
    column, top, bottom = pixel_std * rng.standard_normal((3, *boxes.shape[:-1]))
    u = camera.wrap_column(boxes[..., 0] + column)
    v = boxes[..., 1] + 0.5 * (top + bottom)
    length = np.maximum(boxes[..., 2] + bottom - top, SHORTEST_BOX)
    return np.stack([u, v, length], axis=-1)


def wandering(shape: tuple[int, ...], memory: float, dt: float, rng: np.random.Generator) -> FloatArray:
    """An Ornstein–Uhlenbeck process along the first axis of ``shape``, with unit variance.

    ``memory`` is its correlation time and ``dt`` the time from one row to the next, in s.
    """
    numbers = rng.standard_normal(shape)
    kept = np.exp(-dt / memory)
    _core.link_rows(numbers.reshape(len(numbers), numbers.size // max(len(numbers), 1)), kept, np.sqrt(1.0 - kept**2))
    return numbers


Bits = Annotated[int, Within(0, 32)]


@dataclass(frozen=True, kw_only=True)
class Precision(Checked):
    """Rounding of boxes (table ``[precision]`` of a recipe).

    The error is uniform over half a step to either side. At a distance r the panorama's l = f·h/r px then determines r
    to 2^−(b_l + 1)/l of it, and u the direction to 2^−b_u·π/W rad. Solvers are not given this error: with 10, 10 and 12
    bits it is at most 0.5 mm at 40 m, less than people sway from one frame to the next.

    Parameters
    ----------
    u_bits, v_bits, l_bits : fractional binary digits of the centre column, centre row and height in px.
    """

    u_bits: Bits
    v_bits: Bits
    l_bits: Bits

    @property
    def steps(self) -> tuple[float, float, float]:
        """The steps of u, v and l, in px."""
        return 2.0**-self.u_bits, 2.0**-self.v_bits, 2.0**-self.l_bits

    def rounded(self, boxes: FloatArray, camera: Camera) -> FloatArray:
        """Boxes [..., 3] (u, v, l) in px, rounded; columns stay in the picture, and heights above 0."""
        steps = np.array(self.steps)
        near: FloatArray = np.rint(boxes / steps) * steps
        near[..., 0] = camera.wrap_column(near[..., 0])
        np.maximum(near[..., 2], steps[2], out=near[..., 2])
        return near
