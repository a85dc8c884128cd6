"""How a person's track spreads what one box tells to the others: products with Z and Ψ of `elimination`."""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import BAND, forward
from vbbench_baselines.joint_map.real_camera.cholesky import ROWS, column_of, padded, take_rows
from vbbench_baselines.joint_map.real_camera.cues import CUES, PERSON, Residuals, Whitened


@kernel
def weigh(found: Residuals, white: Whitened, values: FloatArray, pull: FloatArray) -> FloatArray:
    """Ω values [m, 3] of ``values`` by box; Q_xᵀ times these is added to ``pull`` [2n]."""
    m, weighed = len(found.frame), np.empty((len(found.frame), CUES))
    for i in range(m):
        r = 2 * found.frame[i]
        for j in range(CUES):
            total = white.diagonal[i, j] * values[i, j]
            if i > 0:
                total += white.beside[i, j] * values[i - 1, j]
            if i + 1 < m:
                total += white.beside[i + 1, j] * values[i + 1, j]
            weighed[i, j] = total
            pull[r] += found.by_place[i, j, 0] * total
            pull[r + 1] += found.by_place[i, j, 1] * total
    return weighed


@kernel
def sides_of(
    found: Residuals, white: Whitened, lower: FloatArray, pull: FloatArray, tie: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """ΩQ_p, transposed and padded with zeros, and L⁻¹(Q_xᵀΩQ_p + C) beside y [2n, 3], above zeros."""
    m, n = len(found.frame), len(pull)
    across, sides = np.zeros((PERSON, padded(CUES * m))), np.zeros((n + ROWS, PERSON + 1))
    values = np.empty((m, CUES))
    for a in range(PERSON):
        side = tie[:, a].copy()
        for i in range(m):
            for j in range(CUES):
                values[i, j] = found.by_person[i, j, a]
        weighed = weigh(found, white, values, side)
        for i in range(m):
            for j in range(CUES):
                across[a, CUES * i + j] = weighed[i, j]
        forward(lower, side, BAND)
        for row in range(n):
            sides[row, a] = side[row]
    for row in range(n):
        sides[row, PERSON] = pull[row]
    return across, sides


@kernel
def fill_spread(found: Residuals, white: Whitened, lower: FloatArray, spread: FloatArray) -> IntArray:
    """Put Z below the first `BAND` rows of ``spread``, which stay 0; returns how many of its columns [2n] have begun.

    A column begins with the frame of the box before. Rows after Z are 0 as far as `take_rows` reads them.
    """
    m, n = len(found.frame), len(lower) - BAND
    filled = np.zeros(n, np.int64)
    for row in range(BAND, BAND + n + PERSON + ROWS):
        here = spread[row]
        for c in range(padded(CUES * m)):
            here[c] = 0.0
    for i in range(m):
        begins = found.frame[i]
        for j in range(CUES):
            c = CUES * i + j
            _put(spread, c, found, i, j, white.diagonal[i, j])
            if white.beside[i, j] != 0.0:
                begins = found.frame[i - 1]
                _put(spread, c, found, i - 1, j, white.beside[i, j])
            if i + 1 < m:
                _put(spread, c, found, i + 1, j, white.beside[i + 1, j])
        for row in range(2 * begins, n):
            filled[row] = padded(CUES * (i + 1))
    for row in range(n):
        here, scale = spread[BAND + row], lower[row, 0]
        shares = (
            lower[max(row - 8, 0), 8],
            lower[max(row - 7, 0), 7],
            lower[max(row - 6, 0), 6],
            lower[max(row - 5, 0), 5],
            lower[max(row - 4, 0), 4],
            lower[max(row - 3, 0), 3],
            lower[max(row - 2, 0), 2],
            lower[max(row - 1, 0), 1],
        )
        take_rows(here, filled[row], spread, row, shares)
        for c in range(filled[row]):
            here[c] *= scale
    return filled


@kernel
def _put(spread: FloatArray, column: int, found: Residuals, i: int, j: int, share: float) -> None:
    """Write a share of a box's slopes by its place to where it is in a ``column`` of Z."""
    row = BAND + 2 * found.frame[i]
    spread[row, column] = share * found.by_place[i, j, 0]
    spread[row + 1, column] = share * found.by_place[i, j, 1]


@kernel
def add_numbers(spread: FloatArray, filled: IntArray, sides: FloatArray, across: FloatArray, force: FloatArray) -> None:
    """Make U of ``across``, which is ΩQ_p, and φ of ``force``, which is Ωq."""
    n = len(filled)
    for row in range(0, n, ROWS):
        columns = filled[min(row + ROWS, n) - 1]
        for a in range(PERSON):
            take_rows(across[a], columns, spread, BAND + row, column_of(sides, row, a))
        take_rows(force, columns, spread, BAND + row, column_of(sides, row, PERSON))


@kernel
def information_of(
    i: int, start: int, white: Whitened, spread: FloatArray, filled: IntArray, information: FloatArray
) -> int:
    """Write the rows of Ψ' of box ``i`` up to its own block to ``information`` [3, 3m].

    The rows of Z from ``start`` on may count; returns from which on they do.
    """
    n, end = len(filled), padded(CUES * (i + 1))
    while start < n and filled[min(start + ROWS, n) - 1] <= CUES * i:
        start += ROWS
    for j in range(CUES):
        p, row = CUES * i + j, information[j]
        for c in range(end):
            row[c] = 0.0
        row[p] = white.diagonal[i, j]
        if i > 0:
            row[p - CUES] = white.beside[i, j]
        for other in range(BAND + start, BAND + n + PERSON, ROWS):
            take_rows(row, end, spread, other, column_of(spread, other, p))
    return start
