"""The rows of a dataset that are scored, and their dense numbering.

Scored poses are those of frames t ≥ 2 with a box; scored positions are those of boxes at t ≥ 2 that are not given.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.errors import FileError, VbbenchError
from vbbench.estimate import LARGEST, is_credible
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import TRUTH_TABLES
from vbbench.files.sequence_tables import OBSERVER, SequenceTable, ranges_within
from vbbench.files.tables import FRAME_TABLE
from vbbench.geometry import BoolArray, FloatArray, IntArray, relative_to_world
from vbbench.protocol import START_FRAMES, Protocol
from vbbench.sequence import NOBODY

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
    sequence, track : [R] pairs of a sequence and a track in it; repeats are allowed.
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
    """[span + 1] the index of each id from the least to one beyond the greatest, −1 for none; `None`: too sparse."""
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
    """Scored rows of the dataset, in chunks of whole sequences; or those of the sequence ``only``."""
    observations = SequenceTable(dataset.table_path("observations"), "observations")
    given = SequenceTable(dataset.table_path("given"), "given")
    budgets = [(FRAMES_AT_ONCE, dataset.rows["frames"]), (CELLS_AT_ONCE, dataset.cells)]
    whole = ranges_within(len(dataset), len(dataset), budgets)
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


def _select(columns: dict[str, NDArray[Any]], keep: BoolArray) -> dict[str, NDArray[Any]]:
    return {name: values[keep] for name, values in columns.items()}


class _Paths(NamedTuple):
    """Scenes first ≤ scene < last: the row of each cell of their grid, and the rows' positions [R, 2] in m."""

    scenes: tuple[int, int]
    grid: RowGrid
    row_of_cell: NDArray[np.int32]
    positions: FloatArray


class TruthRows:
    """The truth tables of a dataset, opened for scoring.

    Raises VbbenchError if the truth is withheld.
    """

    def __init__(self, dataset: Dataset) -> None:
        self.known = dataset.info.truth
        if self.known == "none":
            raise VbbenchError(f"{dataset.folder} cannot be scored: it has no true poses and positions")
        if not dataset.has_truth:
            place = dataset.table_path(TRUTH_TABLES[self.known][-1])
            raise VbbenchError(
                f"the truth of {dataset.folder} is not available ({place} is missing); "
                "name the folder that holds it with `truth`"
            )
        self._rows = dataset.rows
        tables = {name: dataset.table_path(name) for name in TRUTH_TABLES[self.known]}
        if "truth/poses" in tables:
            self._poses = SequenceTable(tables["truth/poses"], "truth/poses")
        if "truth/scenes" in tables:
            self._scenes = SequenceTable(tables["truth/scenes"], "truth/scenes", "scene")
            self._tracks = SequenceTable(tables["truth/tracks"], "truth/tracks")
        self._worlds = SequenceTable(tables[FRAME_TABLE], FRAME_TABLE) if self.known == "whole" else None
        self._last_paths: _Paths | None = None

    def persons(self, rows: ScoredRows) -> IntArray:
        """[Q] person of each scored position, `NOBODY` for a false alarm; the track where people are unknown."""
        if self.known == "poses":
            return rows.track
        grid = rows.grid
        links = self._tracks.read(grid.first, grid.first + len(grid.frames))
        begun = _moments(grid, links["sequence"], links["track"], links["frame"])
        order = np.argsort(begun, kind="stable")
        wanted = _moments(grid, rows.sequence, rows.track, rows.frame)
        link = np.searchsorted(begun[order], wanted, side="right") - 1
        found = order[link.clip(min=0)] if len(order) else np.zeros(len(wanted), np.int64)
        same = (link >= 0) & (links["sequence"][found] == rows.sequence) & (links["track"][found] == rows.track)
        return np.where(same, links["person"][found], NOBODY)

    def poses(self, rows: ScoredRows, answered: FloatArray) -> FloatArray:
        """[P, 3] true poses (x, y, yaw) in m and rad; the ``answered`` ones [P, 3] if no true poses are known."""
        if self.known == "relative":
            return answered
        grid = rows.grid
        truth = self._poses.read(grid.first, grid.first + len(grid.frames))
        row = rows_by_number(grid.slot(truth["sequence"], truth["frame"]), grid.slots)[rows.pose_slot]
        self._require(row, self._poses, "pose")
        return self._credible(np.stack([truth[name][row] for name in ("x", "y", "yaw")], axis=-1), self._poses)

    def positions(self, rows: ScoredRows, poses: FloatArray) -> FloatArray:
        """[Q, 2] true positions in m of the persons behind the scored positions, with `poses` [P, 3]; NaN if unknown.

        If only positions relative to the camera are known, they are transformed by ``poses``.
        """
        if self.known == "poses":
            return np.full((len(rows.sequence), 2), np.nan)
        positions = self._positions(rows, self.persons(rows))
        if self.known == "whole":
            return positions
        return relative_to_world(positions[:, None], poses[rows.pose_of_position])[:, 0]

    def _positions(self, rows: ScoredRows, persons: IntArray) -> FloatArray:
        scene, frame = self._rows["scene"][rows.sequence], self._rows["first_frame"][rows.sequence] + rows.frame
        first, last = (int(scene.min()), int(scene.max()) + 1) if len(scene) else (0, 0)
        paths = self._paths(first, last)
        row = paths.row_of_cell[paths.grid.cell(scene, frame, persons)]
        self._require(row, self._scenes, "person")
        return self._in_worlds(rows, self._credible(paths.positions.take(row, axis=0), self._scenes))

    def _in_worlds(self, rows: ScoredRows, positions: FloatArray) -> FloatArray:
        """Positions [Q, 2] transformed from the scene to the worlds of their sequences."""
        if self._worlds is None:
            return positions
        grid = rows.grid
        worlds = self._worlds.read(grid.first, grid.first + len(grid.frames))
        if not np.array_equal(worlds["sequence"], grid.first + np.arange(len(grid.frames))):
            raise FileError(self._worlds.path, "lacks the world of a sequence; generate the dataset again")
        frames = np.stack([worlds[name] for name in ("x", "y", "yaw")], axis=-1)
        x, y, yaw = self._credible(frames, self._worlds)[rows.sequence - grid.first].T
        sin, cos = np.sin(yaw), np.cos(yaw)
        return np.stack(
            [cos * positions[:, 0] - sin * positions[:, 1] + x, sin * positions[:, 0] + cos * positions[:, 1] + y],
            axis=-1,
        )

    def _paths(self, first: int, last: int) -> _Paths:
        """The paths of all people in the scenes first ≤ scene < last; those of the last call are kept."""
        if self._last_paths is None or self._last_paths.scenes != (first, last):
            truth = self._scenes.read(first, last)
            length = np.full(last - first, truth["frame"].max(initial=-1) + 1)
            grid = RowGrid(first, length, truth["scene"], truth["person"])
            row_of_cell = rows_by_number(grid.cell(truth["scene"], truth["frame"], truth["person"]), grid.cells)
            positions = np.stack([truth["x"], truth["y"]], axis=-1)
            self._last_paths = _Paths((first, last), grid, row_of_cell, positions)
        return self._last_paths

    @staticmethod
    def _credible(values: FloatArray, table: SequenceTable) -> FloatArray:
        """The values, checked to be finite and credible: a NaN error would silently drop out of a mean."""
        if not is_credible(values).all():
            raise FileError(
                table.path, f"holds true values beyond ±{LARGEST:.0f} m or rad, or NaN; generate the dataset again"
            )
        return values

    @staticmethod
    def _require(row: NDArray[Any], table: SequenceTable, what: str) -> None:
        if np.any(row < 0):
            raise FileError(
                table.path, f"lacks the true {what} of {np.sum(row < 0)} observed rows; generate the dataset again"
            )


def _moments(grid: RowGrid, sequence: IntArray, track: IntArray, frame: IntArray) -> IntArray:
    """A number for each row [R], unique for every frame of every track of every sequence, and ascending in time."""
    return grid.group(sequence, track) * (int(grid.frames.max(initial=0)) + 1) + frame
