"""``map-batch``: the joint problem over the whole sequence, started from a quick causal solution."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import Estimate, Problem
from vbbench.solving.runner import given_at
from vbbench_baselines.common.cold_start import add_drift, astray_after, begins_cold, drift_variance
from vbbench_baselines.common.facts import FITTED
from vbbench_baselines.common.odometry import Motions, motions_of
from vbbench_baselines.common.sightings import Sightings, usable
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.crowd import Crowd
from vbbench_baselines.joint_map.flow import flow_of, is_untold
from vbbench_baselines.joint_map.lost import PATIENCE, beyond_patience, seconds_lost
from vbbench_baselines.joint_map.measurement.boxes import (
    BoxHeights,
    Eye,
    GroundCheck,
    Report,
    Statures,
    inform,
    statures_of,
)
from vbbench_baselines.joint_map.measurement.window import gather
from vbbench_baselines.joint_map.motion.walks import let_stand, walk_of
from vbbench_baselines.joint_map.optimiser.covariance import block_of, place_covariances, pose_covariance_of
from vbbench_baselines.joint_map.optimiser.descent import Settled, settle, unwrapped
from vbbench_baselines.joint_map.optimiser.marginalisation import NOTHING_KEPT, anchor_of
from vbbench_baselines.joint_map.optimiser.state import JointProblem, deviance_of
from vbbench_baselines.joint_map.prior import Prior, get_prior, variants_held_out
from vbbench_baselines.joint_map.real_camera.choice import is_rough
from vbbench_baselines.joint_map.real_camera.settings import Settings, settings_of
from vbbench_baselines.joint_map.real_camera.smoothing import smooth

START_WINDOW, START_ROUNDS = 6, 1
"""Of the causal solver that finds the start, which need not be exact."""

LONG, FRAMES_A_ROUND = 15, 4
"""A descent is long that takes more rounds than both the first number and one for so many frames: it may be in a wrong
valley. Of the first starts on Hotel and ETH that ended higher than the second, most were."""


@dataclass(kw_only=True)
class MapBatch:
    """Joint maximum a posteriori of all frames.

    All frames are solved together, in time linear in frames: how far apart two poses are coupled directly is cut
    (`optimiser.poses.reach_of`), which costs steps but no exactness. If all poses but the last are given, later frames
    have nothing to correct, and the causal answer is returned. A descent that is long or does not converge is repeated
    from a more careful causal solution; the answer is the likelier of the two.

    Parameters
    ----------
    prior, ego_prior, feet, real : as of `MapCausal`.
    rounds : maximum number of descent steps.
    tolerance, certain : in m and rad, and in standard deviations; the descent ends with a step shorter than either.
    """

    facts: ClassVar[Mapping[str, str]] = FITTED
    held_out: ClassVar[Mapping[str, str]] = variants_held_out("Batch")
    """Variants with a prior that never saw the recording, by the SHA-256 of its files."""

    prior: Prior = field(default_factory=lambda: get_prior("default"))
    ego_prior: bool = True
    feet: bool = True
    rounds: int = 80
    tolerance: float = 1e-4
    certain: float = 0.02
    real: Settings | None = field(default_factory=Settings)

    def solve(self, problem: Problem, observations: FloatArray, given: Given) -> Estimate:
        """See `vbbench.solver.SequenceSolver.solve`."""
        observations = usable(observations)
        settings = settings_of(self.real, self.prior, promised=not (self.feet and self.ego_prior))
        if settings is not None and is_rough(problem, observations, given):
            return smooth(settings, problem, observations, given)
        cold = len(observations) > 1 and begins_cold(given.frames(slice(2)), 1)
        if self.feet and cold and not GroundCheck(problem).look(observations):
            return replace(self, feet=False).solve(problem, observations, given)
        eye = Eye(problem, self.feet)
        task = _Task(problem, eye.sight(observations), given, statures_of(problem, self.feet))
        shown = eye.with_feet(observations)
        start = MapCausal(prior=self.prior, ego_prior=self.ego_prior, feet=self.feet, rests=False)
        if not np.isnan(given.poses[:-1, 2]).any():
            return replace(_walk_through(start, task, problem.covariances), **self._heights(problem, shown))
        fast = replace(start, window=START_WINDOW, rounds=START_ROUNDS)
        answer = self._descend(fast, task)
        if not answer.settled.converged or answer.settled.rounds > max(LONG, len(observations) / FRAMES_A_ROUND):
            other = self._descend(start, task, fast.crowd)
            answer = other if other.deviance < answer.deviance else answer
        return answer.estimate(self._heights(problem, shown) or {"heights": answer.settled.state.heights})

    def _heights(self, problem: Problem, observations: FloatArray) -> Report:
        """Heights from boxes alone, if they are not part of the problem."""
        if not self.feet:
            return {}
        heights = BoxHeights(problem)
        heights.learn(observations)
        return heights.report()

    def _descend(self, start: MapCausal, task: "_Task", crowd: Crowd | None = None) -> "_Answer":
        """The end of the descent from the answer of ``start``, in a ``crowd`` as lively as this, or as that found."""
        causal = _walk_through(start, task, covariances=False)
        cold = len(task.given.poses) > 1 and begins_cold(task.given.frames(slice(2)), 1)
        crowd = start.crowd if crowd is None else crowd
        walk = crowd.walk(walk_of(self.prior, task.problem.dt, self.ego_prior, cold))
        motions = _motions(task.given)
        poses, fixed = unwrapped(causal.poses), ~np.isnan(task.given.poses[:, 2])
        informed = [inform(boxes, task.statures.mean) for boxes in map(Sightings, *task.seen)]
        relative, information = (np.stack(rows) for rows in zip(*informed, strict=True))
        waits = np.where(motions.information.any(axis=(1, 2)), 0.0, task.problem.dt)
        waits[0] = 0.0
        seen = ~np.isnan(relative[..., 0])
        if cold:
            new = np.count_nonzero(seen & (np.cumsum(seen, axis=0) == 2), axis=1)
            motions = let_stand(motions, poses, np.count_nonzero(seen, axis=1), new, walk, task.problem.dt)
        data = gather(relative, information, task.given.positions, task.statures)
        joint = JointProblem(data, anchor_of(fixed, NOTHING_KEPT), walk, motions)
        nowhere = np.full_like(causal.positions, np.nan)
        settled = settle(poses, nowhere, joint, self.rounds, self.tolerance, self.certain)
        if cold:
            settled = self._to_flow(settled, seen, task.given, task.problem.dt)
        lost = seconds_lost(seen, ~np.isnan(task.given.positions[..., 0]), fixed, waits)
        answer = _answer_of(settled, joint, lost, causal.positions, task.problem.covariances)
        answer.add_drift(astray_after(waits) if cold else drift_variance(beyond_patience(lost)))
        return answer

    def _to_flow(self, settled: Settled, seen: BoolArray, given: Given, dt: float) -> Settled:
        """The same in the world that people's pace says, if nothing else tells."""
        measured = np.zeros((0, 3)) if given.odometry is None else given.odometry.motions
        if not is_untold(given.poses, given.positions, measured):
            return settled
        poses, places = settled.state.poses.copy(), settled.state.places.copy()
        moved = flow_of(poses, places, seen, dt, drives=not self.ego_prior)
        poses[:, :2] += moved
        places += moved[:, None]
        return settled._replace(state=settled.state._replace(poses=poses, places=places))


def _motions(given: Given) -> Motions:
    """What the observer measures of its own motion in all frames."""
    if given.odometry is None:
        return motions_of(np.full((len(given.poses), 3), np.nan), np.full((len(given.poses), 3, 3), np.nan))
    return motions_of(given.odometry.motions, given.odometry.covariances)


class _Task(NamedTuple):
    """The problem to solve: boxes as rays, and what scales them."""

    problem: Problem
    seen: Sightings
    given: Given
    statures: Statures


@dataclass(frozen=True)
class _Answer:
    """The estimate.

    Attributes
    ----------
    settled : where the descent ended.
    converged : [T] whether it had, and the observer is not lost.
    places : [T, K, 2] in m, of everybody and always.
    deviance : of where it ended.
    poses, people : covariances [T, 3, 3] and [T, K, 2, 2], if they are wanted.
    """

    settled: Settled
    converged: BoolArray
    places: FloatArray
    deviance: float
    poses: FloatArray | None
    people: FloatArray | None

    def add_drift(self, variances: FloatArray) -> None:
        """Add what a cold start or being lost leaves open to the covariances, by ``variances`` [T] in m²."""
        if self.poses is not None and self.people is not None:
            add_drift(self.poses, self.people, variances)

    def estimate(self, heights: Report) -> Estimate:
        """The whole estimate, with a report of ``heights``."""
        poses = self.settled.state.poses.copy()
        poses[:, 2] = wrap_angle(poses[:, 2])
        return Estimate(
            poses=poses,
            positions=self.places,
            converged=self.converged,
            pose_covariances=self.poses,
            position_covariances=self.people,
            **heights,
        )


def _answer_of(
    settled: Settled, joint: JointProblem, lost: FloatArray, causal: FloatArray, covariances: bool
) -> _Answer:
    """The answer where the descent of a sequence ``settled``, whose observer is ``lost`` [T] for so many seconds.

    Where nobody is followed, the ``causal`` places hold.
    """
    state = settled.state
    places = np.where(np.isnan(state.places), causal, state.places)
    poses = people = None
    if covariances:
        sigma = pose_covariance_of(state, joint)
        poses = np.stack([block_of(sigma, t, t) for t in range(len(state.poses))])
        people = place_covariances(state, joint.walk, sigma, 0)
    converged = settled.converged & (lost <= PATIENCE)
    return _Answer(settled, converged, places, float(deviance_of(state, state.data)), poses, people)


def _walk_through(start: MapCausal, task: _Task, covariances: bool) -> Estimate:
    """The causal solver's answer."""
    start.start(replace(task.problem, covariances=covariances))
    frames = enumerate(map(Sightings, *task.seen))
    return Estimate.of_frames([start.advance(boxes, given_at(task.given, t)) for t, boxes in frames])
