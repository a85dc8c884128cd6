"""The joint problem of a few frames: its energy, and this to second order about a point."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.bearings import Bearings
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.odometry import Motions, measured, stray
from vbbench_baselines.joint_map.motion.pace import pace_deviance
from vbbench_baselines.joint_map.motion.walks import Walk, reweigh
from vbbench_baselines.joint_map.real_camera.cholesky import padded
from vbbench_baselines.joint_map.real_camera.cues import FRAME, PERSON, Noise, Residuals, residuals_of, whiten
from vbbench_baselines.joint_map.real_camera.drift import Drift, add_drift, drift_deviance
from vbbench_baselines.joint_map.real_camera.elimination import PeoplePrior, Person, add_person, eliminate, scratch_for
from vbbench_baselines.joint_map.real_camera.heights import height_law
from vbbench_baselines.joint_map.real_camera.observer import Observer
from vbbench_baselines.joint_map.real_camera.observer_slopes import add_observer, level_deviance
from vbbench_baselines.joint_map.real_camera.past import Past, let_go, pull_of
from vbbench_baselines.joint_map.real_camera.shares import Shares, shares_of
from vbbench_baselines.joint_map.real_camera.volume import push, volume_deviance

SOFTEST = 1e-9
"""Information that holds what nothing tells of."""

KNOWN = 1e-4
"""Standard deviation of a person's numbers that are known."""


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
    sure : [K] whether the person's numbers are known.
    motions : the observer's odometry.
    past : of what earlier frames told of people.
    told : [T, K] how many numbers of a place its box tells of (`real_camera.volume`); 0 where places are given.
    """

    boxes: Bearings
    given: FloatArray
    fixed: BoolArray
    free: BoolArray
    blind: BoolArray
    first: IntArray
    last: IntArray
    sure: BoolArray
    motions: Motions
    past: Past
    told: FloatArray


class Model(NamedTuple):
    """What is believed before anything is seen; ``cold``: that no place is ever given."""

    noise: Noise
    people: PeoplePrior
    walk: Walk
    observer: Observer
    drift: Drift
    odds: FloatArray
    dt: float
    cold: bool


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
        if seen.last[k] >= seen.first[k]:
            total += _person_deviance(k, point, seen, model)
    return total


@kernel
def _person_deviance(k: int, point: Point, seen: Seen, model: Model) -> float:
    """The share of person ``k``, whose variance is renewed."""
    track, found = boxes_of(k, point, seen, model)
    told = seen.told[seen.first[k] : seen.last[k] + 1, k]
    total = whiten(found, model.noise, model.dt).deviance + volume_deviance(found, told, point.people[k, 0])
    point.variances[k], walked = reweigh(track, model.walk, model.walk.sigma, np.zeros(len(track)), point.variances[k])
    total += walked + pace_deviance(track, model.walk.pace) + pull_of(seen.past, k, track, point.people[k])[1]
    if not seen.sure[k]:
        total += height_law(point.people[k, 0], model.people.mean[0], model.people.std[0]).deviance
        total += 0.5 * ((point.people[k, 1] - model.people.mean[1]) / model.people.std[1]) ** 2
    for i in range(len(track)):
        given = seen.given[seen.first[k] + i, k]
        if not np.isnan(given[0]):
            x, y = track[i, 0] - given[0], track[i, 1] - given[1]
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
    people, scratch = [], scratch_for(len(frames))
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if last < first:
            continue
        track, found = boxes_of(k, point, seen, model)
        weights = np.zeros(len(track))
        white = whiten(found, model.noise, model.dt)
        reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        given, numbers = seen.given[first : last + 1, k].copy(), point.people[k].copy()
        prior = PeoplePrior(numbers.copy(), np.full(PERSON, KNOWN))
        if not seen.sure[k]:
            prior = PeoplePrior(model.people.mean.copy(), model.people.std.copy())
            law = height_law(numbers[0], prior.mean[0], prior.std[0])
            prior.mean[0], prior.std[0] = law.mean, law.std
        prior.mean[0] += push(found, seen.told[first : last + 1, k], white) * prior.std[0] ** 2
        person, filled = eliminate(
            k, first, track, given, numbers, found, white, weights, model.walk, prior, seen.past, damping, scratch
        )
        add_person(person, filled, scratch, gradient, hessian)
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
def let_first_go(point: Point, seen: Seen, model: Model, t: int) -> None:
    """Carry on what the frame ``t``, the first that is left, tells of people."""
    for k in range(len(seen.first)):
        last = int(seen.last[k])
        if seen.first[k] > t:
            continue
        if last <= t:
            seen.past.information[k] = 0.0
            seen.past.slope[k] = 0.0
            continue
        track = point.places[t : last + 1, k].copy()
        let_go(
            k,
            t,
            seen.boxes,
            point.frames,
            track,
            seen.given[t, k],
            seen.told[t, k],
            point.people[k].copy(),
            point.variances[k],
            model.noise,
            model.walk,
            model.dt,
            seen.past,
        )
