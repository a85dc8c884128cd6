"""``cv`` and ``sf``: baselines that continue the past and hardly look at the picture.

Everybody, the observer included, walks on; boxes say only who is there. People of whom no position is known are placed
on the ray of their box at the mean height, as seen from the extrapolated pose.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import relative_to_world
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common.motion import History, Spreads
from vbbench_baselines.motion_models import MotionModel, SocialForceWalk, StraightWalk, expect

EXACT = Spreads(motion=0.0, stay=0.0, estimate=0.0)
"""What is expected is the answer; how sure it is does not matter."""


class ConstantVelocity:
    """x = 2x' − x''; people of whom one past position is known stay; the observer's yaw is held."""

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self._problem = problem
        self._history = History(len(problem.tracks))

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        history, problem = self._history, self._problem
        history.advance(frame.given)
        everybody = np.ones(len(frame.observations), np.bool_)
        expected, _, walk, _ = expect(self.model(), history, everybody, EXACT, problem.dt)
        pose = np.where(np.isnan(history.poses[2]), walk, history.poses[2])
        boxes = problem.camera.unproject(frame.observations, np.full(len(everybody), problem.height_mean))
        positions = np.where(np.isnan(expected), relative_to_world(boxes, pose), expected)
        positions[np.isnan(frame.observations[:, 2])] = np.nan
        return history.store(walk, positions)

    def model(self) -> MotionModel:
        """How people walk."""
        return StraightWalk()


@dataclass(kw_only=True)
class SocialForce(ConstantVelocity):
    """Constant velocity, drawn towards the mean velocity w of everybody near: v ← v + dt (w − v)/η.

    The alignment term of arXiv 2111.05060 (eq. 11) in seconds; the observer is a walker like the others.

    Parameters
    ----------
    relaxation : η in s.
    radius : distance in m within which people at t−1 walk together.
    """

    relaxation: float = 0.5
    radius: float = 1.0

    def model(self) -> MotionModel:
        """How people walk."""
        return SocialForceWalk(relaxation=self.relaxation, radius=self.radius, implicit=False)
