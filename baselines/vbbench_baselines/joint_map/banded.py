"""Banded symmetric positive definite matrices: Cholesky factor, solution, and the lower half of the inverse.

All have the half-bandwidth `BAND`. Row j of ``band`` [n + BAND, 2 BAND + 1] holds A[j, j], A[j + 1, j], … and
A[j + BAND, j], then noughts; the factor L with A = LLᵀ takes its place. The noughts, and `BAND` rows of them in the
end, let inner loops run over a fixed number of terms, which compilers unroll. All take time linear in n but for the
inverse, which is full.
"""

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_baselines.compiled import kernel

BAND = 8
"""Numbers that a row reaches to either side: two coordinates of those four frames back."""


@kernel
def no_band(n: int) -> FloatArray:
    """Room for a matrix [n, n]: noughts."""
    return np.zeros((n + BAND, 2 * BAND + 1))


@kernel
def factor(band: FloatArray) -> None:
    """Put the Cholesky factor in the place of the matrix; its diagonal is kept as reciprocals."""
    for j in range(len(band) - BAND):
        column = band[j]
        column[0] = 1.0 / np.sqrt(column[0])
        for d in range(1, BAND + 1):
            column[d] *= column[0]
        for d in range(1, BAND + 1):
            share, other = column[d], band[j + d]
            for e in range(BAND):
                other[e] -= share * column[d + e]


@kernel
def solve(lower: FloatArray, right: FloatArray) -> None:
    """Put A⁻¹ right [n] in the place of ``right``; ``lower`` as `factor` leaves it."""
    n = len(right)
    for j in range(n):
        right[j] *= lower[j, 0]
        for d in range(1, min(BAND, n - 1 - j) + 1):
            right[j + d] -= lower[j, d] * right[j]
    for j in range(n - 1, -1, -1):
        total = right[j]
        for d in range(1, min(BAND, n - 1 - j) + 1):
            total -= lower[j, d] * right[j + d]
        right[j] = total * lower[j, 0]


@kernel
def invert(lower: FloatArray, inverse: FloatArray) -> None:
    """Write the lower half of A⁻¹, its diagonal included, to ``inverse`` [n, n] or larger; the rest is left alone."""
    n = len(lower) - BAND
    for i in range(n):
        row = inverse[i]
        row[: i + 1] = 0.0
        row[i] = 1.0
        for d in range(1, min(BAND, i) + 1):
            share, other = lower[i - d, d], inverse[i - d]
            for j in range(i - d + 1):
                row[j] -= share * other[j]
        for j in range(i + 1):
            row[j] *= lower[i, 0]
    for i in range(n - 1, -1, -1):
        row = inverse[i]
        for d in range(1, min(BAND, n - 1 - i) + 1):
            share, other = lower[i, d], inverse[i + d]
            for j in range(i + 1):
                row[j] -= share * other[j]
        for j in range(i + 1):
            row[j] *= lower[i, 0]
