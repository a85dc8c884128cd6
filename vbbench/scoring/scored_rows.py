"""Which rows of a dataset a submission is scored on, and dense numbers by which they are found.

Poses: frames t ≥ 2 in which anything is observed. Positions: whatever is observed at t ≥ 2 and was not given.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.files.dataset import Dataset
from vbbench.files.sequence_rows import OBSERVER
from vbbench.files.sequence_tables import SequenceTable
from vbbench.geometry import BoolArray, IntArray
from vbbench.protocol import START_FRAMES, Protocol

FRAMES_AT_ONCE = 4096
"""Frames of the sequences held in memory together."""

CELLS_AT_ONCE = 1 << 19
"""Pairs of a frame and a track of those sequences, unless one alone has more: some 100 MB of working memory."""

NUMBERS_PER_TRACK = 64
"""If track ids span more numbers than this per track, they are found by search instead of by indexing."""


class RowGrid:
    """Numbers every frame (its slot) and every track in every frame (its cell), so that rows are found by indexing.

    Parameters
    ----------
    first : number of the first sequence.
    frames : [N] frames of the sequences first, first + 1, …
    sequence, track : [R] which track is seen in which sequence; repeats are allowed.
    """

    def __init__(self, first: int, frames: ArrayLike, sequence: IntArray, track: IntArray) -> None:
        self.first = first
        self.frames = np.asarray(frames, dtype=np.int64)
        self._tracks = np.unique(track)
        seen = np.zeros((len(self.frames), len(self._tracks)), dtype=bool)
        seen[sequence - first, np.searchsorted(self._tracks, track)] = True
        column = np.where(seen, np.cumsum(seen, axis=1) - 1, -1)
        self._column = np.pad(column, ((0, 0), (0, 1)), constant_values=-1)  # the last: for unknown tracks
        self._place_of_id = _places_by_id(self._tracks)
        self._width = seen.sum(axis=1)
        self._first_slot = _starts(self.frames)
        self._first_cell = _starts(self.frames * self._width)
        self._first_group = _starts(self._width)

    @property
    def slots(self) -> int:
        """Number of frames."""
        return int(self.frames.sum())

    @property
    def cells(self) -> int:
        """Number of pairs of a frame and a track of its sequence."""
        return int((self.frames * self._width).sum())

    def slot(self, sequence: IntArray, frame: IntArray) -> IntArray:
        """Slot of each row [R]; −1 where the sequence has no such frame."""
        local = sequence - self.first
        exists = (frame >= 0) & (frame < self.frames[local])
        return np.where(exists, self._first_slot[local] + frame, -1)

    def column(self, sequence: IntArray, track: IntArray) -> IntArray:
        """Column of each row's track [R] within its sequence; −1 where the sequence never sees that track."""
        return self._column[sequence - self.first, self._place(track)]

    def _place(self, track: IntArray) -> IntArray:
        """Index of each id [R] among all tracks; −1 for one that no sequence sees."""
        if not len(self._tracks):
            return np.full(len(track), -1)
        if self._place_of_id is not None:
            offset = np.subtract(track, self._tracks[0], dtype=np.int64)
            beyond = len(self._place_of_id) - 1
            return self._place_of_id[np.where((offset < 0) | (offset > beyond), beyond, offset)]
        place = np.searchsorted(self._tracks, track).clip(max=len(self._tracks) - 1)
        return np.where(self._tracks[place] == track, place, -1)

    def cell(self, sequence: IntArray, frame: IntArray, track: IntArray) -> IntArray:
        """Cell of each row [R]; −1 where the sequence has no such frame or never sees that track."""
        local, column = sequence - self.first, self.column(sequence, track)
        there = (column >= 0) & (frame >= 0) & (frame < self.frames[local])
        return np.where(there, self._first_cell[local] + frame * self._width[local] + column, -1)

    def group(self, sequence: IntArray, track: IntArray) -> IntArray:
        """One number for each track of each sequence [R]; every track must exist."""
        return self._first_group[sequence - self.first] + self.column(sequence, track)


def rows_by_number(number: IntArray, size: int) -> NDArray[np.int32]:
    """[size + 1] the (last) row with each slot or cell number; −1 for none, and at number −1."""
    row = np.full(size + 1, -1, dtype=np.int32)
    row[number] = np.arange(len(number), dtype=np.int32)
    row[-1] = -1
    return row


def _places_by_id(tracks: IntArray) -> IntArray | None:
    """[span + 1] the place of each id from the least to one beyond the greatest, −1 for none; `None`: too sparse."""
    if not len(tracks):
        return None
    span = int(tracks[-1]) - int(tracks[0]) + 1
    if span > NUMBERS_PER_TRACK * (len(tracks) + NUMBERS_PER_TRACK):
        return None
    places = np.full(span + 1, -1)
    places[tracks - tracks[0]] = np.arange(len(tracks))
    return places


def _starts(counts: IntArray) -> IntArray:
    return np.cumsum(counts) - counts


@dataclass(frozen=True, kw_only=True)
class ScoredRows:
    """The scored rows of consecutive sequences, in order of sequence and frame.

    Parameters
    ----------
    grid : numbers of frames and tracks.
    pose_sequence, pose_frame : [P] the scored poses.
    sequence, frame, track, cell : [Q] the scored positions, and their cells in the grid.
    given : columns of the rows of ``given.parquet`` that the protocol gives to solvers.
    """

    grid: RowGrid
    pose_sequence: IntArray
    pose_frame: IntArray
    sequence: IntArray
    frame: IntArray
    track: IntArray
    cell: IntArray
    given: dict[str, NDArray[Any]]

    def where(self, keep: BoolArray, poses: BoolArray | None = None) -> "ScoredRows":
        """The same with only the positions marked in ``keep`` [Q], and only the ``poses`` marked [P] unless `None`."""
        kept = {name: getattr(self, name)[keep] for name in ("sequence", "frame", "track", "cell")}
        if poses is not None:
            kept |= {name: getattr(self, name)[poses] for name in ("pose_sequence", "pose_frame")}
        return replace(self, **kept)

    @cached_property
    def pose_slot(self) -> IntArray:
        """[P] slot of each scored pose, ascending."""
        return self.grid.slot(self.pose_sequence, self.pose_frame)

    @cached_property
    def pose_of_position(self) -> IntArray:
        """[Q] index among the scored poses of the pose in each position's frame."""
        pose = rows_by_number(self.pose_slot, self.grid.slots)[self.grid.slot(self.sequence, self.frame)]
        return pose.astype(np.int64)


def scored_rows(dataset: Dataset, protocol: Protocol, only: int | None = None) -> Iterator[ScoredRows]:
    """Scored rows of the whole dataset, a number of whole sequences at a time; or those of ``only`` one sequence."""
    observations = SequenceTable(dataset.table_path("observations"), "observations")
    given = SequenceTable(dataset.table_path("given"), "given")
    whole = _chunks(dataset.rows["frames"], dataset.rows["people"])
    for first, last in whole if only is None else [(only, only + 1)]:
        seen = observations.read(first, last, ["sequence", "frame", "track"])
        known = given.read(first, last)
        known = _select(known, protocol.is_given_row(known["frame"], known["track"] == OBSERVER))
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
    """Ranges of sequences, each as long as both budgets allow."""
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
