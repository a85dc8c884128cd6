"""What all solvers share when nothing is given but the observer's pose in frame 0 (protocol ``cold-start``).

People are first placed by their box heights. Their common velocity is a gauge freedom: boxes do not distinguish a crowd
that walks past from an observer who walks the other way. A prior fixes it: people's velocities are drawn from N(0,
`PEOPLE_SPEED`²) about once every `FADE` seconds, and predicted velocities decay at this rate. The observer may drive.
"""

import math

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.sequence import Given

PEOPLE_SPEED = 1.0
"""In m/s, standard deviation of each component of people's velocities."""

OBSERVER_SPEED = 4.0
"""The same of the observer, who may be a vehicle."""

FADE, OBSERVER_FADE = 4.0, 16.0
"""In s: how long a velocity that nothing confirms counts of people, and of the observer."""


STANDING, FAST = 0.35, 2.0
"""How much it counts that the observer stands, next to that each of those seen does; half as much at this m/s."""

FLOW_SPEED = 0.6
"""In m/s, standard deviation of each component of the velocity that a crowd has in common."""


def begins_cold(given: Given, frame: int) -> bool:
    """Whether ``given`` of the frames up to ``frame`` (the last rows) shows that the sequence began cold.

    Only frame 1 shows it: every other protocol gives its pose.
    """
    return frame == 1 and math.isnan(given.poses[-1, 0])


def kept_velocities(dt: float, watched: bool) -> tuple[float, float]:
    """The factors by which the velocities of people and of the observer decay in ``dt`` seconds.

    ``watched``: whether a person is seen; else the observer's velocity decays as people's does.
    """
    return math.exp(-dt / FADE), math.exp(-dt / (OBSERVER_FADE if watched else FADE))


def standing(speed: FloatArray) -> FloatArray:
    """Weight [...] of the prior that an observer at a ``speed`` [...] in m/s stands, for each person seen.

    Each person has a prior of a low speed. Against a single one of the observer, a larger crowd that walks past would
    make it surer that the observer moves. The common velocity is one unknown, and so the observer's prior is weighted
    by their number. It vanishes at high speed: such observers are vehicles.
    """
    return np.asarray(STANDING / (1.0 + (speed / FAST) ** 2))


def drift_variance(seconds: FloatArray) -> FloatArray:
    """Variance in m² on each axis of the drift by the crowd's common velocity, in ``seconds`` [...] without odometry.

    It is that of an integrated Ornstein–Uhlenbeck process with the deviation s and the time F = `FADE`,
    2 s² F (t − F(1 − exp(−t/F))).
    """
    return np.asarray(2.0 * FLOW_SPEED**2 * FADE * (seconds - FADE * (1.0 - np.exp(-seconds / FADE))))


class Astray:
    """Variance of the common drift since a cold start; the variances of stretches without odometry add up.

    Attributes
    ----------
    seconds : total time without odometry, in s.
    """

    def __init__(self) -> None:
        self.seconds = self._stretch = self._finished = 0.0

    def wait(self, seconds: float) -> None:
        """Add a frame; for so many ``seconds`` of it nothing measured how the observer moved."""
        if seconds == 0.0 and self._stretch > 0.0:
            self._finished, self._stretch = self.variance, 0.0
        self._stretch += seconds
        self.seconds += seconds

    @property
    def variance(self) -> float:
        """Variance in m² on each axis."""
        return self._finished + float(drift_variance(np.array(self._stretch)))


def add_drift(poses: FloatArray, places: FloatArray, variance: FloatArray) -> None:
    """Add the ``variance`` [...] in m² of the common drift, in place, to covariances of ``poses`` and ``places``.

    Those of poses are [..., 3, 3], those of places [..., K, 2, 2]. A solver models people's velocities as independent,
    so that its covariances lack their common part.
    """
    poses[..., :2, :2] += variance[..., None, None] * np.eye(2)
    places += variance[..., None, None, None] * np.eye(2)
