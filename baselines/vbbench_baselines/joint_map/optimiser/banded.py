"""Banded symmetric positive definite matrices: Cholesky factor, solution, and the band of the inverse.

All have the half-bandwidth `BAND`. Row j of ``band`` [n + BAND, 2 BAND + 1] holds A[j, j], A[j + 1, j], … and
A[j + BAND, j], then zeros; the factor L with A = LLᵀ takes its place. The zeros, and `BAND` rows of them at the end,
let inner loops run over a fixed number of terms, which compilers unroll. The same for any half-bandwidth has ``_wide``
in its name. All take time linear in n.
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
    forward(lower, right, BAND)
    backward(lower, right, BAND)


@kernel
def forward(lower: FloatArray, right: FloatArray, width: int) -> None:
    """Put L⁻¹ right [n] in the place of ``right``; ``width`` is the half-bandwidth."""
    n = len(right)
    for j in range(n):
        right[j] *= lower[j, 0]
        for d in range(1, min(width, n - 1 - j) + 1):
            right[j + d] -= lower[j, d] * right[j]


@kernel
def backward(lower: FloatArray, right: FloatArray, width: int) -> None:
    """The same with L⁻ᵀ."""
    n = len(right)
    for j in range(n - 1, -1, -1):
        total = right[j]
        for d in range(1, min(width, n - 1 - j) + 1):
            total -= lower[j, d] * right[j + d]
        right[j] = total * lower[j, 0]


@kernel
def invert(lower: FloatArray, inverse: FloatArray) -> None:
    """Write the band of A⁻¹ about its diagonal to ``inverse`` [n + BAND or more, BAND + width].

    Row i gets A⁻¹[i, i + e] at BAND + e, for e from −BAND to width − 1, as far as the matrix goes. With X = A⁻¹,
    LᵀX = L⁻¹ is lower triangular: each row of X follows from the `BAND` rows below it, and its band from theirs.
    ``lower`` as `factor` leaves it.
    """
    n, width = len(lower) - BAND, inverse.shape[1] - BAND
    inverse[n : n + BAND] = 0.0
    for i in range(n - 1, -1, -1):
        c, row = lower[i], inverse[i]
        x1, x2, x3, x4 = inverse[i + 1], inverse[i + 2], inverse[i + 3], inverse[i + 4]
        x5, x6, x7, x8 = inverse[i + 5], inverse[i + 6], inverse[i + 7], inverse[i + 8]
        c1, c2, c3, c4 = -c[0] * c[1], -c[0] * c[2], -c[0] * c[3], -c[0] * c[4]
        c5, c6, c7, c8 = -c[0] * c[5], -c[0] * c[6], -c[0] * c[7], -c[0] * c[8]
        for j in range(BAND + 1, BAND + min(width, n - i)):  # in one expression: four times as fast as a loop over rows
            near = c1 * x1[j - 1] + c2 * x2[j - 2] + c3 * x3[j - 3] + c4 * x4[j - 4]
            row[j] = near + c5 * x5[j - 5] + c6 * x6[j - 6] + c7 * x7[j - 7] + c8 * x8[j - 8]
        total = c[0]
        for d in range(1, min(BAND, n - 1 - i) + 1):
            total -= c[d] * row[BAND + d]
            inverse[i + d, BAND - d] = row[BAND + d]
        row[BAND] = total * c[0]


@kernel
def factor_wide(band: FloatArray) -> bool:
    """`factor` of a matrix of any half-bandwidth w in ``band`` [n + w, w + 1]; returns whether it was positive."""
    width = band.shape[1] - 1
    n = len(band) - width
    for j in range(n):
        column = band[j]
        if not column[0] > 0.0:
            return False
        column[0] = 1.0 / np.sqrt(column[0])
        for d in range(1, width + 1):
            column[d] *= column[0]
        for d in range(1, min(width, n - 1 - j) + 1):
            share, other = column[d], band[j + d]
            if share != 0.0:
                for e in range(width + 1 - d):
                    other[e] -= share * column[d + e]
    return True


@kernel
def solve_wide(lower: FloatArray, right: FloatArray) -> None:
    """Put A⁻¹ right [n] in the place of ``right``; ``lower`` as `factor_wide` leaves it."""
    width = lower.shape[1] - 1
    forward(lower, right, width)
    backward(lower, right, width)


@kernel
def invert_wide(lower: FloatArray) -> FloatArray:
    """The band [n, w + 1] of A⁻¹ as `factor_wide` takes one, from its factor ``lower``."""
    width = lower.shape[1] - 1
    n = len(lower) - width
    inverse = np.zeros((n, width + 1))
    for i in range(n - 1, -1, -1):
        c, reach = lower[i], min(width, n - 1 - i)
        for e in range(1, reach + 1):
            total = 0.0
            for d in range(1, reach + 1):
                near, far = min(d, e), max(d, e)
                total += c[d] * inverse[i + near, far - near]
            inverse[i, e] = -c[0] * total
        total = c[0]
        for d in range(1, reach + 1):
            total -= c[d] * inverse[i, d]
        inverse[i, 0] = total * c[0]
    return inverse
