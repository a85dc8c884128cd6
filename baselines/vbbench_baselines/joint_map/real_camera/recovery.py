"""What follows for an eliminated person once the frames are known: its track, its numbers, and how certain they are."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import BAND
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, PERSON
from vbbench_baselines.joint_map.real_camera.elimination import Person
from vbbench_baselines.joint_map.real_camera.spreading import forward, weigh


@kernel
def follow(person: Person, step: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How track [n, 2] and numbers [2] move when the frames move by ``step`` [T, 7]."""
    found, white, n = person.found, person.white, len(person.pull)
    m = len(found.frame)
    move, track, slope = np.zeros((m, CUES)), person.pull.copy(), person.slope.copy()
    for i in range(m):
        for j in range(CUES):
            for a in range(FRAME):
                move[i, j] += found.by_frame[i, j, a] * step[person.first + found.frame[i], a]
            slope[0] += person.across[0, CUES * i + j] * move[i, j]
            slope[1] += person.across[1, CUES * i + j] * move[i, j]
    numbers = np.empty(PERSON)
    for a in range(PERSON):
        numbers[a] = -(person.inner[a, 0] * slope[0] + person.inner[a, 1] * slope[1])
    for i in range(m):
        for j in range(CUES):
            move[i, j] += found.by_person[i, j, 0] * numbers[0] + found.by_person[i, j, 1] * numbers[1]
    pulled = np.zeros(n)
    weigh(found, white, move, pulled)
    forward(person.lower, pulled)
    for row in range(n - 1, -1, -1):
        total = -track[row] - pulled[row]
        for e in range(1, min(BAND, n - 1 - row) + 1):
            total -= person.lower[row, e] * track[row + e]
        track[row] = total * person.lower[row, 0]
    return track.reshape((n // 2, 2)), numbers


@kernel
def place_covariance(person: Person, frame: int, covariance: FloatArray) -> FloatArray:
    """[2, 2] of the person's place in a frame of its track; ``covariance`` [7T, 7T] of the frames."""
    found, n = person.found, len(person.pull) // 2
    m = len(found.frame)
    across = np.ascontiguousarray(person.across[:, : CUES * m])
    spread = np.ascontiguousarray(person.spread[BAND : BAND + 2 * n, : CUES * m])
    back = np.zeros((2, 2 * n))  # L⁻¹ of the place's unit vectors
    for a in range(2):
        row = back[a]
        row[2 * frame + a] = 1.0
        for i in range(2 * frame, 2 * n):
            row[i] *= person.lower[i, 0]
            for e in range(1, min(BAND, 2 * n - 1 - i) + 1):
                row[i + e] -= person.lower[i, e] * row[i]
    by_residual = -(back @ spread)  # [2, 3m]: of the place by the residuals
    by_numbers = by_residual @ found.by_person.copy().reshape((CUES * m, PERSON))
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
    alone = back @ np.ascontiguousarray(back.T)
    of_numbers = by_numbers @ person.inner @ np.ascontiguousarray(by_numbers.T)
    total: FloatArray = alone + of_numbers + by_frames @ own @ np.ascontiguousarray(by_frames.T)
    return total
