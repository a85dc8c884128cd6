"""Cholesky's factor of a full symmetric matrix, which says whether there is one instead of failing."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel

ROWS = 8
"""Rows that are taken away at once, so that what they are taken from is read and written less often."""

COLUMNS = 16
"""A loop over a multiple of so many columns leaves none over that would be worked on one by one."""

Eight = tuple[float, float, float, float, float, float, float, float]


@kernel
def padded(columns: int) -> int:
    """So many or a few more, a multiple of what is worked on at once."""
    return (columns + COLUMNS - 1) // COLUMNS * COLUMNS


@kernel
def take_rows(target: FloatArray, columns: int, rows: FloatArray, first: int, shares: Eight) -> None:
    """Take ``shares`` of the eight ``rows`` from the ``first`` on away from the first columns of ``target``.

    A loop that begins at 0 is one that compilers know to stay within the row, and work on many columns at once.
    """
    a, b, c, d = rows[first], rows[first + 1], rows[first + 2], rows[first + 3]
    e, f, g, h = rows[first + 4], rows[first + 5], rows[first + 6], rows[first + 7]
    s, t, u, v, w, x, y, z = shares
    for i in range(columns):
        target[i] -= s * a[i] + t * b[i] + u * c[i] + v * d[i] + w * e[i] + x * f[i] + y * g[i] + z * h[i]


@kernel
def column_of(rows: FloatArray, first: int, c: int) -> Eight:
    """The numbers of eight ``rows`` from the ``first`` on in a column."""
    return (
        rows[first, c],
        rows[first + 1, c],
        rows[first + 2, c],
        rows[first + 3, c],
        rows[first + 4, c],
        rows[first + 5, c],
        rows[first + 6, c],
        rows[first + 7, c],
    )


@kernel
def factor(matrix: FloatArray) -> bool:
    """Put L with A = LᵀL in the place of the lower half of A [n, n]; False if A is not positive definite.

    Rows are taken away from the rows above them. What is above the diagonal may change; with `padded` columns it is
    fastest.
    """
    n = len(matrix)
    for end in range(n, 0, -ROWS):
        first = max(end - ROWS, 0)
        for j in range(end - 1, first - 1, -1):
            row = matrix[j]
            if not row[j] > 0.0:
                return False
            scale = 1.0 / np.sqrt(row[j])
            for c in range(j + 1):
                row[c] *= scale
            for i in range(first, j):
                share, other = row[i], matrix[i]
                for c in range(i + 1):
                    other[c] -= share * row[c]
        for i in range(first):
            take_rows(matrix[i], min(padded(i + 1), matrix.shape[1]), matrix, first, column_of(matrix, first, i))
    return True


@kernel
def solve(lower: FloatArray, right: FloatArray) -> None:
    """Put A⁻¹ right [n] in the place of ``right``."""
    n = len(right)
    for j in range(n - 1, -1, -1):
        row = lower[j]
        share = right[j] / row[j]
        right[j] = share
        for c in range(j):
            right[c] -= share * row[c]
    for j in range(n):
        row, total = lower[j], right[j]
        for c in range(j):
            total -= row[c] * right[c]
        right[j] = total / row[j]


@kernel
def gram(lower: FloatArray, sides: FloatArray, target: FloatArray) -> None:
    """Add B A⁻¹ Bᵀ to ``target`` [r, r]; B [r, n], the first columns of ``sides``, is used up.

    ``lower`` [n, n] as `factor` leaves it; both are fastest with `padded` columns.
    """
    for end in range(len(lower), 0, -ROWS):
        first = max(end - ROWS, 0)
        for side in sides:
            for j in range(end - 1, first - 1, -1):
                side[j] /= lower[j, j]
                for c in range(first, j):
                    side[c] -= side[j] * lower[j, c]
        for a in range(len(sides)):
            for b in range(len(sides)):
                for j in range(first, end):
                    target[a, b] += sides[a, j] * sides[b, j]
        if first > 0:
            for s in sides:
                f = first
                shares = (s[f], s[f + 1], s[f + 2], s[f + 3], s[f + 4], s[f + 5], s[f + 6], s[f + 7])
                take_rows(s, min(padded(first), len(lower)), lower, first, shares)
