"""What a frame-by-frame solver remembers: poses and positions at t−2, t−1 and t."""

from typing import Any

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.sequence import Given
from vbbench.solver import FrameEstimate


class History:
    """The window of two past frames (arXiv 2111.05060, section IV) and the present one, rows t−2, t−1, t.

    Whatever is given overwrites the solver's own estimates: truth beats estimate, however late it comes.

    Attributes
    ----------
    poses : [3, 3] (x, y, yaw) in m and rad, NaN = unknown.
    positions : [3, K, 2] in m, NaN = unknown.
    pose_given : [3] whether the pose was given.
    position_given : [3, K] whether the position was given.
    """

    def __init__(self, people: int) -> None:
        self.poses: FloatArray = np.full((3, 3), np.nan)
        self.positions: FloatArray = np.full((3, people, 2), np.nan)
        self.pose_given: BoolArray = np.zeros(3, np.bool_)
        self.position_given: BoolArray = np.zeros((3, people), np.bool_)

    def advance(self, given: Given) -> None:
        """Move on by one frame; row t then holds what is given at t, and nothing else."""
        for rows in (self.poses, self.positions, self.pose_given, self.position_given):
            rows[:2] = rows[1:]
        self.poses[2] = self.positions[2] = np.nan
        self.pose_given[2] = self.position_given[2] = False
        self._merge(given)

    def _merge(self, given: Given) -> None:
        known = ~np.isnan(given.positions)
        np.copyto(self.positions, given.positions, where=known)
        self.position_given |= known[..., 0]
        known = ~np.isnan(given.poses)
        np.copyto(self.poses, given.poses, where=known)
        self.pose_given |= known[:, 2]

    def store(self, pose: FloatArray, positions: FloatArray, **report: Any) -> FrameEstimate:
        """Keep pose [3] and positions [K, 2] as frame t's estimate where nothing is given.

        What is kept is returned, together with the other fields of `vbbench.estimate.FrameEstimate` in ``report``.
        """
        for row, values in ((self.poses[2], pose), (self.positions[2], positions)):
            np.copyto(row, values, where=np.isnan(row))
        return FrameEstimate(pose=self.poses[2].copy(), positions=self.positions[2].copy(), **report)
