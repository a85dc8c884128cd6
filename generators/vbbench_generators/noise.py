"""Noise that remembers: an Ornstein–Uhlenbeck process, sampled once a frame."""

import numpy as np

from vbbench.geometry import FloatArray


def wandering(shape: tuple[int, ...], memory: float, dt: float, rng: np.random.Generator) -> FloatArray:
    """Standard normal numbers of any shape, correlated over time t in s, the first axis, with e^(−t/``memory``).

    ``memory`` and ``dt``, the time from one row to the next, are in s.
    """
    numbers = rng.standard_normal(shape)
    kept = np.exp(-dt / memory)
    for t in range(1, len(numbers)):
        numbers[t] = kept * numbers[t - 1] + np.sqrt(1.0 - kept**2) * numbers[t]
    return numbers
