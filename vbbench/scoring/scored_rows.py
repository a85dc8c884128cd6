"""Which rows of a dataset a submission is scored on.

Poses: frames t ≥ 2 in which anything is observed. Positions: whatever is observed at t ≥ 2 and was not given.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.files.dataset import OBSERVER, Dataset
from vbbench.files.sequence_tables import SequenceTable
from vbbench.geometry import BoolArray, IntArray
from vbbench.protocol import START_FRAMES, Protocol
from vbbench.scoring.row_grid import RowGrid, rows_by_number

FRAMES_AT_ONCE = 4096
"""Frames of the sequences that are held in memory together."""

CELLS_AT_ONCE = 1 << 19
"""Pairs of a frame and a track of those sequences, unless one alone has more: some 100 MB of working memory."""


@dataclass(frozen=True, kw_only=True)
class ScoredRows:
    """The scored rows of consecutive sequences, in order of sequence and frame.

    Parameters
    ----------
    grid : numbers of frames and tracks.
    pose_sequence, pose_frame : [P] the scored poses.
    sequence, frame, track, cell : [Q] the scored positions, and their cells in the grid.
    given : columns of the rows of ``given.parquet`` that the protocol hands over.
    """

    grid: RowGrid
    pose_sequence: IntArray
    pose_frame: IntArray
    sequence: IntArray
    frame: IntArray
    track: IntArray
    cell: IntArray
    given: dict[str, NDArray[Any]]

    def where(self, keep: BoolArray) -> "ScoredRows":
        """The same with only those positions that are marked in ``keep`` [Q]."""
        if keep.all():
            return self
        return replace(
            self, sequence=self.sequence[keep], frame=self.frame[keep], track=self.track[keep], cell=self.cell[keep]
        )

    @cached_property
    def pose_slot(self) -> IntArray:
        """[P] slot of each scored pose, ascending."""
        return self.grid.slot(self.pose_sequence, self.pose_frame)

    @cached_property
    def pose_of_position(self) -> IntArray:
        """[Q] index among the scored poses of the pose in each position's frame."""
        pose = rows_by_number(self.pose_slot, self.grid.slots)[self.grid.slot(self.sequence, self.frame)]
        return pose.astype(np.int64)


def scored_rows(dataset: Dataset, protocol: Protocol) -> Iterator[ScoredRows]:
    """Scored rows of the whole dataset, a number of whole sequences at a time."""
    observations = SequenceTable(dataset.table_path("observations"), "observations")
    given = SequenceTable(dataset.table_path("given"), "given")
    for first, last in _chunks(dataset.rows["frames"], dataset.rows["people"]):
        seen = observations.read(first, last, ["sequence", "frame", "track"])
        known = given.read(first, last)
        known = _select(known, protocol.is_given_row(known["frame"]))
        yield _scored(RowGrid(first, dataset.rows["frames"][first:last], seen["sequence"], seen["track"]), seen, known)


def _scored(grid: RowGrid, seen: dict[str, NDArray[Any]], given: dict[str, NDArray[Any]]) -> ScoredRows:
    sequence, frame, track = (seen[name] for name in ("sequence", "frame", "track"))
    is_given = np.zeros(grid.cells, dtype=bool)
    people = _select(given, given["track"] != OBSERVER)
    given_cell = grid.cell(people["sequence"], people["frame"], people["track"])
    is_given[given_cell[given_cell >= 0]] = True
    cell = grid.cell(sequence, frame, track)
    keep = (frame >= START_FRAMES) & ~is_given[cell]
    pose_sequence, pose_frame = _poses(grid, sequence, frame)
    return ScoredRows(
        grid=grid,
        pose_sequence=pose_sequence,
        pose_frame=pose_frame,
        sequence=sequence[keep],
        frame=frame[keep],
        track=track[keep],
        cell=cell[keep],
        given=given,
    )


def _poses(grid: RowGrid, sequence: IntArray, frame: IntArray) -> tuple[IntArray, IntArray]:
    any_seen = np.zeros(grid.slots, dtype=bool)
    any_seen[grid.slot(sequence, frame)] = True
    local = np.repeat(np.arange(len(grid.frames)), grid.frames)
    frame_of_slot = np.arange(grid.slots) - grid.slot(local + grid.first, np.zeros_like(local))
    scored = any_seen & (frame_of_slot >= START_FRAMES)
    return local[scored] + grid.first, frame_of_slot[scored]


def _chunks(frames: NDArray[Any], people: NDArray[Any]) -> Iterator[tuple[int, int]]:
    """Ranges of sequences, as many as neither of the two budgets forbids."""
    cells = frames.astype(np.int64) * people
    budgets = (FRAMES_AT_ONCE, np.cumsum(frames, dtype=np.int64)), (CELLS_AT_ONCE, np.cumsum(cells))
    first = 0
    while first < len(frames):
        before = [ends[first - 1] if first else 0 for _, ends in budgets]
        fitting = [
            np.searchsorted(ends, done + most, "right") for done, (most, ends) in zip(before, budgets, strict=True)
        ]
        last = max(first + 1, int(min(fitting)))
        yield first, last
        first = last


def _select(columns: dict[str, NDArray[Any]], keep: BoolArray) -> dict[str, NDArray[Any]]:
    return {name: values[keep] for name, values in columns.items()}
