"""``vb-cv``: view birdification with constant-velocity motion (VB-CV of arXiv 2111.05060)."""

from dataclasses import dataclass

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.ego_motion import fit_pose
from vbbench_baselines.heights import Heights
from vbbench_baselines.history import History
from vbbench_baselines.localisation import localise
from vbbench_baselines.location import location_energies
from vbbench_baselines.motion import continue_observer, continue_people
from vbbench_baselines.sightings import measure, sight


@dataclass(kw_only=True)
class ConstantVelocityBirdifier:
    """The paper's cascade, frame by frame: first the pose from everybody at once, then everybody from the pose.

    ``docs/solvers.md`` shows the equations and how the defaults were chosen.

    Parameters
    ----------
    ego_prior : whether the observer is expected to walk on at constant velocity, too; off for robots.
    acceleration_std : of people and observer, in m/s²; the standard deviation about 2x' − x'' is this times dt².
    speed_std : in m/s, of each component; times dt, the deviation of people of whom one past position is known.
    estimate_std : in m, of the solver's own past positions, where it has to stand on them.
    height_limits : range of plausible heights in m.
    pose_std : in m; what the solver's own poses add to the error of heights that are learned from them.
    """

    ego_prior: bool = True
    acceleration_std: float = 0.6
    speed_std: float = 0.9
    estimate_std: float = 0.05
    height_limits: tuple[float, float] = (1.4, 2.0)
    pose_std: float = 0.02

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        people = len(problem.tracks)
        self._camera, self._pixel_std = problem.camera, problem.pixel_std
        self._motion_std = self.acceleration_std * problem.dt**2
        self._stay_std = self.speed_std * problem.dt
        self._history = History(people)
        self._heights = Heights(people, problem.height_mean, problem.height_std, self.height_limits, self.pose_std)
        self._seen = sight(problem.camera, np.full((people, 3), np.nan), 0.0)

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        history, heights = self._history, self._heights
        history.advance(frame.given)
        heights.learn(history, self._seen)
        self._seen = sight(self._camera, frame.observations, self._pixel_std)
        measured = measure(*self._seen, heights.mean, heights.variance)
        motion = self._motion_std, self._stay_std, self.estimate_std
        expected = continue_people(history.positions, history.position_given, *motion)
        walk, std = continue_observer(history.poses, history.pose_given, self._motion_std, self.estimate_std)
        self._factors = (*measured, *expected, walk, std if self.ego_prior else np.inf)
        pose = history.poses[2] if history.pose_given[2] else fit_pose(*self._factors)
        return history.store(pose, localise(pose, *measured, *expected))

    def location_energy(self, places: FloatArray) -> FloatArray:
        """See `vbbench.solver.LocationPosterior.location_energy`; the yaw is minimised out."""
        return location_energies(np.ascontiguousarray(places), *self._factors)
