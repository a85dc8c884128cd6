"""Truth of scored rows, looked up for many sequences at once."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, VbbenchError
from vbbench.estimate import LARGEST, is_credible
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import TRUTH_TABLES
from vbbench.files.sequence_tables import SequenceTable
from vbbench.files.tables import FRAME_TABLE
from vbbench.geometry import FloatArray, IntArray, relative_to_world
from vbbench.scoring.scored_rows import RowGrid, ScoredRows, rows_by_number
from vbbench.sequence import NOBODY


class _Paths(NamedTuple):
    """Scenes first ≤ scene < last: the row of each cell of their grid, and the rows' positions [R, 2] in m."""

    scenes: tuple[int, int]
    grid: RowGrid
    row_of_cell: NDArray[np.int32]
    positions: FloatArray


class TruthRows:
    """The truth tables of a dataset, opened for scoring.

    Raises
    ------
    VbbenchError
        If the truth is withheld.
    """

    def __init__(self, dataset: Dataset) -> None:
        self.known = dataset.info.truth
        if self.known == "none":
            raise VbbenchError(f"{dataset.folder} cannot be scored: where people and camera were was never measured")
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
        """[Q] the person behind each scored position, `NOBODY` for a false alarm; the track where nobody is known."""
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
        """[P, 3] true poses (x, y, yaw) in m and rad; those that were ``answered`` [P, 3] where none are known."""
        if self.known == "relative":
            return answered
        grid = rows.grid
        truth = self._poses.read(grid.first, grid.first + len(grid.frames))
        row = rows_by_number(grid.slot(truth["sequence"], truth["frame"]), grid.slots)[rows.pose_slot]
        self._require(row, self._poses, "pose")
        return self._credible(np.stack([truth[name][row] for name in ("x", "y", "yaw")], axis=-1), self._poses)

    def positions(self, rows: ScoredRows, poses: FloatArray) -> FloatArray:
        """[Q, 2] true positions in m of the persons behind the scored positions, with `poses` [P, 3]; NaN if unknown.

        Where only positions relative to the camera are known, they are seen from there.
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
        """Positions [Q, 2] of the scene in the worlds of their sequences."""
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
        """The values, checked to be finite and of an answer's size: a NaN error would silently drop out of a mean."""
        if not is_credible(values).all():
            raise FileError(
                table.path, f"holds truth beyond ±{LARGEST:.0f} m or rad, or none; generate the dataset again"
            )
        return values

    @staticmethod
    def _require(row: NDArray[Any], table: SequenceTable, what: str) -> None:
        if np.any(row < 0):
            raise FileError(
                table.path, f"lacks the true {what} of {np.sum(row < 0)} observed rows; generate the dataset again"
            )


def _moments(grid: RowGrid, sequence: IntArray, track: IntArray, frame: IntArray) -> IntArray:
    """A number for each row [R] that grows with its frame, apart for every track of every sequence."""
    return grid.group(sequence, track) * (int(grid.frames.max(initial=0)) + 1) + frame
