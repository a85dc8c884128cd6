"""What frames that have left the window told of people: information on their numbers and on their next places.

With the frames as they were found, a person's places are a chain: the walk's innovation looks `REACH` frames to either
side alike, and a box's errors know of the next box what they know of the one before. What a place that leaves is known
to be by its own box, or by what was given of it, is therefore carried to the places after it and to the numbers by

    ½ (z − z₀)ᵀ H (z − z₀) + gᵀ(z − z₀),   z = (x_1, … x_4, η, δ),

in which the place x_0 has been eliminated (Sibley, Matthies and Sukhatme, Journal of Field Robotics 27(5), 2010).
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, carried_along
from vbbench.kernels import kernel
from vbbench_baselines.common.bearings import Bearings
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.joint_map.motion.walks import REACH, Walk
from vbbench_baselines.joint_map.real_camera.cues import CUES, LENGTH, PERSON, Noise, Residuals, residuals_of

PLACES = 2 * REACH
"""Numbers of the places that are told of."""

TOLD = PLACES + PERSON
"""Numbers that are told of."""


class Past(NamedTuple):
    """Of K people: H [K, 10, 10], g [K, 10] and z₀ [K, 10]; zeros where nothing is told."""

    information: FloatArray
    slope: FloatArray
    about: FloatArray


def nothing_past(people: int) -> Past:
    """Of so many ``people`` nothing."""
    return Past(np.zeros((people, TOLD, TOLD)), np.zeros((people, TOLD)), np.zeros((people, TOLD)))


def known_before(past: Past) -> BoolArray:
    """[K] of whom the past tells."""
    return np.asarray(past.information[:, 0, 0] > 0.0)


def turn(past: Past, old: FloatArray, new: FloatArray) -> None:
    """Move and turn what is told of all people's places as the pose ``old`` [3] becomes ``new``."""
    places = past.about[:, :PLACES].reshape((-1, REACH, 2))
    past.about[:, :PLACES] = carried_along(places, old, new).reshape((-1, PLACES))
    cos, sin = np.cos(new[2] - old[2]), np.sin(new[2] - old[2])
    axes = np.eye(TOLD)
    axes[:PLACES, :PLACES] = np.kron(np.eye(REACH), np.array(((cos, -sin), (sin, cos))))
    past.slope[:] = past.slope @ axes.T
    past.information[:] = axes @ past.information @ axes.T


@kernel
def pull_of(past: Past, k: int, track: FloatArray, numbers: FloatArray) -> tuple[FloatArray, float]:
    """The gradient [10] and the energy for person ``k`` with the ``track`` [n, 2] and ``numbers`` [2]."""
    off, pull, energy = np.zeros(TOLD), np.zeros(TOLD), 0.0
    for i in range(min(len(track), REACH)):
        for a in range(2):
            off[2 * i + a] = track[i, a] - past.about[k, 2 * i + a]
    for a in range(PERSON):
        off[PLACES + a] = numbers[a] - past.about[k, PLACES + a]
    for i in range(TOLD):
        total = 0.0
        for j in range(TOLD):
            total += past.information[k, i, j] * off[j]
        pull[i] = past.slope[k, i] + total
        energy += (past.slope[k, i] + 0.5 * total) * off[i]
    return pull, energy


@kernel
def let_go(
    k: int,
    first: int,
    seen: Bearings,
    frames: FloatArray,
    track: FloatArray,
    given: FloatArray,
    told: float,
    numbers: FloatArray,
    variance: float,
    noise: Noise,
    walk: Walk,
    dt: float,
    past: Past,
) -> None:
    """Carry on what is told of person ``k``, whose ``track`` [≥ 2, 2] begins in the frame ``first`` that leaves.

    ``past`` is of the places from the first on before, and of those after it then.
    """
    ahead = min(len(track) - 1, REACH)
    found = residuals_of(k, first, seen, frames, track[: ahead + 1], numbers, noise)
    size = TOLD + 2
    slope, information, value = np.zeros(size), np.zeros((size, size)), np.zeros(size)
    for i in range(ahead + 1):
        value[2 * i], value[2 * i + 1] = track[i, 0], track[i, 1]
    value[size - 2], value[size - 1] = numbers[0], numbers[1]
    before, _ = pull_of(past, k, track, numbers)
    for i in range(TOLD):
        p = i if i < PLACES else i + 2
        slope[p] += before[i]
        for j in range(TOLD):
            information[p, j if j < PLACES else j + 2] += past.information[k, i, j]
    _add_box(found, noise, dt, slope, information)
    _add_push(found, told, slope)
    _add_walk(track, ahead, walk, variance, slope, information)
    if not np.isnan(given[0]):
        for a in range(2):
            slope[a] += (track[0, a] - given[a]) / ANCHOR_STD**2
            information[a, a] += 1.0 / ANCHOR_STD**2
    _without_first(information, slope)
    for i in range(TOLD):
        past.slope[k, i], past.about[k, i] = slope[i + 2], value[i + 2]
        for j in range(TOLD):
            past.information[k, i, j] = information[i + 2, j + 2]


@kernel
def _add_box(found: Residuals, noise: Noise, dt: float, slope: FloatArray, information: FloatArray) -> None:
    """What a box in the frame that leaves adds to the box after it."""
    if len(found.frame) == 0 or found.frame[0] != 0:
        return
    row, last = np.zeros(len(slope)), len(slope) - PERSON
    for j in range(CUES):
        count, nu, rho, added = found.counts[0, j], noise.nu[j], 0.0, found.value[0, j]
        if count == 0.0:
            continue
        row[:] = 0.0
        if len(found.frame) > 1 and count == 1.0 and found.counts[1, j] == 1.0 and found.frame[1] < REACH:
            rho = np.exp(-found.frame[1] * dt / noise.tau[j])
            p = 2 * found.frame[1]
            added -= rho * found.value[1, j]
            row[p], row[p + 1] = -rho * found.by_place[1, j, 0], -rho * found.by_place[1, j, 1]
        row[0], row[1] = found.by_place[0, j, 0], found.by_place[0, j, 1]
        for a in range(PERSON):
            row[last + a] = found.by_person[0, j, a] - (rho * found.by_person[1, j, a] if rho > 0.0 else 0.0)
        weight = count * (nu + 1.0) / (nu * (1.0 - rho * rho) + added * added)
        _add(row, added, weight, slope, information)


@kernel
def _add_push(found: Residuals, told: float, slope: FloatArray) -> None:
    """What keeps the place that leaves from coming nearer (`real_camera.volume`): −``told`` ln(r − δ)."""
    if told > 0.0 and len(found.frame) > 0 and found.frame[0] == 0:
        push = told * found.scale[0, LENGTH]
        for a in range(2):
            slope[a] -= push * found.by_place[0, LENGTH, a]
        for a in range(PERSON):
            slope[len(slope) - PERSON + a] -= push * found.by_person[0, LENGTH, a]
        slope[len(slope) - PERSON] -= told


@kernel
def _add_walk(
    track: FloatArray, ahead: int, walk: Walk, variance: float, slope: FloatArray, information: FloatArray
) -> None:
    """How the place that leaves follows from the ``ahead`` places after it."""
    row, off, square = np.zeros(len(slope)), np.zeros(2), 0.0
    for a in range(2):
        for d in range(ahead + 1):
            off[a] += walk.filters[ahead, d] * track[d, a] / walk.spreads[ahead]
        square += off[a] ** 2
    weight = 1.0 if ahead == 1 else (walk.nu + 2.0) / (walk.nu * variance + square)
    for a in range(2):
        row[:] = 0.0
        for d in range(ahead + 1):
            row[2 * d + a] = walk.filters[ahead, d] / walk.spreads[ahead]
        _add(row, off[a], weight, slope, information)


@kernel
def _add(row: FloatArray, value: float, weight: float, slope: FloatArray, information: FloatArray) -> None:
    for i in range(len(row)):
        if row[i] != 0.0:
            slope[i] += weight * row[i] * value
            for j in range(len(row)):
                information[i, j] += weight * row[i] * row[j]


@kernel
def _without_first(information: FloatArray, slope: FloatArray) -> None:
    """Eliminate the first two numbers."""
    for p in range(2):
        pivot = information[p, p]
        for i in range(p + 1, len(slope)):
            share = information[i, p] / pivot
            slope[i] -= share * slope[p]
            for j in range(p + 1, len(slope)):
                information[i, j] -= share * information[p, j]
