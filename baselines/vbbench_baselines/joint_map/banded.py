"""Banded symmetric positive definite matrices: Cholesky factor, solution, and the lower half of the inverse.

Row i of ``band`` [n, w + 1] holds A[i, i], A[i, i−1], … A[i, i−w]; the factor L with A = LLᵀ takes its place. All take
time linear in n but for the inverse, which is full.
"""

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_baselines.compiled import kernel


@kernel
def factor(band: FloatArray) -> None:
    """Put the Cholesky factor in the place of the matrix; its diagonal is kept as reciprocals."""
    n, width = band.shape
    for i in range(n):
        reach = min(width - 1, i)
        for d in range(reach, 0, -1):
            j = i - d
            total = band[i, d]
            for e in range(d + 1, min(width - 1, d + j, reach) + 1):
                total -= band[i, e] * band[j, e - d]
            band[i, d] = total * band[j, 0]
        total = band[i, 0]
        for e in range(1, reach + 1):
            total -= band[i, e] * band[i, e]
        band[i, 0] = 1.0 / np.sqrt(total)


@kernel
def solve(lower: FloatArray, right: FloatArray) -> None:
    """Put A⁻¹ right [n] in the place of ``right``; ``lower`` as `factor` leaves it."""
    n, width = lower.shape
    for i in range(n):
        total = right[i]
        for d in range(1, min(width - 1, i) + 1):
            total -= lower[i, d] * right[i - d]
        right[i] = total * lower[i, 0]
    for i in range(n - 1, -1, -1):
        total = right[i]
        for d in range(1, min(width - 1, n - 1 - i) + 1):
            total -= lower[i + d, d] * right[i + d]
        right[i] = total * lower[i, 0]


@kernel
def invert(lower: FloatArray, inverse: FloatArray) -> None:
    """Write the lower half of A⁻¹, its diagonal included, to ``inverse`` [n, n]; the upper half is left alone."""
    n, width = lower.shape
    for i in range(n):
        row = inverse[i]
        row[: i + 1] = 0.0
        row[i] = 1.0
        for d in range(1, min(width - 1, i) + 1):
            factor_id, other = lower[i, d], inverse[i - d]
            for j in range(i - d + 1):
                row[j] -= factor_id * other[j]
        for j in range(i + 1):
            row[j] *= lower[i, 0]
    for i in range(n - 1, -1, -1):
        row = inverse[i]
        for d in range(1, min(width - 1, n - 1 - i) + 1):
            factor_id, other = lower[i + d, d], inverse[i + d]
            for j in range(i + 1):
                row[j] -= factor_id * other[j]
        for j in range(i + 1):
            row[j] *= lower[i, 0]
