"""The joint problem of a few frames, and the descent to its minimum: Levenberg and Marquardt's on the frames."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.odometry import Motions, measured, stray
from vbbench_baselines.joint_map.motion.walks import Walk, reweigh
from vbbench_baselines.real_camera.bearings import Bearings
from vbbench_baselines.real_camera.cholesky import factor, padded, solve
from vbbench_baselines.real_camera.cues import FRAME, Noise, residuals_of, whiten
from vbbench_baselines.real_camera.drift import Drift, add_drift, drift_deviance
from vbbench_baselines.real_camera.elimination import PeoplePrior, Person, add_person, eliminate
from vbbench_baselines.real_camera.observer import Observer, add_observer, level_deviance, shares_of
from vbbench_baselines.real_camera.recovery import follow

TRIES, LONGEST, DAMPING = 6, 2.0, 1e-6
"""Dampings tried in a round, the longest step of a pose in m and rad, and the damping at first."""

SOFTEST = 1e-9
"""Information that holds what nothing tells of."""

EDGES = (-0.2, 1.0)
"""In m; no part of a body is farther from its middle."""

SETTLED = 1e-3
"""A round that lowers the deviance by less is the last."""


class Seen(NamedTuple):
    """What is known of T frames and K people.

    Attributes
    ----------
    boxes : rows [T, K].
    given : [T, K, 2] places in m, NaN = not given.
    fixed : [T] whether the pose is given.
    free : [T] whether nothing measures the step into the frame, and its pose is not given either.
    first, last : [K] frames between which a person is followed; last < first for nobody.
    motions : the observer's odometry.
    """

    boxes: Bearings
    given: FloatArray
    fixed: BoolArray
    free: BoolArray
    first: IntArray
    last: IntArray
    motions: Motions


class Model(NamedTuple):
    """What is believed before anything is seen."""

    noise: Noise
    people: PeoplePrior
    walk: Walk
    observer: Observer
    normalisers: FloatArray
    drift: Drift
    odds: FloatArray
    dt: float


class Point(NamedTuple):
    """Frames [T, 7], places [T, K, 2], the people's numbers [K, 2], and σ_k² [K] of their walks in m²."""

    frames: FloatArray
    places: FloatArray
    people: FloatArray
    variances: FloatArray


class System(NamedTuple):
    """The energy about a point: people eliminated, gradient [7T], Hessian [7T, 7T] (lower half), and shares of laws.

    ``moving`` are the frames' numbers that are not given.
    """

    people: list[Person]
    gradient: FloatArray
    hessian: FloatArray
    moving: IntArray
    shares: FloatArray


@kernel
def deviance_of(point: Point, seen: Seen, model: Model) -> float:
    """−ln of the posterior density at a point, up to a constant; its variances are renewed."""
    frames = point.frames
    shares, total = shares_of(frames, seen.free, model.observer, model.odds, model.normalisers)
    total += drift_deviance(frames, model.drift) + level_deviance(frames, seen.free, model.observer, shares[0])
    for t in range(1, len(frames)):
        if measured(seen.motions.information[t]):
            error, _ = stray(frames[t - 1, :3].copy(), frames[t, :3].copy(), seen.motions.moved[t])
            total += 0.5 * float(error @ (seen.motions.information[t] @ error))
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if last < first:
            continue
        track, weights = point.places[first : last + 1, k].copy(), np.zeros(last - first + 1)
        found = residuals_of(k, first, seen.boxes, frames, track, point.people[k], model.noise)
        total += whiten(found, model.noise, model.dt).deviance
        point.variances[k], walked = reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        total += walked + 0.5 * np.sum(((point.people[k] - model.people.mean) / model.people.std) ** 2)
        for i in range(len(track)):
            if not np.isnan(seen.given[first + i, k, 0]):
                total += 0.5 * np.sum((track[i] - seen.given[first + i, k]) ** 2) / ANCHOR_STD**2
    return total


@kernel
def linearise(point: Point, seen: Seen, model: Model, damping: float) -> System:
    """The energy about a point; given poses do not move."""
    frames = point.frames
    size = frames.size
    gradient, hessian = np.zeros(size), np.zeros((size, size))
    shares, _ = shares_of(frames, seen.free, model.observer, model.odds, model.normalisers)
    add_observer(frames, seen.free, model.observer, shares, gradient, hessian)
    add_drift(frames, model.drift, gradient, hessian)
    _add_motions(frames, seen.motions, gradient, hessian)
    people = []
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if last < first:
            continue
        track, weights = point.places[first : last + 1, k].copy(), np.zeros(last - first + 1)
        found = residuals_of(k, first, seen.boxes, frames, track, point.people[k], model.noise)
        white = whiten(found, model.noise, model.dt)
        reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        given, numbers = seen.given[first : last + 1, k].copy(), point.people[k].copy()
        person = eliminate(k, first, track, given, numbers, found, white, weights, model.walk, model.people, damping)
        add_person(person, gradient, hessian)
        people.append(person)
    moving = np.ones(size, np.bool_)
    for t in range(len(frames)):
        if seen.fixed[t]:
            for a in range(3):
                moving[FRAME * t + a] = False
                p = FRAME * t + a
                gradient[p] = 0.0
                hessian[p, : p + 1] = 0.0
                hessian[p:, p] = 0.0
                hessian[p, p] = 1.0
    for t in range(len(frames)):  # a frame's own block holds both halves
        p = FRAME * t
        for a in range(FRAME):
            for b in range(a):
                hessian[p + b, p + a] = hessian[p + a, p + b]
    return System(people, gradient, hessian, np.flatnonzero(moving), shares)


@kernel
def _add_motions(frames: FloatArray, motions: Motions, gradient: FloatArray, hessian: FloatArray) -> None:
    """What odometry says."""
    for t in range(1, len(frames)):
        if not measured(motions.information[t]):
            continue
        error, slopes = stray(frames[t - 1, :3].copy(), frames[t, :3].copy(), motions.moved[t])
        pull, curvature = slopes.T @ (motions.information[t] @ error), slopes.T @ (motions.information[t] @ slopes)
        for i in range(6):
            p = FRAME * (t - 1 + i // 3) + i % 3
            gradient[p] += pull[i]
            for j in range(i + 1):
                hessian[p, FRAME * (t - 1 + j // 3) + j % 3] += curvature[i, j]


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
    if not factor(lower):
        return np.full_like(step, np.nan)
    solve(lower, right)
    for i in range(n):
        step[moving[i]] = right[i]
    return step


class Settled(NamedTuple):
    """Where the descent ended, whether it had converged, the deviance there, and the shares of laws [4]."""

    point: Point
    converged: bool
    deviance: float
    shares: FloatArray


@kernel
def settle(point: Point, seen: Seen, model: Model, rounds: int, tolerance: float) -> Settled:
    """Descend in at most so many ``rounds``, to a step shorter than ``tolerance`` in m and rad."""
    damping, converged = DAMPING, False
    before = deviance_of(point, seen, model)
    system = linearise(point, seen, model, damping)
    trial, longest = point, np.inf
    for done in range(rounds):
        lower = np.inf
        for _ in range(TRIES):
            step = solve_damped(system, damping).reshape(point.frames.shape)
            longest = np.max(np.abs(step[:, :3]))
            if np.isfinite(longest):
                trial = _moved(point, system, step, min(1.0, LONGEST / max(longest, LONGEST)))
                lower = deviance_of(trial, seen, model)
            if lower <= before + 1e-9 * abs(before):
                break
            damping = max(damping, 1e-5) * 10.0
        if not lower <= before + 1e-9 * abs(before):
            break
        point, gained, before = trial, before - lower, lower
        damping = max(0.1 * damping, 1e-9)
        converged = longest < tolerance or gained < SETTLED
        if converged:
            break
        if done + 1 < rounds:
            system = linearise(point, seen, model, damping)
    return Settled(point, converged, before, system.shares)


@kernel
def _moved(point: Point, system: System, step: FloatArray, share: float) -> Point:
    """The point a ``share`` of a step [T, 7] further."""
    places, people = point.places.copy(), point.people.copy()
    for person in system.people:
        track, numbers = follow(person, step)
        k, first = person.number, person.first
        places[first : first + len(track), k] += share * track
        people[k] += share * numbers
        people[k, 1] = min(max(people[k, 1], EDGES[0]), EDGES[1])
    return Point(point.frames + share * step, places, people, point.variances.copy())
