"""The joint problem of a few frames, and the descent to its minimum: Levenberg and Marquardt's on the frames."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.bearings import Bearings
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.odometry import Motions, measured, stray
from vbbench_baselines.joint_map.motion.walks import Walk, reweigh
from vbbench_baselines.joint_map.real_camera.cholesky import factor, padded, solve
from vbbench_baselines.joint_map.real_camera.cues import FRAME, PERSON, Noise, Residuals, residuals_of, whiten
from vbbench_baselines.joint_map.real_camera.drift import Drift, add_drift, drift_deviance
from vbbench_baselines.joint_map.real_camera.elimination import PeoplePrior, Person, add_person, eliminate, paper_for
from vbbench_baselines.joint_map.real_camera.observer import LAWS, Observer
from vbbench_baselines.joint_map.real_camera.observer_slopes import add_observer, level_deviance
from vbbench_baselines.joint_map.real_camera.recovery import follow
from vbbench_baselines.joint_map.real_camera.shares import Shares, shares_of

TRIES, LONGEST, DAMPING = 6, 2.0, 1e-6
"""Dampings tried in a round, the longest step of a pose in m and rad, and the damping at first."""

SOFTEST = 1e-9
"""Information that holds what nothing tells of."""

EDGES = (-0.2, 1.0)
"""In m; no part of a body is farther from its middle."""

SETTLED = 1e-2
"""A round that lowers the deviance by less is the last."""

CLOSE = 0.1
"""A descent whose last round lowered it by less ended within about half a standard deviation."""


class Seen(NamedTuple):
    """What is known of T frames and K people.

    Attributes
    ----------
    boxes : rows [T, K].
    given : [T, K, 2] places in m, NaN = not given.
    fixed : [T] whether the pose is given.
    free : [T] whether nothing measures the step into the frame surely.
    blind : [T] whether nobody has a box.
    first, last : [K] frames between which a person is followed; last < first for nobody.
    motions : the observer's odometry.
    """

    boxes: Bearings
    given: FloatArray
    fixed: BoolArray
    free: BoolArray
    blind: BoolArray
    first: IntArray
    last: IntArray
    motions: Motions


class Model(NamedTuple):
    """What is believed before anything is seen."""

    noise: Noise
    people: PeoplePrior
    walk: Walk
    observer: Observer
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
    """The energy about a point: people eliminated, gradient [7T], Hessian [7T, 7T] (lower half, with `padded`
    columns), and what the steps tell of the laws.

    ``moving`` are the frames' numbers that are not given.
    """

    people: list[Person]
    gradient: FloatArray
    hessian: FloatArray
    moving: IntArray
    shares: Shares


@kernel
def boxes_of(k: int, point: Point, seen: Seen, model: Model) -> tuple[FloatArray, Residuals]:
    """The track [n, 2] of person ``k``, and the residuals of its boxes."""
    first, last = int(seen.first[k]), int(seen.last[k])
    track = point.places[first : last + 1, k].copy()
    return track, residuals_of(k, first, seen.boxes, point.frames, track, point.people[k], model.noise)


@kernel
def deviance_of(point: Point, seen: Seen, model: Model) -> float:
    """−ln of the posterior density at a point, up to a constant; its variances are renewed."""
    frames = point.frames
    shares = shares_of(frames, seen.free, seen.fixed, model.observer, model.odds)
    total = shares.deviance + drift_deviance(frames, model.drift)
    total += level_deviance(frames, seen.free, seen.blind, model.observer, shares)
    for t in range(1, len(frames)):
        if measured(seen.motions.information[t]):
            error, _ = stray(frames[t - 1], frames[t], seen.motions.moved[t])
            for a in range(3):
                for b in range(3):
                    total += 0.5 * error[a] * seen.motions.information[t, a, b] * error[b]
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if last < first:
            continue
        track, found = boxes_of(k, point, seen, model)
        weights = np.zeros(len(track))
        total += whiten(found, model.noise, model.dt).deviance
        point.variances[k], walked = reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        total += walked
        for a in range(PERSON):
            total += 0.5 * ((point.people[k, a] - model.people.mean[a]) / model.people.std[a]) ** 2
        for i in range(len(track)):
            if not np.isnan(seen.given[first + i, k, 0]):
                x, y = track[i, 0] - seen.given[first + i, k, 0], track[i, 1] - seen.given[first + i, k, 1]
                total += 0.5 * (x * x + y * y) / ANCHOR_STD**2
    return total


@kernel
def linearise(point: Point, seen: Seen, model: Model, damping: float) -> System:
    """The energy about a point; given poses do not move."""
    frames = point.frames
    size = frames.size
    gradient, hessian = np.zeros(size), np.zeros((size, padded(size)))
    shares = shares_of(frames, seen.free, seen.fixed, model.observer, model.odds)
    add_observer(frames, seen.free, seen.blind, model.observer, shares, gradient, hessian)
    add_drift(frames, model.drift, gradient, hessian)
    _add_motions(frames, seen.motions, gradient, hessian)
    people, paper = [], paper_for(len(frames))
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if last < first:
            continue
        track, found = boxes_of(k, point, seen, model)
        weights = np.zeros(len(track))
        white = whiten(found, model.noise, model.dt)
        reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        given, numbers = seen.given[first : last + 1, k].copy(), point.people[k].copy()
        person, filled = eliminate(
            k, first, track, given, numbers, found, white, weights, model.walk, model.people, damping, paper
        )
        add_person(person, filled, paper, gradient, hessian)
        people.append(person)
    moving = _hold(seen.fixed, gradient, hessian)
    for t in range(len(frames)):  # a frame's own block holds both halves
        p = FRAME * t
        for a in range(FRAME):
            for b in range(a):
                hessian[p + b, p + a] = hessian[p + a, p + b]
    return System(people, gradient, hessian, moving, shares)


@kernel
def _hold(fixed: BoolArray, gradient: FloatArray, hessian: FloatArray) -> IntArray:
    """Take the poses of ``fixed`` frames [T] out of the energy; returns the numbers that move."""
    size, count, moving = len(gradient), 0, np.empty(len(gradient), np.int64)
    for p in range(size):
        if p % FRAME < 3 and fixed[p // FRAME]:
            gradient[p] = 0.0
            for q in range(size):
                hessian[max(p, q), min(p, q)] = 1.0 if p == q else 0.0
        else:
            moving[count] = p
            count += 1
    return moving[:count]


@kernel
def _add_motions(frames: FloatArray, motions: Motions, gradient: FloatArray, hessian: FloatArray) -> None:
    """What odometry says."""
    for t in range(1, len(frames)):
        if not measured(motions.information[t]):
            continue
        error, slopes = stray(frames[t - 1], frames[t], motions.moved[t])
        for i in range(6):
            p = FRAME * (t - 1 + i // 3) + i % 3
            for a in range(3):
                for b in range(3):
                    pull = slopes[a, i] * motions.information[t, a, b]
                    gradient[p] += pull * error[b]
                    for j in range(i + 1):
                        hessian[p, FRAME * (t - 1 + j // 3) + j % 3] += pull * slopes[b, j]


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


class Settled(NamedTuple):
    """Where the descent ended, whether it had converged, the deviance there, and what the steps tell of the laws."""

    point: Point
    converged: bool
    deviance: float
    shares: Shares


@kernel
def settle(point: Point, seen: Seen, model: Model, rounds: int, tolerance: float) -> Settled:
    """Descend in at most so many ``rounds``, to a step shorter than ``tolerance`` in m and rad."""
    damping, converged = DAMPING, False
    before = deviance_of(point, seen, model)
    trial, longest = point, np.inf
    shares = Shares(np.empty(LAWS), np.empty(0), 0.0)
    for _ in range(rounds):
        system, lower = linearise(point, seen, model, damping), np.inf
        shares = system.shares
        for _ in range(TRIES):
            step = solve_damped(system, damping).reshape(point.frames.shape)
            longest = _longest(step)
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
        converged = longest < tolerance or gained < CLOSE
        if longest < tolerance or gained < SETTLED:
            break
    return Settled(point, converged, before, shares)


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
