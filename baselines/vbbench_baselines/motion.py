"""Where people and the observer are expected at t, from where they were at t−1 and t−2."""

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_baselines.compiled import kernel

ANCHOR_STD = 1e-3
"""Standard deviation in m of a position given at t itself."""


@kernel
def continue_people(positions: FloatArray, motion_std: float, stay_std: float) -> tuple[FloatArray, FloatArray]:
    """Constant velocity, x = 2x' − x'' (arXiv 2111.05060, eq. 10), as far as the past is known.

    Parameters
    ----------
    positions : [3, K, 2] at t−2, t−1 and t in m, NaN = unknown. Row t is where people are, if known.
    motion_std : standard deviation in m of a person about 2x' − x''.
    stay_std : the same about the one known past position, for each frame since.

    Returns
    -------
    [K, 2] expected positions in m and [K] their standard deviations in m, NaN for people with no known position.
    """
    people = positions.shape[1]
    expected, std = np.full((people, 2), np.nan), np.full(people, np.nan)
    for k in range(people):
        before, last, now = positions[0, k], positions[1, k], positions[2, k]
        if not np.isnan(now[0]):
            expected[k], std[k] = now, ANCHOR_STD
        elif np.isnan(last[0]):
            if not np.isnan(before[0]):
                expected[k], std[k] = before, 2.0 * stay_std
        elif np.isnan(before[0]):
            expected[k], std[k] = last, stay_std
        else:
            expected[k], std[k] = 2.0 * last - before, motion_std
    return expected, std


@kernel
def continue_observer(poses: FloatArray) -> FloatArray:
    """The observer at constant velocity, looking where it looked: poses [3, 3] at t−2, t−1, t → [3] at t.

    The world's origin is the answer where no pose is known at all.
    """
    pose = np.zeros(3)
    if not np.isnan(poses[1, 0]):
        pose[:] = poses[1]
        if not np.isnan(poses[0, 0]):
            pose[:2] += poses[1, :2] - poses[0, :2]
    elif not np.isnan(poses[0, 0]):
        pose[:] = poses[0]
    return pose
