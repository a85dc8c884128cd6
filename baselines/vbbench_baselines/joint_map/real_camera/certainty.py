"""How sure the joint problem of a real camera is of poses and places."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import BAND, forward
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, PERSON
from vbbench_baselines.joint_map.real_camera.elimination import Person
from vbbench_baselines.joint_map.real_camera.joint import SOFTEST, Model, Point, Seen, linearise

LEAST = 1e-12
"""In m² and rad²; no variance is told to be less."""


@kernel
def covariances_of(point: Point, seen: Seen, model: Model, since: int) -> tuple[FloatArray, FloatArray]:
    """[n, 3, 3] of the poses and [n, K, 2, 2] of the places of the frames from ``since`` on, NaN where no box is."""
    system = linearise(point, seen, model, 0.0)
    frames = len(point.frames)
    matrix = system.hessian
    for p in range(len(matrix)):
        matrix[p, p] += SOFTEST
        matrix[p, p + 1 :] = matrix[p + 1 :, p]
    covariance = np.ascontiguousarray(np.linalg.inv(matrix))
    for t in range(frames):
        if seen.fixed[t]:
            covariance[FRAME * t : FRAME * t + 3] = 0.0
            covariance[:, FRAME * t : FRAME * t + 3] = 0.0
    poses, places = np.empty((frames - since, 3, 3)), np.full((frames - since, len(seen.first), 2, 2), np.nan)
    for t in range(since, frames):
        poses[t - since] = covariance[FRAME * t : FRAME * t + 3, FRAME * t : FRAME * t + 3] + LEAST * np.eye(3)
        for person in system.people:
            k = person.number
            if person.first <= t <= int(seen.last[k]) and not np.isnan(seen.boxes.azimuth[t, k]):
                places[t - since, k] = place_covariance(person, t - person.first, covariance)
    return poses, places


@kernel
def place_covariance(person: Person, frame: int, covariance: FloatArray) -> FloatArray:
    """[2, 2] of the person's place in a frame of its track; ``covariance`` [7T, 7T] of the frames."""
    found = person.found
    m = len(found.frame)
    by_residual, by_numbers, alone = own_spread(person, frame)
    across = np.ascontiguousarray(person.across[:, : CUES * m])
    by_residual = by_residual - (by_numbers @ person.inner) @ across
    by_frames = np.zeros((2, FRAME * m))
    columns = np.empty(FRAME * m, np.int64)
    for i in range(m):
        for a in range(FRAME):
            columns[FRAME * i + a] = FRAME * (person.first + found.frame[i]) + a
            for j in range(CUES):
                for b in range(2):
                    by_frames[b, FRAME * i + a] += by_residual[b, CUES * i + j] * found.by_frame[i, j, a]
    own = np.empty((FRAME * m, FRAME * m))
    for i in range(FRAME * m):
        for j in range(FRAME * m):
            own[i, j] = covariance[columns[i], columns[j]]
    of_numbers = by_numbers @ person.inner @ np.ascontiguousarray(by_numbers.T)
    total: FloatArray = alone + of_numbers + by_frames @ own @ np.ascontiguousarray(by_frames.T)
    return total


@kernel
def own_spread(person: Person, frame: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """How a person's place in a frame of its track moves with residuals [2, 3m] and numbers [2, 2]; its covariance.

    The covariance [2, 2] is that of the place if numbers and frames were sure.
    """
    found, n = person.found, len(person.pull) // 2
    m = len(found.frame)
    spread = np.ascontiguousarray(person.spread[BAND : BAND + 2 * n, : CUES * m])
    back = np.zeros((2, 2 * n))  # L⁻¹ of the place's unit vectors
    for a in range(2):
        back[a, 2 * frame + a] = 1.0
        forward(person.lower, back[a], BAND)
    by_residual = -(back @ spread)
    by_numbers = by_residual @ found.by_person.copy().reshape((CUES * m, PERSON))
    return by_residual, by_numbers, back @ np.ascontiguousarray(back.T)
