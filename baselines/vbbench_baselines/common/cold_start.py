"""What all solvers share when nothing is given but the observer's pose in frame 0 (protocol ``cold-start``).

People are first placed by their box heights. Their common velocity is a gauge freedom: boxes do not distinguish a crowd
that walks past from an observer who walks the other way. A prior fixes it: people's velocities are drawn from N(0,
`PEOPLE_SPEED`²) about once every `FADE` seconds, and predicted velocities decay at this rate. The observer may drive.
"""

import math

import numpy as np

from vbbench.geometry import FloatArray

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


class Astray:
    """Variance of the common drift since a cold start; the variances of stretches without odometry add up.

    In t seconds without odometry it is that of an integrated Ornstein–Uhlenbeck process with the deviation s =
    `FLOW_SPEED` and the time F = `FADE`, 2 s² F (t − F(1 − exp(−t/F))).
    """

    def __init__(self) -> None:
        self._stretch = self._finished = 0.0

    def wait(self, seconds: float) -> None:
        """Add a frame; for so many ``seconds`` of it nothing measured how the observer moved."""
        if seconds == 0.0 and self._stretch > 0.0:
            self._finished, self._stretch = self.variance, 0.0
        self._stretch += seconds

    @property
    def variance(self) -> float:
        """Variance in m² on each axis."""
        late = self._stretch - FADE * (1.0 - np.exp(-self._stretch / FADE))
        return self._finished + float(2.0 * FLOW_SPEED**2 * FADE * late)
