"""What a frame-by-frame solver remembers, where it expects people and the observer next, and what odometry measures.

Constant velocity: x = x' + κ(x' − x''), κ = 1 (arXiv 2111.05060, eq. 10), or less after a cold start. Its error has the
variance σ_m² + σ_e²(4e' + e''), σ_m being the motion's, σ_e that of the solver's own estimates, and e', e'' one where
the past position is such an estimate and zero where it was given.

Odometry measures the observer's motion m = (forward, left, turn) in the axes of the frame before, with covariance C.
Where C is small (`SURE`), the pose to which m leads replaces the priors of the observer's motion and yaw, which are
far less certain and, for a robot, wrong; elsewhere it counts in addition to them.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.sequence import Given, Odometry
from vbbench.solver import FrameEstimate


class History:
    """The window of two past frames (arXiv 2111.05060, section IV) and the present one, rows t−2, t−1, t.

    What is given overwrites the solver's own estimates, however late it comes.

    Attributes
    ----------
    poses : [3, 3] (x, y, yaw) in m and rad, NaN = unknown.
    positions : [3, K, 2] in m, NaN = unknown.
    pose_given : [3] whether the pose was given.
    position_given : [3, K] whether the position was given.
    cold : whether nothing but the pose of frame 0 is given (`common.cold_start`).
    age : frames since frame 0.
    unmeasured : whether odometry lacks the step into the newest frame.
    seen : [K] who has a box at t; set by the solver.
    moving : whether a person seen twice has shown how the observer moves; set by the solver.
    blind : frames since a person was of use for the pose; set by the solver.
    """

    def __init__(self, people: int) -> None:
        self.cold, self.moving, self.unmeasured, self.age, self.blind = False, False, False, -1, 0
        self.seen: BoolArray = np.zeros(people, np.bool_)
        self.poses: FloatArray = np.full((3, 3), np.nan)
        self.positions: FloatArray = np.full((3, people, 2), np.nan)
        self.pose_given: BoolArray = np.zeros(3, np.bool_)
        self.position_given: BoolArray = np.zeros((3, people), np.bool_)

    def advance(self, given: Given) -> None:
        """Move on by one frame; row t then holds only what is given at t."""
        self.age += 1
        measured = given.odometry is not None and np.isfinite(given.odometry.motions[-1]).all()
        self.unmeasured = self.age > 0 and not measured
        # Only frame 1 shows a cold start: every other protocol gives its pose.
        self.cold = self.cold or (self.age == 1 and math.isnan(given.poses[-1, 0]))
        for rows in (self.poses, self.positions, self.pose_given, self.position_given):
            rows[:2] = rows[1:]
        self.poses[2] = self.positions[2] = np.nan
        self.pose_given[2] = self.position_given[2] = False
        for rows, given_rows, shown in (
            (self.poses, self.pose_given, given.poses),
            (self.positions, self.position_given, given.positions),
        ):
            known = ~np.isnan(shown)
            np.copyto(rows, shown, where=known)
            given_rows |= known[..., -1]

    @property
    def new(self) -> BoolArray:
        """[K] who is known from t−1 on."""
        return np.isnan(self.positions[0, :, 0]) & ~np.isnan(self.positions[1, :, 0])

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people, of whom nothing is known."""
        self.positions[:, columns] = np.nan
        self.position_given[:, columns] = False

    def correct(self, pose: FloatArray, found: FloatArray, earlier: float, *, turn: bool) -> None:
        """Correct the solver's own estimates of t−2 and t−1 by a share of the error at t.

        Parameters
        ----------
        pose, found : [3] the pose that they predict at t, and the corrected one.
        earlier : the share of the error that existed at t−1.
        turn : whether the yaw is corrected, too, because people determine it.
        """
        angle = found[2] - pose[2] if turn else 0.0
        sin, cos = np.sin(angle), np.cos(angle)
        rotation = np.array(((cos, -sin), (sin, cos)))
        for row, share in ((0, 2.0 * earlier - 1.0), (1, earlier)):
            moved = pose[:2] + share * (found[:2] - pose[:2])
            own = ~self.position_given[row]
            self.positions[row, own] = (self.positions[row, own] - pose[:2]) @ rotation.T + moved
            if not self.pose_given[row]:
                self.poses[row, :2] = rotation @ (self.poses[row, :2] - pose[:2]) + moved
                self.poses[row, 2] += angle

    def slow_down(self, share: float) -> None:
        """Scale the observer's motion from t−2 to t−1 by the ``share``."""
        if not self.pose_given[0]:
            self.poses[0, :2] = self.poses[1, :2] + share * (self.poses[0, :2] - self.poses[1, :2])

    def store(self, pose: FloatArray, positions: FloatArray, **report: Any) -> FrameEstimate:
        """Keep pose [3] and positions [K, 2] as frame t's estimate where nothing is given.

        What is kept is returned, together with the other fields of `vbbench.estimate.FrameEstimate` in ``report``.
        """
        for row, values in ((self.poses[2], pose), (self.positions[2], positions)):
            np.copyto(row, values, where=np.isnan(row))
        return FrameEstimate(pose=self.poses[2].copy(), positions=self.positions[2].copy(), **report)


class Spreads(NamedTuple):
    """Standard deviations in m of walks about their expectation.

    Attributes
    ----------
    motion : σ_m, about the expectation of a model.
    stay : about the one known past position, for each frame since.
    estimate : σ_e, of the solver's own past positions.
    reach : how far a person gets in a frame; a track that moved further has switched to another person.
    """

    motion: float
    stay: float
    estimate: float
    reach: float = np.inf


SMALLEST = 1e-6
"""Least standard deviation in m and rad of a measured motion: what is said to be exact must not divide by zero."""

SURE = 0.3
"""In m and rad a frame: a motion measured with smaller standard deviations replaces the priors of walk and head."""


class MeasuredPose(NamedTuple):
    """The newest pose by odometry from the pose before.

    Attributes
    ----------
    pose : [3] (x, y, yaw) in m and rad.
    std : standard deviation of the place in m, equal on both axes.
    facing : information in 1/rad² on the yaw.
    """

    pose: FloatArray
    std: float
    facing: float


def newest_measured(odometry: Odometry | None, before: FloatArray) -> MeasuredPose | None:
    """The newest pose by ``odometry`` from the pose ``before`` [3]; ``None`` if odometry measured nothing."""
    if odometry is None:
        return None
    moved, spread = odometry.motions[-1], odometry.covariances[-1]
    if not (np.isfinite(moved).all() and np.isfinite(spread).all()) or np.isnan(before).any():
        return None
    std = np.sqrt(0.5 * (spread[0, 0] + spread[1, 1]) + SMALLEST**2)
    (x, y, yaw), (forward, left, turn) = before.tolist(), moved.tolist()
    cos, sin = math.cos(yaw), math.sin(yaw)
    pose = np.array((x + (cos * forward - sin * left), y + (sin * forward + cos * left), yaw + turn))
    return MeasuredPose(pose, float(std), float(1.0 / (spread[2, 2] + SMALLEST**2)))
