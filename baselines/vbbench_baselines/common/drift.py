"""Covariance of the common error of observer and people in a frame-by-frame solver, which its residuals do not show.

People are predicted from the solver's own estimates, and so an error that the observer and all people share persists;
constant velocity even continues its growth. Let e_t be the common error on each axis of the places of frame t. It
propagates as the places do (`common.motion`), and each frame adds the error w_t of the pose fit:

    e_t = (1 + κ) e_{t−1} − κ e_{t−2} + w_t.

`Drift` keeps the covariance of (e_t, e_{t−1}). It is zero where poses are given, grows with the cube of time while
nobody is seen, and more slowly with more people. The variance of the yaw is the sum over frames.
"""

import math
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_baselines.common.motion import History

TOP_SPEED = 14.0
"""In m/s; no observer is faster: 50 km/h is what vehicles may drive in towns, and among people they do not."""

FASTER = 1.5
"""An observer whose given poses show more than that may be so many times as fast as they show."""

RUNNING = 12.0
"""In m/s; nobody runs faster (100 m in 9.58 s, at most 12.4 m/s)."""

ACCELERATION = 0.6
"""In m/s², standard deviation of the acceleration of people, and of an observer whom nobody shows."""

TURN = 0.2
"""In rad, standard deviation of how far an observer turns within a second, where nobody shows it."""

ASTRAY = 1.0
"""In m; an observer whose place has a greater standard deviation is lost, and certain people find it again."""

UNRELIABLE = 2.0
"""In m; with a greater standard deviation the solvers report that they have not converged."""

UNKNOWN_PLACE, UNKNOWN_YAW = 1e5, math.pi / math.sqrt(3.0)
"""In m and rad, standard deviations of a pose of which nothing is known: any yaw is as likely."""


class Common(NamedTuple):
    """Covariance of (e_t, e_{t−1}), equal in both directions, and the yaw's variance.

    Attributes
    ----------
    now, across, before : Var e_t, Cov(e_t, e_{t−1}) and Var e_{t−1}, in m².
    yaw : variance in rad².
    """

    now: float
    across: float
    before: float
    yaw: float


def variances(covariance: FloatArray) -> tuple[float, float]:
    """Variances of a pose's place (mean of both axes, m²) and of its yaw (rad²) from its covariance [3, 3]."""
    return float(0.5 * (covariance[0, 0] + covariance[1, 1])), float(covariance[2, 2])


class Drift:
    """The common error of a solver's own poses and places.

    Attributes
    ----------
    common : its covariance.
    top_speed : greatest speed of the observer, in m/s.
    """

    def __init__(self) -> None:
        far = UNKNOWN_PLACE**2
        self.common = Common(far, far, far, UNKNOWN_YAW**2)
        self.top_speed = TOP_SPEED
        self._seconds = math.inf

    @property
    def std(self) -> float:
        """Standard deviation of the place in m."""
        return math.sqrt(self.common.now)

    def speed_variance(self, dt: float) -> float:
        """Variance in (m/s)² of each component of the observer's velocity at the last frame."""
        now, across, before, _ = self.common
        return (now - 2.0 * across + before) / dt**2

    def advance(self, history: History, kept: float, dt: float, *, measured: bool) -> None:
        """Predict the covariance at the newest frame of ``history``.

        Parameters
        ----------
        kept : κ, the factor by which the observer's velocity decays in a frame.
        dt : duration of a frame in s.
        measured : whether odometry measured the motion; then an error of the velocity does not persist.
        """
        self._know(history, dt)
        now, across, before, yaw = self.common
        self._seconds += dt
        if history.pose_given[2]:
            self._seconds, self.common = 0.0, Common(0.0, 0.0, now, 0.0)
        elif measured:
            self.common = self._limited(now, now, now, yaw)
        else:
            ahead = 1.0 + kept
            variance = ahead**2 * now - 2.0 * ahead * kept * across + kept**2 * before
            self.common = self._limited(variance, ahead * now - kept * across, now, yaw)

    def with_more(self, place: float, yaw: float) -> Common:
        """The covariance after the error of a frame's own pose fit is added: variances in m² and rad²."""
        now, across, before, turned = self.common
        return self._limited(now + place, across, before, turned + yaw)

    def add(self, place: float, yaw: float) -> None:
        """Add variances as `with_more` does, and keep the result."""
        self.common = self.with_more(place, yaw)

    def correct(self, place: float, yaw: float) -> None:
        """Reset the error, once certain people corrected it, to the variances ``place`` in m² and ``yaw`` in rad²."""
        now, across, before, _ = self.common
        gain = 1.0 - place / now
        self.common = self._limited(place, (1.0 - gain) * across, before - gain * across**2 / now, yaw)

    def reduce(self, kept: FloatArray) -> None:
        """Scale the covariance after a correction: the share ``kept`` [3, 3] of the error (x, y, yaw) remains."""
        now, across, before, yaw = self.common
        place, turned = variances(kept @ np.diag((now, now, yaw)) @ kept.T)
        share = math.sqrt(min(place / now, 1.0)) if now > 0.0 else 1.0
        self.common = self._limited(share**2 * now, share * across, before, turned)

    def cover(self, pose: FloatArray, people: FloatArray, here: FloatArray, places: FloatArray) -> None:
        """Add the drift to covariances, in place: ``pose`` [3, 3] at ``here``, ``people`` [K, 2, 2] at ``places``."""
        now, yaw = self.common.now, self.common.yaw
        pose += np.diag((now, now, yaw))
        lever = np.column_stack((here[1] - places[:, 1], places[:, 0] - here[0]))
        people += now * np.eye(2) + yaw * lever[:, :, None] * lever[:, None, :]

    def _know(self, history: History, dt: float) -> None:
        """Poses of t−2 and t−1 that are given have no error, and show how fast the observer is."""
        before_given, last_given = history.pose_given[:2]
        if last_given:
            self._seconds, self.common = 0.0, Common(0.0, 0.0, self.common.before, 0.0)
        if before_given:
            self.common = self.common._replace(across=0.0, before=0.0)
        if before_given and last_given:
            speed = math.dist(history.poses[0, :2], history.poses[1, :2]) / dt
            self.top_speed = max(self.top_speed, FASTER * speed)

    def _limited(self, now: float, across: float, before: float, yaw: float) -> Common:
        """The covariance, limited by how far the observer can have moved and turned since its pose was given."""
        far = min(UNKNOWN_PLACE, self.top_speed * self._seconds) ** 2
        now, before = min(max(now, 0.0), far), min(max(before, 0.0), far)
        limit = math.sqrt(now * before)
        return Common(now, min(max(across, -limit), limit), before, min(yaw, UNKNOWN_YAW**2))


def held(place: FloatArray, last: FloatArray, reach: float) -> FloatArray:
    """The place [2] in m, moved to within ``reach`` m of ``last`` [2]."""
    step = place - last
    length = float(np.hypot(*step))
    return place if not length > reach else np.asarray(last + step * (reach / length))


def jumped(positions: FloatArray, history: History, reach: float) -> BoolArray:
    """Mask [K] of ``positions`` [K, 2] in m that are not given, and further than ``reach`` m from those at t−1."""
    step = np.hypot(*(positions - history.positions[1]).T)
    leaping: BoolArray = (step > reach) & ~history.position_given[2]
    return leaping
