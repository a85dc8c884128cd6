"""``cv`` and ``sf``: baselines that continue the past and hardly look at the picture.

Everybody, the observer included, walks on; boxes say only who is there. People of whom no position is known are placed
on the ray of their box at the mean height, as seen from the extrapolated pose.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.geometry import relative_to_world
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common.motion import History
from vbbench_baselines.motion_models import MotionModel, SocialForceWalk, Spreads, StraightWalk, expect


class ConstantVelocity:
    """x = 2x' − x''; people of whom one past position is known stay; the observer's yaw is held."""

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self._problem = problem
        self._history = History(len(problem.tracks))

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        history = self._history
        history.advance(frame.given)
        pose, positions = self._continue(history)
        measured = self._measure(frame.observations, np.where(np.isnan(history.poses[2]), pose, history.poses[2]))
        positions = np.where(np.isnan(positions), measured, positions)
        positions[np.isnan(frame.observations[:, 2])] = np.nan
        return history.store(pose, positions)

    def _continue(self, history: History) -> tuple[FloatArray, FloatArray]:
        """Pose [3] and positions [K, 2] at t, NaN = never known."""
        everybody = np.ones(history.positions.shape[1], np.bool_)
        expected = expect(self.model(), history, everybody, _EXACT, self._problem.dt)
        return expected.walk, expected.people

    def model(self) -> MotionModel:
        """How people walk."""
        return StraightWalk()

    def _measure(self, observations: FloatArray, pose: FloatArray) -> FloatArray:
        heights = np.full(len(observations), self._problem.height_mean)
        return relative_to_world(self._problem.camera.unproject(observations, heights), pose)


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


_EXACT = Spreads(motion=0.0, stay=0.0, estimate=0.0)
