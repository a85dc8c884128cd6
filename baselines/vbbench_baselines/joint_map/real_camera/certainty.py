"""How sure the joint problem of a real camera is of poses and places."""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import solve
from vbbench_baselines.joint_map.real_camera.cholesky import factor, gram, padded
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, PERSON
from vbbench_baselines.joint_map.real_camera.elimination import Person
from vbbench_baselines.joint_map.real_camera.joint import SOFTEST, Seen, System
from vbbench_baselines.joint_map.real_camera.spreading import weigh

LEAST = 1e-12
"""In m² and rad²; no variance is told to be less."""

POSE = 3
"""Numbers of a pose."""

HELD = 2
"""Frames at the beginning of a window that has left others behind whose poses stay as they were found."""

MODEL_ERROR = (3.0, 5.5)
"""By how much larger squared errors of poses and of places are than the model says, which is never quite true: middle
values over KITTI 0015, 0017 and 0019 and over tier `field` of Hotel, ETH, Students and `sim` (docs/real-cameras.md)."""


@kernel
def spread_of(system: System, seen: Seen, since: int, people: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Covariances [n, 3, 3] of the poses and [n, K, 2, 2] of the places of the frames from ``since`` on.

    They are of the point that the ``system`` is about, NaN where no box is, and of all places unless those of
    ``people`` are asked for. The last is that of the pose [3, 3] after the first `HELD`.
    """
    early = np.zeros((POSE, POSE))
    if since == len(seen.fixed):
        return np.zeros((0, POSE, POSE)), np.zeros((0, 0, 2, 2)), early
    frames = len(seen.fixed)
    lower = factor_softly(system.hessian)
    poses, places = np.zeros((frames - since, POSE, POSE)), np.full((frames - since, len(seen.first), 2, 2), np.nan)
    if frames > HELD:
        _put_pose(HELD, seen.fixed, lower, early)
    for t in range(since, frames):
        _put_pose(t, seen.fixed, lower, poses[t - since])
        for person in system.people:
            if people and not np.isnan(seen.boxes.azimuth[t, person.number]):
                put_place(person, t - person.first, seen.fixed, lower, places[t - since, person.number])
    return MODEL_ERROR[0] * poses, MODEL_ERROR[1] * places, MODEL_ERROR[0] * early


@kernel
def _put_pose(t: int, fixed: BoolArray, lower: FloatArray, covariance: FloatArray) -> None:
    """Write the ``covariance`` [3, 3] of the pose of frame ``t``."""
    sides = np.zeros((POSE, padded(len(lower))))
    for a in range(POSE):
        sides[a, FRAME * t + a] = 1.0
        covariance[a, a] = LEAST
    if not fixed[t]:
        gram(lower, sides, covariance)


@kernel
def factor_softly(hessian: FloatArray) -> FloatArray:
    """The factor of a matrix that is positive definite but for rounding, with as little added as makes it so."""
    softness, lower = SOFTEST, hessian.copy()
    for p in range(len(lower)):
        lower[p, p] += softness
    while not factor(lower) and softness < 1.0:
        softness *= 100.0
        for p in range(len(lower)):
            for q in range(p):
                lower[p, q] = hessian[p, q]
            lower[p, p] = hessian[p, p] + softness
    return lower


@kernel
def put_place(person: Person, frame: int, fixed: BoolArray, lower: FloatArray, covariance: FloatArray) -> None:
    """Write the ``covariance`` [2, 2] of a person's place in a frame of its track.

    It is that if all frames were known, and what these add, whose information has the factor ``lower``.
    """
    sides, by_numbers = np.zeros((2, padded(len(lower)))), np.zeros((2, PERSON))
    for a in range(2):
        back = np.zeros(len(person.pull))
        back[2 * frame + a] = 1.0
        solve(person.lower, back)
        _by_frames(person, back, fixed, sides[a], by_numbers[a])
        covariance[a, 0], covariance[a, 1] = back[2 * frame], back[2 * frame + 1]
    add_spread(by_numbers, person.inner, covariance)
    gram(lower, sides, covariance)


@kernel
def add_spread(by_numbers: FloatArray, inner: FloatArray, covariance: FloatArray) -> None:
    """Add S C Sᵀ to a ``covariance`` [m, m]: what moves with two numbers by S [m, 2], whose covariance is C [2, 2]."""
    for a in range(len(by_numbers)):
        for b in range(len(by_numbers)):
            for q in range(PERSON):
                share = inner[q, 0] * by_numbers[b, 0] + inner[q, 1] * by_numbers[b, 1]
                covariance[a, b] += by_numbers[a, q] * share


@kernel
def put_own_spread(person: Person, frame: int, by_numbers: FloatArray, alone: FloatArray) -> None:
    """Write how a person's place in a frame of its track moves with the numbers [2, 2], and its covariance [2, 2].

    The covariance is that of the place if numbers and frames were sure.
    """
    for a in range(2):
        back = np.zeros(len(person.pull))
        back[2 * frame + a] = 1.0
        solve(person.lower, back)
        by_numbers[a, 0] = by_numbers[a, 1] = 0.0
        _by_residuals(person, back, by_numbers[a])
        alone[a, 0], alone[a, 1] = back[2 * frame], back[2 * frame + 1]


@kernel
def _by_residuals(person: Person, back: FloatArray, numbers: FloatArray) -> FloatArray:
    """How a place moves with residuals [m, 3]; with the ``numbers`` [2] is added to these.

    ``back`` [2n] is the row of A⁻¹ of the place.
    """
    found, m = person.found, len(person.found.frame)
    values, unused = np.empty((m, CUES)), np.zeros(len(back))
    for i in range(m):
        r = 2 * found.frame[i]
        for j in range(CUES):
            values[i, j] = -(found.by_place[i, j, 0] * back[r] + found.by_place[i, j, 1] * back[r + 1])
    weighed = weigh(found, person.white, values, unused)
    for row in range(len(back)):
        for q in range(PERSON):
            numbers[q] -= back[row] * person.tie[row, q]
    for i in range(m):
        for j in range(CUES):
            for q in range(PERSON):
                numbers[q] += weighed[i, j] * found.by_person[i, j, q]
    return weighed


@kernel
def _by_frames(person: Person, back: FloatArray, fixed: BoolArray, side: FloatArray, numbers: FloatArray) -> None:
    """Add how a place moves with all frames [7T] that are not ``fixed``, and, if these stay, with the ``numbers`` [2].

    ``back`` [2n] is the row of A⁻¹ of the place.
    """
    found, inner, m = person.found, person.inner, len(person.found.frame)
    weighed = _by_residuals(person, back, numbers)
    u = numbers[0] * inner[0, 0] + numbers[1] * inner[1, 0]
    v = numbers[0] * inner[0, 1] + numbers[1] * inner[1, 1]
    for i in range(m):
        t = person.first + found.frame[i]
        for j in range(CUES):
            share = weighed[i, j] - (u * person.across[0, CUES * i + j] + v * person.across[1, CUES * i + j])
            for q in range(POSE if fixed[t] else 0, FRAME):
                side[FRAME * t + q] += share * found.by_frame[i, j, q]
