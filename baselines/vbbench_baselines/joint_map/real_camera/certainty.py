"""How sure the joint problem of a real camera is of poses and places."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import BAND, forward
from vbbench_baselines.joint_map.real_camera.cholesky import factor, gram, padded
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, PERSON
from vbbench_baselines.joint_map.real_camera.elimination import Person
from vbbench_baselines.joint_map.real_camera.joint import SOFTEST, Model, Point, Seen, linearise

LEAST = 1e-12
"""In m² and rad²; no variance is told to be less."""

POSE = 3
"""Numbers of a pose."""


@kernel
def covariances_of(point: Point, seen: Seen, model: Model, since: int) -> tuple[FloatArray, FloatArray]:
    """[n, 3, 3] of the poses and [n, K, 2, 2] of the places of the frames from ``since`` on, NaN where no box is."""
    system, frames, people = linearise(point, seen, model, 0.0), len(point.frames), len(seen.first)
    lower = factor_softly(system.hessian)
    poses, places = np.zeros((frames - since, POSE, POSE)), np.empty((frames - since, people, 2, 2))
    for t in range(since, frames):
        for k in range(people):
            for a in range(4):
                places[t - since, k, a // 2, a % 2] = np.nan
        if not seen.fixed[t]:
            sides = np.zeros((POSE, padded(len(lower))))
            for a in range(POSE):
                sides[a, FRAME * t + a] = 1.0
            gram(lower, sides, poses[t - since])
        for a in range(POSE):
            poses[t - since, a, a] += LEAST
        for person in system.people:
            k = person.number
            if person.first <= t <= int(seen.last[k]) and not np.isnan(seen.boxes.azimuth[t, k]):
                alone, sides = place_by_frames(person, t - person.first, padded(len(lower)))
                for p in range(FRAME * frames):
                    if seen.fixed[p // FRAME] and p % FRAME < POSE:
                        sides[0, p] = sides[1, p] = 0.0
                gram(lower, sides, alone)
                for a in range(4):
                    places[t - since, k, a // 2, a % 2] = alone[a // 2, a % 2]
    return poses, places


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
def place_by_frames(person: Person, frame: int, columns: int) -> tuple[FloatArray, FloatArray]:
    """The covariance [2, 2] of a person's place in a frame of its track if all frames [T, 7] were known, and how the
    place moves with them [2, columns]."""
    found, inner, n, m = person.found, person.inner, len(person.pull), len(person.found.frame)
    alone, by_numbers = np.zeros((2, 2)), np.zeros((2, PERSON))
    by_residual, by_frames = np.zeros((2, CUES * m)), np.zeros((2, columns))
    back = np.zeros((2, n))  # L⁻¹ of the place's unit vectors
    for a in range(2):
        back[a, 2 * frame + a] = 1.0
        forward(person.lower, back[a], BAND)
        for row in range(2 * frame, n):
            share, spread = back[a, row], person.spread[BAND + row]
            for c in range(CUES * m):
                by_residual[a, c] -= share * spread[c]
        for i in range(m):
            for j in range(CUES):
                for q in range(PERSON):
                    by_numbers[a, q] += by_residual[a, CUES * i + j] * found.by_person[i, j, q]
    for a in range(2):
        u = by_numbers[a, 0] * inner[0, 0] + by_numbers[a, 1] * inner[1, 0]
        v = by_numbers[a, 0] * inner[0, 1] + by_numbers[a, 1] * inner[1, 1]
        for b in range(2):
            for row in range(2 * frame, n):
                alone[a, b] += back[a, row] * back[b, row]
            alone[a, b] += u * by_numbers[b, 0] + v * by_numbers[b, 1]
        for i in range(m):
            start = FRAME * (person.first + found.frame[i])
            for j in range(CUES):
                c = CUES * i + j
                share = by_residual[a, c] - (u * person.across[0, c] + v * person.across[1, c])
                for q in range(FRAME):
                    by_frames[a, start + q] += share * found.by_frame[i, j, q]
    return alone, by_frames
