"""Boxes of any camera as directions and tangents, the measurements of people on the ground.

Of a person at the distance r in the direction a, who is h tall and seen from the height c, a box measures

    the direction a, the slope c/r down to the feet, and the slope h/r from head to feet,

as a camera without tilt would see them. The camera converts noise in box heights to these units. A box at the border of
the picture shows a part of the person only.
"""

from typing import NamedTuple

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray, IntArray, shorter_way

BORDER = 5.0
"""In px: boxes that end nearer to the picture's first or last row may go on beyond it."""

HALF_WIDTH = 0.22
"""Half the width of a walking person, as a share of the height."""

FEET_CUT, HEAD_CUT, SIDE_CUT = 1, 2, 4
"""What the border of the picture may have cut off."""


class Bearings(NamedTuple):
    """Boxes [...] as directions and tangents; NaN = none.

    Attributes
    ----------
    azimuth : a in rad, clockwise from forward.
    foot, length : tangents c/r to the feet and h/r from head to feet, in m per m.
    size : height of the box in px.
    width : angle in rad along the row that is as many px wide as the box is high.
    cut : which of `FEET_CUT`, `HEAD_CUT` and `SIDE_CUT` hold, as a sum.
    """

    azimuth: FloatArray
    foot: FloatArray
    length: FloatArray
    size: FloatArray
    width: FloatArray
    cut: IntArray


def bearings_of(camera: Camera, boxes: FloatArray) -> Bearings:
    """The bearings of boxes [..., 3] (u, v, l) in px; NaN for boxes that no person on the ground can have."""
    boxes = np.where(boxes[..., 2:] > 0.0, boxes, np.nan)
    np.maximum(boxes[..., 2], SMALLEST_BOX, out=boxes[..., 2])
    both = np.array((boxes, boxes))
    both[1, ..., 0] += 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        rays = camera.unproject(both, np.ones(()))
        length = 1.0 / np.hypot(rays[0, ..., 0], rays[0, ..., 1])
        foot = camera.mount_height * length / camera.statures(boxes)[1]
    azimuth, right = np.arctan2(rays[..., 0], rays[..., 1])
    width = np.abs(shorter_way(right - azimuth, 2.0 * np.pi)) * boxes[..., 2]
    nobody = ~(np.isfinite(azimuth + foot + length + width) & (length > 0.0))
    azimuth, foot, length, size, width = np.where(nobody, np.nan, (azimuth, foot, length, boxes[..., 2], width))
    return Bearings(azimuth, foot, length, size, width, _cut(camera, boxes))


def _cut(camera: Camera, boxes: FloatArray) -> IntArray:
    """Parts that the border may have cut off the boxes [..., 3], as sums of flags."""
    columns, rows = camera.picture_size
    u, v, size = boxes[..., 0], boxes[..., 1], boxes[..., 2]
    half = 0.5 * size
    cut: IntArray = FEET_CUT * (v + half > rows - BORDER) + HEAD_CUT * (v - half < BORDER)
    if camera.period is None:
        reach = HALF_WIDTH * size
        cut = cut + SIDE_CUT * ((u - reach < 0.0) | (u + reach > columns))
    return cut


SMALLEST_BOX = 1.0
"""Boxes lower than this (px) are taken to be this high: noise must not turn a person's distance negative."""


FARTHEST_PIXEL = 1e6
"""In px; no picture is that large."""


class Sightings(NamedTuple):
    """The boxes of one frame as rays; NaN = not observed.

    Attributes
    ----------
    rays : [K, 2] (right, forward) place in m of a person one metre tall.
    sideways : [K, 2] in m, how far one standard deviation of u moves that place.
    stretch : [K] relative standard deviation of the distance from the noise of the box height.
    """

    rays: FloatArray
    sideways: FloatArray
    stretch: FloatArray


def usable(observations: FloatArray) -> FloatArray:
    """The boxes [..., K, 3] in px, those that are not finite or beyond any picture as if they were not there."""
    sound = (np.abs(observations) <= FARTHEST_PIXEL).all(axis=-1, keepdims=True)
    return np.where(sound, observations, np.nan)


def sight(camera: Camera, observations: FloatArray, pixel_std: float) -> Sightings:
    """Rays of the boxes [..., K, 3] in px, with noise of ``pixel_std`` px on u and on box top and bottom."""
    boxes = np.array((observations, observations))
    boxes[1, ..., 0] += 1.0
    np.maximum(boxes[..., 2], SMALLEST_BOX, out=boxes[..., 2])
    rays, shifted = camera.unproject(boxes, np.ones(()))
    return Sightings(rays, pixel_std * (shifted - rays), (np.sqrt(2.0) * pixel_std) / boxes[0, ..., 2])
