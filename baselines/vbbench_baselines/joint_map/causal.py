"""``map-causal``: the joint problem over a sliding window, solved anew with every frame; only the newest is reported."""

from dataclasses import dataclass, field

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.protocol import START_FRAMES
from vbbench.sequence import Given
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.joint_map.descent import Settled, settle
from vbbench_baselines.joint_map.leaving import NOTHING_LEFT, hold, leave
from vbbench_baselines.joint_map.one_step import PAST, fit_robustly, foresee_all, learn_scales
from vbbench_baselines.joint_map.prior import Prior, get_prior
from vbbench_baselines.joint_map.sighted import FLOOR, sight_boxes, statures_of
from vbbench_baselines.joint_map.walks import walk_of
from vbbench_baselines.joint_map.window import Window
from vbbench_baselines.sightings import Sightings, measure


@dataclass(kw_only=True)
class MapCausal:
    """Joint maximum a posteriori, causal.

    Parameters
    ----------
    prior : how people walk.
    feet : whether boxes tell their distance by their bottom, else by their height.
    window : frames that are solved together.
    rounds : most steps of the descent a frame.
    tolerance : in m and rad; the descent ends with a step shorter than this.
    """

    prior: Prior = field(default_factory=lambda: get_prior("default"))
    feet: bool = True
    window: int = 12
    rounds: int = 12
    tolerance: float = 1e-3

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        people = len(problem.tracks)
        self._problem = problem
        self._walk = walk_of(self.prior, problem.dt)
        self.statures = statures_of(problem, self.feet)
        self._rows = Window(self.window, people)
        self._scales = np.zeros((people + 1, 2))
        self._variances = np.full(people + 1, self._walk.sigma**2)
        self._left = NOTHING_LEFT

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        return self.advance(sight_boxes(self._problem, frame.observations, self.feet), frame.given)

    def advance(self, seen: Sightings, given: Given) -> FrameEstimate:
        """The answer for the next frame, of which are known the rays of its boxes and what `Frame.given` holds."""
        rows = self._rows
        rows.push(seen, self.statures, given)
        pose, places, _spread, _own = self._foresee(seen)
        rows.poses[-1], rows.places[-1] = pose, places
        if rows.frames > START_FRAMES and np.isnan(rows.given_poses[-3:-1, 0]).any():
            self._settle()
        return FrameEstimate(pose=rows.poses[-1].copy(), positions=rows.places[-1].copy())

    def _foresee(self, seen: Sightings) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """The newest frame's pose and places by what was known before it."""
        rows = self._rows
        relative, covariance = measure(*seen, self.statures.mean, self.statures.variance)
        covariance[:, 0] += FLOOR**2
        covariance[:, 2] += FLOOR**2
        past = slice(-1 - PAST, -1)
        if not np.isnan(rows.given_poses[-2, 0]):
            learn_scales(rows.places[past], rows.poses[past], self._walk, self._scales, self._variances)
        expected = foresee_all(rows.places[past], rows.poses[past], rows.given[-1], self._walk, self._variances)
        return fit_robustly(relative, covariance, *expected, rows.given_poses[-1], self._walk.nu, 8)

    def _settle(self) -> Settled:
        """Solve the window, and keep what the frame that leaves it next has said."""
        rows = self._rows
        used = rows.filled
        poses, scene = rows.poses[used], rows.scene(self.statures)
        anchor = hold(~np.isnan(rows.given_poses[used, 0]), poses, self._left)
        settled = settle(poses, rows.places[used], scene, anchor, self._walk, self.rounds, self.tolerance)
        rows.poses[used], rows.places[used] = settled.poses, settled.places
        self._variances = settled.variances
        if rows.frames >= self.window:
            self._left = leave(settled, anchor, self._walk, 1)
        return settled
