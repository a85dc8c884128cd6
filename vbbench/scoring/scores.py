"""Scores a submission: truth of the scored rows, their errors, each sequence's figures, and the split's."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, VbbenchError
from vbbench.estimate import LARGEST, is_credible
from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import SequenceTable
from vbbench.geometry import FloatArray, IntArray
from vbbench.scoring.answers import Answers, CheckedSubmission, check_submission
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import PerSequence, Score, join_figures
from vbbench.scoring.scored_rows import RowGrid, ScoredRows, rows_by_number
from vbbench.scoring.statistics import mean_of_groups, summarise

NOBODY = -1
"""The person behind a false alarm."""


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
        if not dataset.has_truth:
            place = dataset.table_path("truth/poses")
            raise VbbenchError(
                f"the truth of {dataset.folder} is not available ({place} is missing); "
                "name the folder that holds it (truth)"
            )
        self._rows = dataset.rows
        self._poses = SequenceTable(dataset.table_path("truth/poses"), "truth/poses")
        self._scenes = SequenceTable(dataset.table_path("truth/scenes"), "truth/scenes", "scene")
        tracks = dataset.table_path("truth/tracks")
        self._tracks = SequenceTable(tracks, "truth/tracks") if tracks.is_file() else None
        self._last_paths: _Paths | None = None

    def persons(self, rows: ScoredRows) -> IntArray:
        """[Q] the person behind each scored position, `NOBODY` for a false alarm."""
        if self._tracks is None:
            return rows.track
        grid = rows.grid
        links = self._tracks.read(grid.first, grid.first + len(grid.frames))
        link = rows_by_number(grid.cell(links["sequence"], links["frame"], links["track"]), grid.cells)[rows.cell]
        persons = np.append(links["person"], NOBODY)
        return persons[link]

    def poses(self, rows: ScoredRows) -> FloatArray:
        """[P, 3] true poses (x, y, yaw) in m and rad."""
        grid = rows.grid
        truth = self._poses.read(grid.first, grid.first + len(grid.frames))
        row = rows_by_number(grid.slot(truth["sequence"], truth["frame"]), grid.slots)[rows.pose_slot]
        self._require(row, self._poses, "pose")
        return self._credible(np.stack([truth[name][row] for name in ("x", "y", "yaw")], axis=-1), self._poses)

    def positions(self, rows: ScoredRows, persons: IntArray) -> FloatArray:
        """[Q, 2] true positions in m of the persons [Q] behind the scored positions."""
        scene, frame = self._rows["scene"][rows.sequence], self._rows["first_frame"][rows.sequence] + rows.frame
        first, last = (int(scene.min()), int(scene.max()) + 1) if len(scene) else (0, 0)
        paths = self._paths(first, last)
        row = paths.row_of_cell[paths.grid.cell(scene, frame, persons)]
        self._require(row, self._scenes, "person")
        return self._credible(paths.positions.take(row, axis=0), self._scenes)

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


def score(submission: Path | str, dataset: Path | str, truth: Path | str | None = None) -> Score:
    """Score a submission folder against its dataset.

    Parameters
    ----------
    submission, dataset : the folders.
    truth : folder of the truth tables, if they are not in the dataset's folder.

    Raises
    ------
    SubmissionError
        With every fault of the submission; without truth, with those that can be seen without it.
    VbbenchError
        If the truth is not available, or there is nothing to score.
    """
    opened = Dataset(dataset, truth)
    if not opened.has_truth:
        check_submission(submission, opened)
    true_rows = TruthRows(opened)
    checked = CheckedSubmission(Path(submission), opened, true_rows)
    parts = [_figures(rows, answers, true_rows, opened.info.dt) for rows, answers in checked.chunks()]
    per_sequence = PerSequence.join([part.sequences for part in parts])
    if not len(per_sequence.sequence):
        raise VbbenchError(f"{dataset}: no sequence has a frame to score; generate longer sequences")
    reported = [part.fallbacks for part in parts if part.fallbacks is not None]
    return Score(
        info=checked.info,
        dataset=opened.info,
        protocol=checked.protocol,
        total_sequences=len(opened),
        fallback_frames=sum(reported) if reported else None,
        per_sequence=per_sequence,
        summaries=summarise(per_sequence.figures, join_figures([part.frames for part in parts])),
    )


@dataclass(frozen=True)
class _Part:
    """Figures of some sequences, and by metric of their scored frames [P]; how many of these fell back."""

    sequences: PerSequence
    frames: dict[str, FloatArray]
    fallbacks: int | None


def _figures(rows: ScoredRows, answers: Answers, truth: TruthRows, dt: float) -> _Part:
    true_poses, true_positions = truth.poses(rows), truth.positions(rows, truth.persons(rows))
    owner, count, size = rows.pose_of_position, len(rows.pose_sequence), len(rows.grid.frames)
    begin, end, seconds = _a_second_apart(rows, dt)
    poses, sequence = answers.poses, rows.pose_sequence - rows.grid.first
    # What a metric's function is called with, and to which scored pose each of its errors belongs.
    called: dict[str, tuple[tuple[FloatArray | float, ...], IntArray]] = {
        "frames": ((poses, true_poses), np.arange(count)),
        "people": ((answers.positions, poses[owner], true_positions, true_poses[owner]), owner),
        "seconds": ((poses[begin], poses[end], true_poses[begin], true_poses[end], seconds), begin),
    }
    frames, figures = {}, {}
    for name, metric in METRICS.items():
        arguments, pose = called[metric.over]
        errors = metric.errors(*arguments)
        frames[name] = mean_of_groups(pose, errors, count)
        figures[name] = mean_of_groups(sequence[pose], errors, size)
    fallbacks = None if answers.fallback is None else int(answers.fallback.sum())
    return _Part(_per_sequence(rows, answers, figures), frames, fallbacks)


def _per_sequence(rows: ScoredRows, answers: Answers, figures: dict[str, FloatArray]) -> PerSequence:
    size = len(rows.grid.frames)
    pose_owner, owner = rows.pose_sequence - rows.grid.first, rows.sequence - rows.grid.first
    every = PerSequence(
        sequence=np.arange(size) + rows.grid.first,
        frames=np.bincount(pose_owner, minlength=size),
        positions=np.bincount(owner, minlength=size),
        posed=np.bincount(pose_owner[answers.posed], minlength=size),
        placed=np.bincount(owner[answers.placed], minlength=size),
        figures=figures,
    )
    return every.select(every.frames > 0)


def _a_second_apart(rows: ScoredRows, dt: float) -> tuple[IntArray, IntArray, float]:
    """Scored poses [M] that are followed by a scored one a second later, that one [M], and the exact time between."""
    step = max(1, round(1.0 / dt))
    slot = rows.pose_slot
    end = np.searchsorted(slot, slot + step).clip(max=max(len(slot) - 1, 0))
    paired = (slot[end] == slot + step) & (rows.pose_sequence[end] == rows.pose_sequence)
    return np.flatnonzero(paired), end[paired], step * dt
