"""What the observer measures of its motion, next to or in place of what is expected of its walk.

Odometry says that the observer moved by m = (forward, left, turn) in the axes of the frame before, with covariance C.
Where C is small (`SURE`) the pose to which that leads stands in place of the priors of the observer's walk and head,
which know far less and, of a robot, nothing that is right; elsewhere next to them.
"""

import math
from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.sequence import Odometry

SMALLEST = 1e-6
"""Least standard deviation in m and rad of a measured motion: what is said to be exact must not divide by zero."""

SURE = 0.3
"""In m and rad a frame: a motion measured with smaller standard deviations replaces the priors of walk and head."""


class Told(NamedTuple):
    """What odometry measured of the newest pose, where the pose before is known.

    Attributes
    ----------
    pose : [3] where it leads to.
    std : in m, of its place, equal in all directions.
    facing : information in 1/rad² on its yaw.
    """

    pose: FloatArray
    std: float
    facing: float


def newest_measured(odometry: Odometry | None, before: FloatArray) -> Told | None:
    """What the newest row of ``odometry`` says after the pose ``before`` [3]; ``None`` if nothing."""
    if odometry is None:
        return None
    moved, spread = odometry.motions[-1], odometry.covariances[-1]
    if not (np.isfinite(moved).all() and np.isfinite(spread).all()) or np.isnan(before).any():
        return None
    std = np.sqrt(0.5 * (spread[0, 0] + spread[1, 1]) + SMALLEST**2)
    (x, y, yaw), (forward, left, turn) = before.tolist(), moved.tolist()
    cos, sin = math.cos(yaw), math.sin(yaw)
    pose = np.array((x + (cos * forward - sin * left), y + (sin * forward + cos * left), yaw + turn))
    return Told(pose, float(std), float(1.0 / (spread[2, 2] + SMALLEST**2)))
