"""``cv`` and ``sf``: baselines that continue the past and hardly look at the picture.

Everybody, the observer included, walks on; boxes say only who is there. People of whom no position is known are placed
on the ray of their box at the mean height, as seen from the extrapolated pose.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.geometry import relative_to_world
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.history import History
from vbbench_baselines.motion import continue_observer, continue_people
from vbbench_baselines.social_force import adapt_velocities


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
        pose, _ = continue_observer(history.poses, history.pose_given, 0.0, 0.0)
        positions, _ = continue_people(history.positions, history.position_given, 0.0, 0.0, 0.0)
        return pose, positions

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

    def _continue(self, history: History) -> tuple[FloatArray, FloatArray]:
        pose, positions = super()._continue(history)
        dt = self._problem.dt
        before, last = (np.concatenate((history.positions[row], history.poses[row : row + 1, :2])) for row in (0, 1))
        change = adapt_velocities(last, (last - before) / dt, self.radius, dt / self.relaxation) * dt
        pose[:2] += change[-1]
        return pose, np.where(np.isnan(history.positions[2]), positions + change[:-1], positions)
