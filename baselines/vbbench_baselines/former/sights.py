"""Boxes of a frame as measurements: a ray for each person, and two distances along it with their noise."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench.solver import Problem
from vbbench_baselines.common.bearings import FEET_CUT, HEAD_CUT, SIDE_CUT, bearings_of
from vbbench_baselines.former.operations import Array

LOWEST, HIGHEST = -1.6, 4.8
"""ln of the nearest and farthest distance in m that counts."""
SMALLEST_SLOPE = 1e-3
"""Feet nearer to the horizon than this, in m per m, have no information."""
LEAST_STD, MOST_STD, UNKNOWN_STD = 1e-4, 3.0, 0.1
"""Bounds of noise, and what stands where there is no box."""
_CUTS = np.array((FEET_CUT, HEAD_CUT, SIDE_CUT))


class Sights(NamedTuple):
    """Measurements of people [..., K]; 0 where there is no box.

    Attributes
    ----------
    seen : 1 where there is a box.
    ray : towards the person, forward + i·left of the camera; 1 where there is no box.
    by_height, by_feet : ln of the distance in m, for a person of mean height, and for feet on level ground.
    has_feet : 1 where the foot cue measures a distance.
    noise : [..., K, 3] standard deviations in rad of the ray, and of the two logarithms.
    cut : [..., K, 3] 1 where the picture's border may cut off feet, head or a side.
    """

    seen: Array
    ray: Array
    by_height: Array
    by_feet: Array
    has_feet: Array
    noise: Array
    cut: Array


def sights_of(problem: Problem, boxes: FloatArray) -> Sights:
    """The measurements of boxes [..., K, 3] (u, v, l) in px; NaN = no box."""
    camera, found = problem.camera, bearings_of(problem.camera, boxes)
    with np.errstate(divide="ignore", invalid="ignore"):
        edge = np.hypot(problem.pixel_std, problem.box_std * found.size)
        foot = np.where(found.foot > SMALLEST_SLOPE, found.foot, np.nan)
        slope_std = np.hypot(edge * found.length / found.size, problem.tilt_std)
        noise = np.empty((*foot.shape, 3))
        np.divide(edge * found.width, found.size, out=noise[..., 0])
        np.divide(np.sqrt(2.0) * edge, found.size, out=noise[..., 1])
        np.hypot(slope_std / foot, problem.mount_height_std / camera.mount_height, out=noise[..., 2])
        far = np.log(np.array((problem.height_mean / found.length, camera.mount_height / foot)))
    seen, stands = known = ~np.isnan(far)
    by_height, by_feet = _single(np.where(known, np.minimum(np.maximum(far, LOWEST), HIGHEST), 0.0))
    there = seen[..., None]
    bounded = np.minimum(np.maximum(noise, LEAST_STD), MOST_STD)
    return Sights(
        seen=_single(seen),
        ray=np.exp(-1j * np.where(seen, found.azimuth, 0.0)).astype(np.complex64),
        by_height=by_height,
        by_feet=by_feet,
        has_feet=_single(seen & stands & (found.cut & FEET_CUT == 0)),
        noise=_single(np.where(there & ~np.isnan(noise), bounded, UNKNOWN_STD)),
        cut=_single(there & (found.cut[..., None] & _CUTS > 0)),
    )


def _single(values: NDArray[Any]) -> NDArray[np.float32]:
    return values.astype(np.float32)
