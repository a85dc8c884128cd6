"""``vb-cv``, and the cascade that it shares with ``vb-sf``: view birdification (arXiv 2111.05060), frame by frame.

The cascade estimates first the pose from all people, then their places given the pose. A solver adds its motion model
and the minimisation of its energies; ``vb-cv`` (VB-CV, constant velocity) is the simplest.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines._core import fit_pose, localise, measure, pose_covariance, position_covariances
from vbbench_baselines.cascade import VAGUE, Company, Factors, Heights, can_anchor, company, reanchor, select
from vbbench_baselines.common import CASCADE
from vbbench_baselines.common.bearings import sight, usable
from vbbench_baselines.common.cold_start import OBSERVER_SPEED, Astray
from vbbench_baselines.common.drift import ACCELERATION, RUNNING, TURN, UNRELIABLE, Drift, held, jumped, variances
from vbbench_baselines.common.motion import SURE, History, MeasuredPose, Spreads, newest_measured
from vbbench_baselines.motion_models import MotionModel, StraightWalk, expect, kept_shares

EVERYBODY = 1_000_000
"""More people than a picture ever shows."""

FEWEST = 2
"""With fewer usable people (seen, and with an expected place) the observer's own prior decides."""


class Task(NamedTuple):
    """The minimisation of a frame: factors of the chosen people, with their rays [K, 2] (see `Sightings`).

    Attributes
    ----------
    pose : [3] the observer's pose where it is known, else NaN.
    facing : information in 1/rad² on the observer's predicted yaw.
    """

    pose: FloatArray
    factors: Factors
    rays: FloatArray
    facing: float = VAGUE


class Answer(NamedTuple):
    """The minimum of the energy, and its quadratic approximation.

    Attributes
    ----------
    pose, positions : [3], and [K, 2] of the chosen people.
    curved : terms with the energy's mean curvature, for covariances.
    """

    pose: FloatArray
    positions: FloatArray
    curved: Factors


@dataclass(kw_only=True)
class Birdifier(ABC):
    """Base of the reference solvers; ``docs/reference-solver.md`` derives every term.

    Parameters
    ----------
    ego_prior : whether the observer has the motion prior of a person; off for robots.
    acceleration_std : process noise of people and observer in m/s²; times dt², the standard deviation of a prediction.
    speed_std : in m/s, of each component; times dt, the deviation of people with one known past position.
    estimate_std : standard deviation in m of the solver's own past positions.
    height_limits : range of plausible heights in m.
    pose_std : in m; error of the solver's own poses in heights learned from them.
    calibrate : whether heights are learned from given positions; otherwise everyone keeps the prior N(μ_h, σ_h²).
    most_people, smallest_box : if more people are seen, only those of greatest box height, above ``smallest_box`` px,
        decide the pose; the rest are localised from it. The pose takes time linear in their number, so by default
        everyone decides; 100 is the paper's selection.
    """

    facts: ClassVar[Mapping[str, str]] = CASCADE

    ego_prior: bool = True
    acceleration_std: float = ACCELERATION
    speed_std: float = 0.9
    estimate_std: float = 0.05
    height_limits: tuple[float, float] = (1.4, 2.0)
    pose_std: float = 0.02
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
            motion=self.acceleration_std * problem.dt**2,
            stay=self.speed_std * problem.dt,
            estimate=self.estimate_std,
            reach=RUNNING * problem.dt,
        )
        self._history = History(people)
        self._heights = Heights(people, problem.height_mean, problem.height_std, self.height_limits, self.pose_std)
        self._seen = sight(problem.camera, np.full((people, 3), np.nan), 0.0)
        self._drift, self._astray = Drift(), Astray()
        self._odometry: MeasuredPose | None = None

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        history, heights = self._history, self._heights
        history.advance(frame.given)
        self._astray.wait(self._dt if history.unmeasured else 0.0)
        if self.calibrate:
            heights.learn(history, self._seen)
        observations = usable(frame.observations)
        history.seen = ~np.isnan(observations[:, 2])
        self._seen = sight(self._camera, observations, self._pixel_std)
        self._doubt_speed()
        chosen = select(observations, self.most_people, self.smallest_box)
        factors = self._expected(*measure(self._seen, heights.mean, heights.variance), chosen)
        measured = newest_measured(frame.given.odometry, history.poses[1])
        sure = measured is not None and measured.std < SURE
        self._odometry = measured
        self._drift.advance(history, kept_shares(history, self._dt)[1], self._dt, measured=sure)
        helpful = factors.helpful & chosen
        few = bool(np.count_nonzero(helpful) < FEWEST)
        history.moving = history.moving or bool(helpful.any())
        history.blind = 0 if helpful.any() else history.blind + 1
        fallback = few and not history.pose_given[2]
        people = company(history, helpful)
        factors, facing, found = self._find_again(factors, people, chosen, few)
        own_std = factors.walk_std
        if not (self.ego_prior or fallback or found):
            factors = factors._replace(walk_std=np.inf)
        factors, facing = _with_odometry(factors, measured, facing)
        task = Task(history.poses[2], factors.of(chosen), self._seen.rays[chosen], facing)
        answer, bounded = self._minimise(task), False
        if not (found or sure):
            answer, bounded = self._within_reach(answer, task, own_std)
        positions = localise(answer.pose, factors)
        positions[chosen] = answer.positions
        factors = self._begin_again(factors, answer.pose, positions)
        self._task = task
        certain = np.zeros_like(people.certain) if found else people.certain
        report = self._report(answer, factors, chosen, certain, bounded=bounded)
        return history.store(answer.pose, positions, fallback=fallback, **report)

    def _expected(self, relative: FloatArray, covariance: FloatArray, chosen: BoolArray) -> Factors:
        """The terms of all people: places ``relative`` by boxes, their ``covariance``, and the predictions."""
        expected, std, walk, walk_std = expect(self.model(), self._history, chosen, self._spreads, self._dt)
        walk[:2] = held(walk[:2], self._history.poses[1, :2], self._drift.top_speed * self._dt)
        return Factors(relative, covariance, expected, std, walk, walk_std)

    def _doubt_speed(self) -> None:
        """Reduce the observer's velocity where it is poorly known and nobody is left to observe it."""
        history, variance = self._history, self._drift.speed_variance(self._dt)
        known = history.seen & ~np.isnan(history.positions[..., 0]).all(axis=0)
        if history.blind == 0 and not known.any() and variance > 1.0 and not history.cold:
            history.slow_down(OBSERVER_SPEED**2 / (OBSERVER_SPEED**2 + variance))

    def _alone(self) -> tuple[float, float]:
        """Variances in m² and rad² of the observer's motion within a frame without usable people."""
        measured, turns = self._odometry, 1.0 / (TURN**2 * self._dt)
        if measured is None:
            return self._spreads.motion**2, 1.0 / turns
        return measured.std**2 if measured.std < SURE else self._spreads.motion**2, 1.0 / (turns + measured.facing)

    def _find_again(
        self, factors: Factors, people: Company, chosen: BoolArray, few: bool
    ) -> tuple[Factors, float, bool]:
        """The terms, the information in 1/rad² on the yaw, and whether certain people re-anchored a lost observer."""
        history, drift = self._history, self._drift
        if drift.std <= UNRELIABLE or history.cold or history.pose_given[2]:
            return factors, VAGUE, False
        facing = 1.0 / (TURN**2 * self._dt) if few else VAGUE
        if not can_anchor(people):
            return factors, facing, False
        found = reanchor(history, drift, factors, people, facing, self._alone())
        if found is None:
            return factors, facing, False
        renewed = self._expected(factors.relative, factors.covariance, chosen)
        return renewed._replace(walk=found, walk_std=drift.std), 1.0 / drift.common.yaw, True

    def _within_reach(self, answer: Answer, task: Task, own_std: float) -> tuple[Answer, bool]:
        """The answer, its pose limited to a person's reach from the predicted one, and whether the limit applied."""
        last, reach = self._history.poses[1], self._drift.top_speed * self._dt
        if not np.isnan(task.pose[2]) or not np.hypot(*(answer.pose - last)[:2]) > reach:
            return answer, False
        task = task._replace(factors=task.factors._replace(walk_std=own_std), facing=1.0 / (TURN**2 * self._dt))
        answer = self._minimise(task)
        place = held(answer.pose[:2], last[:2], reach)
        self._drift.add(float(np.sum((answer.pose[:2] - place) ** 2)) + reach**2, TURN**2 * self._dt)
        return self._minimise(task._replace(pose=np.append(place, answer.pose[2]))), True

    def _begin_again(self, factors: Factors, pose: FloatArray, positions: FloatArray) -> Factors:
        """Place people faster than a running speed by the box alone; return the terms without their predictions."""
        leaping = jumped(positions, self._history, self._spreads.reach)
        if leaping.any():
            self._history.forget(np.flatnonzero(leaping))
            factors = factors._replace(std=np.where(leaping, np.nan, factors.std))
            positions[leaping] = localise(pose, factors)[leaping]
        return factors

    def forget(self, columns: IntArray) -> None:
        """From the next frame on the ``columns`` [M] stand for new people, of whom nothing is known."""
        self._history.forget(columns)
        self._heights.forget(columns)
        for rows in self._seen:
            rows[columns] = np.nan

    def _report(
        self, answer: Answer, factors: Factors, chosen: BoolArray, certain: BoolArray, *, bounded: bool
    ) -> dict[str, Any]:
        """The other fields of the frame's estimate; adds the covariance of this frame's fit to the drift.

        Parameters
        ----------
        certain : [K] people who anchor the pose, see `Company`.
        bounded : whether the pose was limited by a person's reach.
        """
        history, drift, pose = self._history, self._drift, np.zeros((3, 3))
        std = factors.std.copy()
        std[chosen] = np.where(np.isnan(std[chosen]), np.nan, answer.curved.std)
        curved = factors._replace(std=std, walk=answer.curved.walk, walk_std=answer.curved.walk_std)
        helpful = bool((curved.helpful & chosen).any())
        if not history.pose_given[2]:
            walked = np.diag((curved.walk_std**2, curved.walk_std**2, self._alone()[1]))
            pose = pose_covariance(answer.pose, curved.of(chosen)) if helpful else walked
        if certain.any():
            drift.reduce(pose @ np.linalg.inv(pose_covariance(answer.pose, curved.of(chosen & ~certain))))
        sure = not bounded and variances(pose)[0] + drift.std**2 <= UNRELIABLE**2
        known = {"heights": self._heights.mean.copy(), "height_variances": self._heights.variance.copy()}
        covariances = self._spread(answer, pose, curved) if self._covariances else {}
        if not history.pose_given[2]:
            drift.add(*((0.0, 0.0) if history.cold and helpful else variances(pose) if helpful else self._alone()))
        return {**known, **covariances, "converged": sure}

    def _spread(self, answer: Answer, pose: FloatArray, curved: Factors) -> dict[str, FloatArray]:
        """Covariances of pose and places: those of this frame, ``pose`` [3, 3] and ``curved`` terms, plus the drift."""
        history, sigma = self._history, pose.copy()
        people = position_covariances(answer.pose, pose, curved)
        drifted = people.copy()
        self._drift.cover(sigma, drifted, answer.pose, localise(answer.pose, curved))
        drifted = np.where(history.position_given[2][:, None, None], people, drifted)
        if history.cold:  # people's velocities are independent in these covariances, which lack their common part
            common = self._astray.variance * np.eye(2)
            sigma[:2, :2] += common
            drifted += common
        return {"pose_covariance": sigma, "position_covariances": drifted}


def _with_odometry(factors: Factors, measured: MeasuredPose | None, facing: float) -> tuple[Factors, float]:
    """The terms with odometry, if precise, in place of the motion prior, and the information in 1/rad² on the yaw.

    ``facing``: the information without odometry.
    """
    if measured is None:
        return factors, facing
    if measured.std < SURE:
        return factors._replace(walk=measured.pose, walk_std=measured.std), measured.facing
    walked, weight = 1.0 / factors.walk_std**2, 1.0 / measured.std**2
    pose = measured.pose.copy()
    pose[:2] = (walked * factors.walk[:2] + weight * measured.pose[:2]) / (walked + weight)
    return factors._replace(walk=pose, walk_std=float((walked + weight) ** -0.5)), measured.facing


@dataclass(kw_only=True)
class ConstantVelocityBirdifier(Birdifier):
    """Squared norms about constant velocity, with both stages in closed form: no samples, no messages."""

    def _minimise(self, task: Task) -> Answer:
        factors = task.factors
        pose = fit_pose(factors, task.facing) if np.isnan(task.pose[2]) else task.pose
        return Answer(pose, localise(pose, factors), factors)
