"""Numbers of frames and tracks: the same for ids that are indexed by and ids that are searched for."""

import numpy as np
import pytest

from vbbench.scoring.scored_rows import RowGrid

SEQUENCE, TRACK = np.array([3, 3, 4, 5, 5, 5]), np.array([0, 2, 1, 0, 1, 2])


@pytest.mark.parametrize(
    "ids",
    [np.array([0, 1, 2]), np.array([-7, 40, 41]), np.array([-(2**31), 0, 2**31 - 1])],
    ids=["dense", "gaps", "far"],
)
def test_every_cell_has_its_number_and_nothing_else_has(ids: np.ndarray) -> None:
    ids = ids.astype(np.int32)
    grid = RowGrid(3, [2, 1, 2], SEQUENCE, ids[TRACK])
    frames = np.array([2, 2, 1, 2, 2, 2])
    rows = [(s, f, t) for s, n, t in zip(SEQUENCE, frames, ids[TRACK], strict=True) for f in range(n)]
    sequence, frame, track = (np.array(values) for values in zip(*rows, strict=True))
    assert sorted(grid.cell(sequence, frame, track)) == list(range(grid.cells))
    np.testing.assert_array_equal(grid.column(SEQUENCE, ids[TRACK]), [0, 1, 0, 0, 1, 2])
    absent = np.array([ids[1], 1_000_000, -1_000_000], np.int32)
    np.testing.assert_array_equal(grid.column(np.array([3, 3, 3]), absent), [-1, -1, -1])
    np.testing.assert_array_equal(grid.cell(np.array([3, 3]), np.array([-1, 2]), ids[[0, 0]]), [-1, -1])


def test_nobody_at_all() -> None:
    nothing = np.zeros(0, np.int32)
    grid = RowGrid(0, [4], nothing, nothing)
    np.testing.assert_array_equal(grid.column(np.array([0]), np.array([5])), [-1])
    assert grid.cells == 0
