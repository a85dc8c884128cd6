"""Banded symmetric positive definite matrices: Cholesky factor, solution, and the upper half of the inverse.

All have the half-bandwidth `BAND`. Row j of ``band`` [n + BAND, 2 BAND + 1] holds A[j, j], A[j + 1, j], … and
A[j + BAND, j], then zeros; the factor L with A = LLᵀ takes its place. The zeros, and `BAND` rows of them at the end,
let inner loops run over a fixed number of terms, which compilers unroll. All take time linear in n except the inverse,
which is full.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel

BAND = 8
"""Numbers that a row reaches to either side: two coordinates of those four frames back."""


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
    """Write the upper half of A⁻¹ to ``inverse`` [n + BAND, n] or larger, which must be finite.

    With X = A⁻¹, LᵀX = L⁻¹ is lower triangular: each row of X follows from the `BAND` rows below it.
    """
    n = len(lower) - BAND
    for i in range(n - 1, -1, -1):
        c, row = lower[i], inverse[i]
        x1, x2, x3, x4 = inverse[i + 1], inverse[i + 2], inverse[i + 3], inverse[i + 4]
        x5, x6, x7, x8 = inverse[i + 5], inverse[i + 6], inverse[i + 7], inverse[i + 8]
        c1, c2, c3, c4 = -c[0] * c[1], -c[0] * c[2], -c[0] * c[3], -c[0] * c[4]
        c5, c6, c7, c8 = -c[0] * c[5], -c[0] * c[6], -c[0] * c[7], -c[0] * c[8]
        for j in range(i + 1, n):  # in one expression: four times as fast as a loop over rows
            near = c1 * x1[j] + c2 * x2[j] + c3 * x3[j] + c4 * x4[j]
            row[j] = near + c5 * x5[j] + c6 * x6[j] + c7 * x7[j] + c8 * x8[j]
        total = c[0]
        for d in range(1, min(BAND, n - 1 - i) + 1):
            total -= c[d] * row[i + d]
            inverse[i + d, i] = row[i + d]
        row[i] = total * c[0]
