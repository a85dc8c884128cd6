"""``vb-cv``, and the cascade that it shares with ``vb-sf``: view birdification (arXiv 2111.05060), frame by frame.

First the pose from all people at once, then all people from the pose. Shared are the window, heights, measurements, the
selection of people in large crowds, and the report. A solver adds its motion model and how it minimises the energies;
``vb-cv`` (VB-CV, constant velocity) is the simplest.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.cascade.crowd_graph import select
from vbbench_baselines.cascade.heights import Heights
from vbbench_baselines.common.cold_start import add_drift
from vbbench_baselines.common.ego_motion import VAGUE, Factors, fit_pose, localise, location_energies
from vbbench_baselines.common.facts import TUNED
from vbbench_baselines.common.motion import History, Spreads
from vbbench_baselines.common.odometry import SURE, Told, told_by
from vbbench_baselines.common.sightings import measure, sight, usable
from vbbench_baselines.common.uncertainty import pose_covariance, position_covariances
from vbbench_baselines.motion_models import MotionModel, StraightWalk, expect

EVERYBODY = 1_000_000
"""More people than a picture ever shows."""

FEWEST = 2
"""With fewer usable people (seen, and with an expected place) the observer's own prior decides."""


class Task(NamedTuple):
    """What is to be minimised: the factors of the chosen people, with their rays [K, 2] (see `Sightings`).

    Attributes
    ----------
    pose : [3] the observer's pose where it is known, else NaN.
    facing : information in 1/rad² on the yaw that the factors expect of the observer.
    """

    pose: FloatArray
    factors: Factors
    rays: FloatArray
    facing: float = VAGUE


class Answer(NamedTuple):
    """Where the energy is least, and quadratic terms that approximate it there.

    Attributes
    ----------
    pose, positions : [3], and [K, 2] of the chosen people.
    curved : terms with the energy's mean curvature, for covariances.
    tangent : terms with the energy's minimum, for how it rises around it.
    """

    pose: FloatArray
    positions: FloatArray
    curved: Factors
    tangent: Factors


@dataclass(kw_only=True)
class Birdifier(ABC):
    """Base of the reference solvers; ``docs/reference-solver.md`` derives every term.

    Parameters
    ----------
    ego_prior : whether the observer is expected to walk like the others; off for robots.
    acceleration_std : of people and observer, in m/s²; the standard deviation about an expectation is this times dt².
    speed_std : in m/s, of each component; times dt, the deviation of people with one known past position.
    estimate_std : in m, of the solver's own past positions, where it depends on them.
    height_limits : range of plausible heights in m.
    pose_std : in m; what the solver's own poses add to the error of heights learned from them.
    confident_std : in m; heights are also learned from people whom the walk places this accurately.
    calibrate : whether heights are learned from given positions; otherwise everyone keeps the prior N(μ_h, σ_h²).
    most_people, smallest_box : if more people are seen, only those of greatest box height, above ``smallest_box`` px,
        decide the pose; the rest are localised from it. The pose takes time linear in their number, so by default
        everyone decides; 100 is the paper's selection.
    """

    facts: ClassVar[Mapping[str, str]] = TUNED

    ego_prior: bool = True
    acceleration_std: float = 0.6
    speed_std: float = 0.9
    estimate_std: float = 0.05
    height_limits: tuple[float, float] = (1.4, 2.0)
    pose_std: float = 0.02
    confident_std: float = 0.0
    calibrate: bool = True
    most_people: int = EVERYBODY
    smallest_box: float = 1.0

    @abstractmethod
    def _minimise(self, task: Task) -> Answer:
        """The pose, and the people's places given the pose, of least energy."""

    def model(self) -> MotionModel:
        """How people walk."""
        return StraightWalk()

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        people = len(problem.tracks)
        self._camera, self._pixel_std, self._dt = problem.camera, problem.pixel_std, problem.dt
        self._covariances = problem.covariances
        self._spreads = Spreads(
            motion=self.acceleration_std * problem.dt**2, stay=self.speed_std * problem.dt, estimate=self.estimate_std
        )
        self._history = History(people)
        self._heights = Heights(people, problem.height_mean, problem.height_std, self.height_limits, self.pose_std)
        self._seen = sight(problem.camera, np.full((people, 3), np.nan), 0.0)
        self._confident = np.full((people, 2), np.nan), np.full(people, np.nan)

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        history, heights = self._history, self._heights
        history.advance(frame.given)
        if self.calibrate:
            heights.learn(history, self._seen, *self._confident)
        observations = usable(frame.observations)
        history.seen = ~np.isnan(observations[:, 2])
        self._seen = sight(self._camera, observations, self._pixel_std)
        chosen = select(observations, self.most_people, self.smallest_box)
        relative, covariance = measure(self._seen, heights.mean, heights.variance)
        factors = Factors(relative, covariance, *expect(self.model(), history, chosen, self._spreads, self._dt))
        helpful = np.count_nonzero(~np.isnan(factors.std[chosen] + factors.relative[chosen, 0]))
        history.moving = history.moving or bool(helpful > 0)
        fallback = bool(helpful < FEWEST) and not history.pose_given[2]
        if not self.ego_prior and not fallback:
            factors = factors._replace(walk_std=np.inf)
        factors, facing = _with_odometry(factors, told_by(frame.given.odometry, history.poses[1]))
        self._confident = factors.expected, np.where(factors.std <= self.confident_std, factors.std, np.nan)
        answer = self._minimise(Task(history.poses[2], factors.of(chosen), self._seen.rays[chosen], facing))
        positions = localise(answer.pose, factors)
        positions[chosen] = answer.positions
        self._tangent = answer.tangent
        return history.store(answer.pose, positions, fallback=fallback, **self._report(answer, factors, chosen))

    def forget(self, columns: IntArray) -> None:
        """From the next frame on the ``columns`` [M] stand for new people, of whom nothing is known."""
        self._history.forget(columns)
        self._heights.forget(columns)
        for rows in (*self._seen, *self._confident):
            rows[columns] = np.nan

    def location_energy(self, places: FloatArray) -> FloatArray:
        """See `vbbench.solver.LocationPosterior.location_energy`; the yaw is minimised out."""
        return location_energies(np.ascontiguousarray(places), self._tangent)

    def _report(self, answer: Answer, factors: Factors, chosen: BoolArray) -> dict[str, Any]:
        """What is reported besides pose and positions."""
        known = {"heights": self._heights.mean.copy(), "height_variances": self._heights.variance.copy()}
        if not self._covariances:
            return known
        std = factors.std.copy()
        std[chosen] = answer.curved.std
        pose = np.zeros((3, 3))
        if not self._history.pose_given[2]:
            pose = pose_covariance(answer.pose, answer.curved)
        people = position_covariances(answer.pose, pose, factors._replace(std=std))
        if self._history.cold:
            add_drift(pose, people, np.array(self._history.unmeasured * self._dt))
        return {**known, "pose_covariance": pose, "position_covariances": people}


def _with_odometry(factors: Factors, told: Told | None) -> tuple[Factors, float]:
    """The terms with what odometry tells, if surely, in place of the walk, and the information in 1/rad² on the yaw."""
    if told is None:
        return factors, VAGUE
    if told.std < SURE:
        return factors._replace(walk=told.pose, walk_std=told.std), told.facing
    walked, measured = 1.0 / factors.walk_std**2, 1.0 / told.std**2
    pose = told.pose.copy()
    pose[:2] = (walked * factors.walk[:2] + measured * told.pose[:2]) / (walked + measured)
    return factors._replace(walk=pose, walk_std=float((walked + measured) ** -0.5)), told.facing


@dataclass(kw_only=True)
class ConstantVelocityBirdifier(Birdifier):
    """Squared norms about constant velocity, with both stages in closed form: no samples, no messages."""

    def _minimise(self, task: Task) -> Answer:
        factors = task.factors
        pose = fit_pose(factors, task.facing) if np.isnan(task.pose[2]) else task.pose
        return Answer(pose, localise(pose, factors), factors, factors)
