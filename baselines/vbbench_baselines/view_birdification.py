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
from vbbench_baselines.common.cold_start import add_drift, kept_velocities
from vbbench_baselines.common.drift import ASTRAY, TURN, Drift
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
        self._drift = Drift()

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
        factors = self._expected(*measure(self._seen, heights.mean, heights.variance), chosen)
        told = told_by(frame.given.odometry, history.poses[1])
        self._drift.advance(history, self._kept(), self._dt, measured=told is not None)
        helpful = factors.helpful & chosen
        few = np.count_nonzero(helpful) < FEWEST
        history.moving = history.moving or bool(helpful.any())
        fallback = bool(few) and not history.pose_given[2]
        lost = self._drift.lost and not history.pose_given[2] and not history.cold
        facing = 1.0 / (TURN**2 * self._dt) if lost and few else VAGUE
        if lost and (helpful & history.position_given[2]).any() and self._contradicted(factors, helpful, facing):
            factors, facing = self._reanchor(factors, helpful, chosen, facing)
        elif not self.ego_prior and not fallback:
            factors = factors._replace(walk_std=np.inf)
        factors, facing = _with_odometry(factors, told, facing)
        self._confident = factors.expected, np.where(factors.std <= self.confident_std, factors.std, np.nan)
        answer = self._minimise(Task(history.poses[2], factors.of(chosen), self._seen.rays[chosen], facing))
        positions = localise(answer.pose, factors)
        positions[chosen] = answer.positions
        self._tangent = answer.tangent
        report = self._report(answer, factors, chosen)
        return history.store(answer.pose, positions, fallback=fallback, **report)

    def _kept(self) -> float:
        """The share of the observer's velocity that is expected to last."""
        history = self._history
        return kept_velocities(self._dt, bool(history.seen.any()))[1] if history.cold else 1.0

    def _expected(self, relative: FloatArray, covariance: FloatArray, chosen: BoolArray) -> Factors:
        """The terms of all people: where boxes place them, with the covariance, and where they are expected."""
        return Factors(relative, covariance, *expect(self.model(), self._history, chosen, self._spreads, self._dt))

    def _contradicted(self, factors: Factors, helpful: BoolArray, facing: float) -> bool:
        """Whether people whose places are given are seen where the others say they cannot be."""
        anchors = helpful & self._history.position_given[2]
        if not (helpful & ~anchors).any():
            return True
        pose = fit_pose(factors.of(helpful), facing)
        placed = localise(pose, factors.of(anchors)._replace(std=np.full(np.count_nonzero(anchors), np.nan)))
        covariance = factors.covariance[anchors]
        noise = np.sqrt(covariance[:, 0] + covariance[:, 2])
        off = np.hypot(*(placed - factors.expected[anchors]).T)
        return bool((off > ASTRAY + 3.0 * noise).any())

    def _reanchor(
        self, factors: Factors, helpful: BoolArray, chosen: BoolArray, facing: float
    ) -> tuple[Factors, float]:
        """The terms once the past is where those say whose places are given, and the information on the yaw.

        Parameters
        ----------
        helpful, chosen : [K] who is seen and expected, and who takes part.
        facing : information in 1/rad² on the yaw, as far as few people are seen.
        """
        history, drift = self._history, self._drift
        anchors = helpful & history.position_given[2]
        others = helpful & ~anchors
        led, facing = factors.walk, facing
        if others.any():
            relative = factors.of(others)
            led = fit_pose(relative, facing)
            sigma = pose_covariance(led, relative, facing)
            drift.add(*_variances(sigma))
        else:
            drift.add(self._spreads.motion**2, TURN**2 * self._dt)
        common = drift.common
        known = factors.of(anchors)._replace(walk=led, walk_std=drift.std)
        found = fit_pose(known, 1.0 / common.yaw)
        place, yaw = _variances(pose_covariance(found, known, 1.0 / common.yaw))
        history.correct(led, found, common.across / common.now, turn=bool(others.any()))
        drift.correct(1.0 - place / common.now, place, yaw)
        renewed = self._expected(factors.relative, factors.covariance, chosen)
        return renewed._replace(walk=found, walk_std=np.sqrt(place)), 1.0 / yaw

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
        """What is reported besides pose and positions; the drift goes on by what this frame does not know."""
        known = {"heights": self._heights.mean.copy(), "height_variances": self._heights.variance.copy()}
        history, drift = self._history, self._drift
        pose = np.zeros((3, 3))
        if not history.pose_given[2]:
            pose = pose_covariance(answer.pose, answer.curved)
        known["converged"] = not drift.lost
        std0 = factors.std.copy()
        std0[chosen] = answer.curved.std
        if self._covariances:
            std = factors.std.copy()
            std[chosen] = answer.curved.std
            people = position_covariances(answer.pose, pose, factors._replace(std=std))
            here, places = answer.pose, localise(answer.pose, factors)
            shown = pose.copy()
            drift.cover(shown, people, here, places)
            if history.cold:
                add_drift(shown, people, np.array(history.unmeasured * self._dt))
            known |= {"pose_covariance": shown, "position_covariances": people}
        if not history.pose_given[2]:
            anchors = factors.helpful & chosen & history.position_given[2]
            if anchors.any():
                loose = factors._replace(std=np.where(anchors, np.nan, std0))
                without, with_them = _variances(pose_covariance(answer.pose, loose)), _variances(pose)
                gain = min(max(1.0 - with_them[0] / without[0], 0.0), 1.0)
                turned = min(max(1.0 - with_them[1] / without[1], 0.0), 1.0)
                drift.settle(gain, turned)
            if (factors.helpful & chosen).any():
                if not history.cold: drift.add(*_variances(pose))
            else:
                drift.add(self._spreads.motion**2, TURN**2 * self._dt)
        return known


def _variances(covariance: FloatArray) -> tuple[float, float]:
    """Of a pose's place, in the mean of all directions, and of its yaw, by its covariance [3, 3]."""
    return float(0.5 * (covariance[0, 0] + covariance[1, 1])), float(covariance[2, 2])


def _with_odometry(factors: Factors, told: Told | None, facing: float) -> tuple[Factors, float]:
    """The terms with what odometry tells, if surely, in place of the walk, and the information in 1/rad² on the yaw.

    ``facing``: that without odometry.
    """
    if told is None:
        return factors, facing
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
