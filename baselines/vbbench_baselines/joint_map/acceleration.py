"""Anderson's acceleration: a fixed point is guessed from the last points and where one step led from each.

Renewing weights and stepping is a map x → F(x) that comes near its fixed point linearly. Of the last few pairs the
combination Σ α_i F(x_i), Σ α_i = 1, is taken for which Σ α_i (F(x_i) − x_i) is shortest (D. G. Anderson 1965,
"Iterative procedures for nonlinear integral equations"). Whether the guess is better is for the caller to find out.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel

DEPTH = 6
"""Differences that are combined."""


class Past(NamedTuple):
    """The last points in a ring.

    Attributes
    ----------
    points, moves : [DEPTH + 1, n] F(x_i) and F(x_i) − x_i.
    entered : [1] how many were entered.
    """

    points: FloatArray
    moves: FloatArray
    entered: IntArray


@kernel
def no_past(size: int) -> Past:
    """Nothing entered yet, for points [``size``]."""
    return Past(np.zeros((DEPTH + 1, size)), np.zeros((DEPTH + 1, size)), np.zeros(1, np.int64))


@kernel
def extrapolate(past: Past, here: FloatArray, there: FloatArray) -> FloatArray:
    """Enter that a step leads from ``here`` [n] to ``there`` [n], and guess where the steps lead in the end."""
    used, slot = min(past.entered[0], DEPTH), past.entered[0] % (DEPTH + 1)
    past.points[slot], past.moves[slot] = there, there - here
    past.entered[0] += 1
    differences, move = np.empty((used, len(here))), past.moves[slot]
    for j in range(used):
        differences[j] = move - past.moves[(slot - 1 - j) % (DEPTH + 1)]
    gram = differences @ differences.T
    for j in range(used):
        gram[j, j] = gram[j, j] * (1.0 + 1e-8) + 1e-300
    share, guess = np.linalg.solve(gram, differences @ move), there.copy()
    for j in range(used):
        guess -= share[j] * (there - past.points[(slot - 1 - j) % (DEPTH + 1)])
    return guess
