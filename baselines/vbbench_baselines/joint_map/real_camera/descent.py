"""The descent to the minimum of the joint problem: Levenberg and Marquardt's on the frames."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.walks import innovation, reweigh
from vbbench_baselines.joint_map.real_camera.certainty import spread_of
from vbbench_baselines.joint_map.real_camera.cholesky import factor, padded, solve
from vbbench_baselines.joint_map.real_camera.cues import FRAME, PERSON
from vbbench_baselines.joint_map.real_camera.joint import SOFTEST, Model, Point, Seen, System, deviance_of, linearise
from vbbench_baselines.joint_map.real_camera.recovery import follow
from vbbench_baselines.joint_map.real_camera.shares import Shares
from vbbench_baselines.joint_map.real_camera.volume import told_of

TRIES, LONGEST, DAMPING = 6, 2.0, 1e-6
"""Dampings tried in a round, the longest step of a pose in m and rad, and the damping at first."""

EDGES = (-0.2, 1.0)
"""In m; no part of a body is farther from its middle."""

SHORT, SETTLED = 1e-3, 0.1
"""A round is the last whose step is shorter, in m and rad, or that lowers the deviance by less."""

MOST_PUSHED, TELLING = 5.0, 8
"""A world of so many frames is pushed apart (`real_camera.volume`) at most so many times as strongly as walks pull it
together, and at least as strongly. Both are alike where boxes are as noisy as they are taken to be, and people walk as
they are thought to; on KITTI and in tier `field` the push is never beyond five times the pull. Where people stand and
boxes are exact there is no noise that pulls; where they walk in circles their walks would pull for ever."""

CLOSE = 0.02
"""A descent whose last round lowered it by less for each box moved what they tell of by about a fifth of a standard
deviation."""


@kernel
def solve_damped(system: System, damping: float) -> FloatArray:
    """The step [7T] that minimises the model, NaN if the damped Hessian is not positive definite."""
    step, moving = -system.gradient, system.moving
    n = len(moving)
    lower, right = np.zeros((n, padded(n))), np.empty(n)
    for i in range(n):
        target, row = lower[i], system.hessian[moving[i]]
        for j in range(i + 1):
            target[j] = row[moving[j]]
        target[i] += damping * target[i] + SOFTEST
        right[i] = -system.gradient[moving[i]]
    possible = factor(lower)
    solve(lower, right)
    for i in range(n):
        step[moving[i]] = right[i] if possible else np.nan
    return step


class Round(NamedTuple):
    """A round of the descent.

    Attributes
    ----------
    point, deviance : where it led; infinite if nothing lowers the deviance.
    system : the energy about the point before.
    longest : how far a pose was to move at most, in m or rad.
    damping : for the next round.
    """

    point: Point
    deviance: float
    system: System
    longest: float
    damping: float


@kernel
def descend(point: Point, seen: Seen, model: Model, deviance: float, damping: float) -> Round:
    """A round from a point of this ``deviance``, with more damping until it leads down."""
    system, trial, longest, most = linearise(point, seen, model, damping), point, np.inf, deviance
    most += 1e-9 * abs(deviance)
    for _ in range(TRIES):
        step = solve_damped(system, damping).reshape(point.frames.shape)
        longest = _longest(step)
        if np.isfinite(longest):
            trial = _moved(point, system, step, min(1.0, LONGEST / max(longest, LONGEST)))
            lower = deviance_of(trial, seen, model)
            if lower <= most:
                return Round(trial, lower, system, longest, max(0.1 * damping, 1e-9))
        damping = max(damping, 1e-5) * 10.0
    return Round(point, np.inf, system, longest, damping)


class Settled(NamedTuple):
    """Where the descent ended.

    Attributes
    ----------
    point, deviance : where, and the deviance there.
    converged : whether the last round lowered it by little.
    shares : what the steps tell of the laws.
    pose_covariances, place_covariances : [n, 3, 3] and [n, K, 2, 2], NaN where no box is, of the frames asked for.
    early : [3, 3] covariance of the pose after the first `HELD`.
    told : as of `Seen`, zeros unless no place is ever given.

    The last four are of the point where the last round began.
    """

    point: Point
    deviance: float
    converged: bool
    shares: Shares
    pose_covariances: FloatArray
    place_covariances: FloatArray
    early: FloatArray
    told: FloatArray


def copied(point: Point) -> Point:
    """The same point, for a descent that leaves this one as it is."""
    return point._replace(variances=point.variances.copy())


@kernel
def settle(point: Point, seen: Seen, model: Model, rounds: int, since: int, people: bool) -> Settled:
    """Descend in at most so many ``rounds``, at least one.

    Covariances are of the frames from ``since`` on, and of ``people`` if these are asked for.
    """
    deviance, damping, converged = deviance_of(point, seen, model), DAMPING, False
    boxes = np.count_nonzero(~np.isnan(seen.boxes.azimuth))
    for _ in range(rounds):
        done = descend(point, seen, model, deviance, damping)
        if not np.isfinite(done.deviance):
            break
        gained, point, deviance, damping = deviance - done.deviance, done.point, done.deviance, done.damping
        converged = bool(done.longest < SHORT or gained < CLOSE * boxes)
        if done.longest < SHORT or gained < SETTLED:
            break
    poses, places, early = spread_of(done.system, seen, since, people)
    told = np.zeros(seen.told.shape)
    if model.cold:
        for person in done.system.people:
            for t, of_box in enumerate(told_of(person)):
                told[person.first + t, person.number] = of_box
        if len(point.frames) >= TELLING:
            ratio = _pull_of_walks(point, seen, model) / max(told.sum(), 1e-12)
            told *= max(ratio, min(1.0, MOST_PUSHED * ratio))
    return Settled(point, deviance, converged, done.system.shares, poses, places, early, told)


@kernel
def _pull_of_walks(point: Point, seen: Seen, model: Model) -> float:
    """By how much the energy of people's walks grows with the logarithm of the world's size."""
    total = 0.0
    for k in range(len(seen.first)):
        if seen.last[k] > seen.first[k]:
            track = point.places[seen.first[k] : seen.last[k] + 1, k].copy()
            weights = np.zeros(len(track))
            reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
            weights[1] = 1.0
            for i in range(1, len(track)):
                total += weights[i] * innovation(track, i, model.walk)
    return total


@kernel
def _longest(step: FloatArray) -> float:
    """How far a step [T, 7] moves a pose at most, in m or rad; NaN if it is no step."""
    longest = 0.0
    for t in range(len(step)):
        for a in range(3):
            if not abs(step[t, a]) <= longest:
                longest = abs(step[t, a])
    return longest


@kernel
def _moved(point: Point, system: System, step: FloatArray, share: float) -> Point:
    """The point a ``share`` of a step [T, 7] further."""
    frames, places, people = point.frames.copy(), point.places.copy(), point.people.copy()
    for t in range(len(frames)):
        for a in range(FRAME):
            frames[t, a] += share * step[t, a]
    for person in system.people:
        track, numbers = follow(person, step)
        k, first = person.number, person.first
        for i in range(len(track)):
            places[first + i, k, 0] += share * track[i, 0]
            places[first + i, k, 1] += share * track[i, 1]
        for a in range(PERSON):
            people[k, a] += share * numbers[a]
        people[k, 1] = min(max(people[k, 1], EDGES[0]), EDGES[1])
    return Point(frames, places, people, point.variances.copy())
