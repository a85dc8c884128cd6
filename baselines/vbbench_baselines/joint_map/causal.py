"""``map-causal``: the joint problem over a sliding window, solved in each frame; only the newest is reported."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from vbbench.protocol import START_FRAMES
from vbbench.sequence import Given
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common.sightings import Sightings
from vbbench_baselines.common.uncertainty import linearise_people, position_covariances
from vbbench_baselines.joint_map.measurement.boxes import BoxHeights, Eye, statures_of
from vbbench_baselines.joint_map.measurement.window import Window
from vbbench_baselines.joint_map.motion.learning import nothing_learned
from vbbench_baselines.joint_map.motion.walks import walk_of
from vbbench_baselines.joint_map.one_step import PAST, Located, locate
from vbbench_baselines.joint_map.optimiser.covariance import place_covariances, pose_covariance_of
from vbbench_baselines.joint_map.optimiser.descent import Settled
from vbbench_baselines.joint_map.optimiser.marginalisation import NOTHING_KEPT, anchor_of, marginalise, settle_anchored
from vbbench_baselines.joint_map.optimiser.state import JointProblem
from vbbench_baselines.joint_map.prior import Prior, get_prior, variants_held_out

CROWD = 30
"""A sequence with more tracks is a crowd."""

CROWDED_WINDOW = 8
"""Frames that suffice in a crowd, where many people constrain the poses."""


@dataclass(kw_only=True)
class MapCausal:
    """Joint maximum a posteriori, causal.

    Parameters
    ----------
    prior : how people walk.
    ego_prior : whether the observer is expected to walk like the others; off for robots.
    feet : whether a box's bottom gives its distance; otherwise its height does.
    learns : whether the true past that one-step gives also teaches how people walk.
    window : frames that are solved together; in crowds no more than `CROWDED_WINDOW`.
    rounds : maximum number of descent steps per frame.
    tolerance, certain : in m and rad, and in standard deviations; the descent ends with a step shorter than either.
    """

    held_out: ClassVar[Mapping[str, str]] = variants_held_out("Causal")
    """Variants with a prior that never saw the split."""

    prior: Prior = field(default_factory=lambda: get_prior("default"))
    ego_prior: bool = True
    feet: bool = True
    learns: bool = True
    window: int = 12
    rounds: int = 30
    tolerance: float = 1e-3
    certain: float = 0.05

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        people = len(problem.tracks)
        self._eye, self._heights = Eye(problem, self.feet), BoxHeights(problem)
        self._walk = walk_of(self.prior, problem.dt, self.ego_prior)
        self.statures = statures_of(problem, self.feet)
        self._size = min(self.window, CROWDED_WINDOW) if people > CROWD else self.window
        self._rows = Window(self._size, people)
        self._lessons = nothing_learned(people, self._walk)
        self._kept = NOTHING_KEPT
        self._covariances = problem.covariances

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        answer = self.advance(self._eye.sight(frame.observations), frame.given)
        if not self.feet:
            return answer
        self._heights.learn(frame.observations)
        return replace(answer, **self._heights.report())

    def advance(self, seen: Sightings, given: Given) -> FrameEstimate:
        """The answer for the next frame, from the rays of its boxes and what `Frame.given` holds."""
        rows = self._rows
        rows.push(seen, self.statures, given)
        past, learns = slice(-1 - PAST, -1), self.learns and not math.isnan(rows.given_poses[-2, 0])
        known = rows.places[past], rows.poses[past], rows.given[-1], rows.given_poses[-1]
        located = locate(seen, self.statures, *known, self._walk, self._lessons, learns)
        rows.poses[-1], rows.places[-1] = located.pose, located.places
        if rows.frames > START_FRAMES and math.isnan(rows.given_poses[-3, 0] + rows.given_poses[-2, 0]):
            return self._settle()
        report = self._report_located(located) if self._covariances else {}
        return FrameEstimate(pose=located.pose, positions=located.places, converged=True, **report)

    def _settle(self) -> FrameEstimate:
        """Solve the window, and keep the information of the frame that leaves it next."""
        rows = self._rows
        used = rows.filled
        poses = rows.poses[used]
        anchor = anchor_of(~np.isnan(rows.given_poses[used, 0]), poses, self._kept)
        problem = JointProblem(rows.measurements(self.statures), anchor, self._walk)
        ends = self.rounds, self.tolerance, self.certain
        settled, problem = settle_anchored(poses, rows.places[used], problem, ends)
        rows.poses[used], rows.places[used] = settled.state.poses, settled.state.places
        self._lessons.variances[:] = settled.state.variances
        if rows.frames >= self._size:
            self._kept = marginalise(settled.state, problem, 1)
        pose, places = rows.poses[-1].copy(), rows.places[-1].copy()
        report = self._report_settled(settled, problem) if self._covariances else {}
        return FrameEstimate(pose=pose, positions=places, converged=bool(settled.converged), **report)

    def _report_located(self, located: Located) -> dict[str, Any]:
        pose, factors, sigma = located.pose, located.factors, np.zeros((3, 3))
        if np.isnan(self._rows.given_poses[-1, 0]):
            _, hessian = linearise_people(pose, factors)
            sigma[:] = np.linalg.inv(hessian + located.own)
        return {"pose_covariance": sigma, "position_covariances": position_covariances(pose, sigma, factors)}

    def _report_settled(self, settled: Settled, problem: JointProblem) -> dict[str, Any]:
        sigma, newest = pose_covariance_of(settled.state, problem), len(settled.state.poses) - 1
        places = place_covariances(settled.state, self._walk, sigma, newest)[newest]
        return {"pose_covariance": sigma[-3:, -3:].copy(), "position_covariances": places}
