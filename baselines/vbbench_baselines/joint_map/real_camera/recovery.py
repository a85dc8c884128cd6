"""What follows for an eliminated person once the frames are known: its track and its numbers."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import BAND, backward, forward
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, PERSON
from vbbench_baselines.joint_map.real_camera.elimination import Person
from vbbench_baselines.joint_map.real_camera.spreading import weigh


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
    for row in range(n):
        pulled[row] += person.tie[row, 0] * numbers[0] + person.tie[row, 1] * numbers[1]
    forward(person.lower, pulled, BAND)
    for row in range(n):
        track[row] = -track[row] - pulled[row]
    backward(person.lower, track, BAND)
    return track.reshape((n // 2, 2)), numbers
