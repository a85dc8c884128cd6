"""What all solvers share when nothing is given but the observer's pose in frame 0 (protocol ``cold-start``).

People are first placed where the heights of their boxes say. How fast people move is not known then, and how fast all
move together never becomes quite certain: no picture of people distinguishes a crowd that walks past from an observer
who walks the other way. Only what is likely helps: people are slow, and so their velocities count as drawn from N(0,
`PEOPLE_SPEED`²) about once every `FADE` seconds; what is expected of the next frame fades towards a standstill as
quickly. The observer may drive.
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
    """The shares of the velocities of people and of the observer that are still expected ``dt`` seconds later.

    ``watched``: whether a person is seen; else the observer's velocity fades as people's does.
    """
    return math.exp(-dt / FADE), math.exp(-dt / (OBSERVER_FADE if watched else FADE))


def standing(speed: FloatArray) -> FloatArray:
    """How much it counts that an observer at a ``speed`` in m/s stands, next to that each of those seen does.

    Each of the people seen is slow by a separate prior. Against a single one of the observer, the more people walk
    past the surer it would seem that it is the observer who moves. What all have in common is one unknown, and so the
    observer's prior grows with their number. It fades with speed: the fast are vehicles.
    """
    return np.asarray(STANDING / (1.0 + (speed / FAST) ** 2))


def drift_variance(seconds: FloatArray) -> FloatArray:
    """In m² in each direction, how far a crowd's common velocity leads astray in ``seconds`` [...] without odometry.

    A velocity that is forgotten within `FADE` (an Ornstein–Uhlenbeck process) leads astray with the variance
    2 s² F (t − F(1 − exp(−t/F))).
    """
    return np.asarray(2.0 * FLOW_SPEED**2 * FADE * (seconds - FADE * (1.0 - np.exp(-seconds / FADE))))


class Astray:
    """How far all may have drifted together since a cold start; each stretch without odometry begins again.

    Attributes
    ----------
    seconds : without odometry, in all.
    """

    def __init__(self) -> None:
        self.seconds = self._stretch = self._finished = 0.0

    def wait(self, seconds: float) -> None:
        """A frame has passed, for so many ``seconds`` of which nothing measured how the observer moved."""
        if seconds == 0.0 and self._stretch > 0.0:
            self._finished, self._stretch = self.variance, 0.0
        self._stretch += seconds
        self.seconds += seconds

    @property
    def variance(self) -> float:
        """In m² in each direction."""
        return self._finished + float(drift_variance(np.array(self._stretch)))


def add_drift(poses: FloatArray, places: FloatArray, variance: FloatArray) -> None:
    """Add what nobody can know of a crowd's common velocity to covariances, a ``variance`` [...] in each direction.

    Those of poses are [..., 3, 3], those of places [..., K, 2, 2]. A solver takes velocities of different people for
    independent, and its covariances do not have that all may walk one way.
    """
    poses[..., :2, :2] += variance[..., None, None] * np.eye(2)
    places += variance[..., None, None, None] * np.eye(2)
