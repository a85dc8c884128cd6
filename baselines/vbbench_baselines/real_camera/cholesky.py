"""Cholesky's factor of a full symmetric matrix, which says whether there is one instead of failing."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel


@kernel
def factor(matrix: FloatArray) -> bool:
    """Put U with A = UᵀU in the place of the upper half of A [n, n]; False if A is not positive definite.

    Rows are taken away from rows: no sum runs along a row, so compilers may work on many columns at once.
    """
    n = len(matrix)
    for j in range(n):
        row = matrix[j]
        if not row[j] > 0.0:
            return False
        scale = 1.0 / np.sqrt(row[j])
        for c in range(j, n):
            row[c] *= scale
        for i in range(j + 1, n):
            share, other = row[i], matrix[i]
            if share != 0.0:
                for c in range(i, n):
                    other[c] -= share * row[c]
    return True


@kernel
def solve(upper: FloatArray, right: FloatArray) -> None:
    """Put A⁻¹ right [n] in the place of ``right``."""
    n = len(right)
    for j in range(n):
        row = upper[j]
        right[j] /= row[j]
        for c in range(j + 1, n):
            right[c] -= right[j] * row[c]
    for j in range(n - 1, -1, -1):
        row, total = upper[j], right[j]
        for c in range(j + 1, n):
            total -= row[c] * right[c]
        right[j] = total / row[j]
