"""A submission's answers to the scored rows: found, checked, and filled under the failure policy ``hold``.

All faults are reported together.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, SubmissionError
from vbbench.estimate import LARGEST, is_credible
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.sequence_tables import OBSERVER
from vbbench.files.submission import SUBMISSION_FILE, Faults, SubmissionInfo, read_info
from vbbench.files.submission_tables import SubmissionTable, open_table
from vbbench.files.tables import FALLBACK
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import PROTOCOLS, START_FRAMES, Protocol, get_protocol
from vbbench.scoring.metrics import other_readings
from vbbench.scoring.scored_rows import ScoredRows, TruthRows, rows_by_number, scored_rows
from vbbench.sequence import NOBODY

Arrays = dict[str, NDArray[Any]]

_BOTTOM, _TOP = -(2**31), 2**31
_NO_ROWS: Arrays = {
    **{name: np.empty(0, dtype=np.int32) for name in ("sequence", "frame", "track")},
    **{name: np.empty(0) for name in ("x", "y", "yaw")},
}
GIVEN_LASTS = 5
"""Frames after the first ones in which poses and positions are still about the last ones that were given."""
OR_HOLD = ", or declare the failure policy 'hold'"
"""Advice to whom rows are missing."""
_MISSING = f"the row is missing; add it{OR_HOLD}"


@dataclass(frozen=True, kw_only=True)
class Answers:
    """A submission's answers to scored rows.

    Parameters
    ----------
    poses : [P, 3] in m and rad, NaN where there is none.
    positions : [Q, 2] in m, NaN where there is none.
    posed, placed : [P], [Q] whether the submission holds the row.
    fallback : [P] whether the solver fell back on the observer's prior; ``None`` = not reported.
    """

    poses: FloatArray
    positions: FloatArray
    posed: BoolArray
    placed: BoolArray
    fallback: BoolArray | None

    def where(self, positions: BoolArray, poses: BoolArray) -> "Answers":
        """The answers to the positions [Q] and poses [P] that are marked."""
        return Answers(
            poses=self.poses[poses],
            positions=self.positions[positions],
            posed=self.posed[poses],
            placed=self.placed[positions],
            fallback=None if self.fallback is None else self.fallback[poses],
        )


def _match_poses(rows: ScoredRows, file: str, columns: Arrays, faults: Faults) -> tuple[FloatArray, BoolArray]:
    slot = rows.grid.slot(columns["sequence"], columns["frame"])
    faults.add_rows(file, "its sequence has no such frame; remove the row", columns, slot < 0)
    names = ("x", "y", "yaw", *([FALLBACK] if FALLBACK in columns else []))
    return _gather(file, columns, names, (slot, rows.grid.slots, rows.pose_slot), faults)


def _match_positions(rows: ScoredRows, file: str, columns: Arrays, faults: Faults) -> tuple[FloatArray, BoolArray]:
    grid, ids = rows.grid, [columns[name] for name in ("sequence", "frame", "track")]
    cell = grid.cell(*ids)
    if np.any(cell < 0):
        no_frame = grid.slot(ids[0], ids[1]) < 0
        faults.add_rows(file, "its sequence has no such frame; remove the row", columns, no_frame)
        no_track = grid.column(ids[0], ids[2]) < 0
        faults.add_rows(file, "its sequence never sees such a track; remove the row", columns, no_track)
    return _gather(file, columns, ("x", "y"), (cell, grid.cells, rows.cell), faults)


def _gather(
    file: str, columns: Arrays, names: tuple[str, ...], numbers: tuple[IntArray, int, IntArray], faults: Faults
) -> tuple[FloatArray, BoolArray]:
    """Values [W, len(names)] of the rows whose numbers are wanted, and whether the file has each row [W]."""
    number, size, wanted = numbers
    row_of = rows_by_number(number, size)
    again = (number >= 0) & (row_of[number] != np.arange(len(number)))
    faults.add_rows(file, "is given again further on; keep one of the rows", columns, again)
    row = row_of[wanted]
    there = row >= 0
    values = np.full((len(wanted), len(names)), np.nan)
    for c, name in enumerate(names):
        values[there, c] = columns[name][row[there]]
    broken = ~is_credible(values).all(axis=1) & there
    if broken.any():
        problem = f"{', '.join(names)} must be finite numbers within ±{LARGEST:.0f} m or rad; fix the row"
        faults.add_rows(file, problem, {name: column[row] for name, column in columns.items()}, broken)
    return values, there


def fill_gaps(rows: ScoredRows, answers: Answers) -> Answers:
    """The answers with every gap filled.

    A missing pose or position is the last one known, given or estimated, of the observer or the track in the sequence;
    a track never known before is put where the observer is.
    """
    if answers.posed.all() and answers.placed.all():
        return answers
    poses = _fill_poses(rows, answers)
    return replace(answers, poses=poses, positions=_fill_positions(rows, answers, poses))


def _fill_poses(rows: ScoredRows, answers: Answers) -> FloatArray:
    own = rows.given["track"] == OBSERVER
    given = np.stack([rows.given[name][own] for name in ("x", "y", "yaw")], axis=-1)
    group = np.concatenate([rows.given["sequence"][own], rows.pose_sequence[answers.posed]])
    frame = np.concatenate([rows.given["frame"][own], rows.pose_frame[answers.posed]])
    known = np.concatenate([given, answers.poses[answers.posed]])
    gap = ~answers.posed
    poses = answers.poses.copy()
    poses[gap] = _last_known(group, frame, known, rows.pose_sequence[gap], rows.pose_frame[gap])
    return poses


def _fill_positions(rows: ScoredRows, answers: Answers, poses: FloatArray) -> FloatArray:
    grid, placed = rows.grid, answers.placed
    people = rows.given["track"] != OBSERVER
    given = {name: values[people] for name, values in rows.given.items()}
    own_group = grid.group(rows.sequence, rows.track)
    group = np.concatenate([grid.group(given["sequence"], given["track"]), own_group[placed]])
    frame = np.concatenate([given["frame"], rows.frame[placed]])
    known = np.concatenate([np.stack([given["x"], given["y"]], axis=-1), answers.positions[placed]])
    last = _last_known(group, frame, known, own_group[~placed], rows.frame[~placed])
    observer = poses[rows.pose_of_position[~placed], :2]
    positions = answers.positions.copy()
    positions[~placed] = np.where(np.isnan(last), observer, last)
    return positions


def _last_known(
    group: IntArray, frame: IntArray, values: FloatArray, wanted_group: IntArray, wanted_frame: IntArray
) -> FloatArray:
    """For each wanted group and frame [M] the value [M, C] of the group's latest earlier row; NaN if it has none."""
    stride = int(max(frame.max(initial=0), wanted_frame.max(initial=0))) + 1
    key = group.astype(np.int64) * stride + frame
    order = np.argsort(key)
    place = np.searchsorted(key[order], wanted_group.astype(np.int64) * stride + wanted_frame) - 1
    if not len(key):
        return np.full((len(place), values.shape[1]), np.nan)
    row = order[place]
    found = (place >= 0) & (group[row] == wanted_group)
    return np.where(found[:, None], values[row], np.nan)


class CheckedSubmission:
    """A submission folder opened against a dataset; faults are collected while its rows are read.

    Parameters
    ----------
    folder : the submission folder.
    dataset : the dataset it answers.
    truth : the truth, if available: it marks false alarms, which need no answer.
    """

    def __init__(self, folder: Path, dataset: Dataset, truth: TruthRows | None) -> None:
        self.folder, self.dataset, self.truth = folder, dataset, truth
        self.faults = Faults()
        self.info: SubmissionInfo = read_info(folder, self.faults)
        wanted = dataset.info.id
        if self.info.dataset and self.info.dataset != wanted:
            self.faults.add(
                f"{SUBMISSION_FILE}: made for dataset '{self.info.dataset}', this one is '{wanted}'; "
                "solve this dataset, or score against that one"
            )
        self._units_seen = False
        self._tables: dict[str, SubmissionTable | None] = {
            name: open_table(folder, name, dataset, self.faults) for name in ("poses", "positions")
        }

    @property
    def protocol(self) -> Protocol:
        """The declared protocol; if that does not exist, one with the rows that all protocols score."""
        return get_protocol(self.info.protocol if self.info.protocol in PROTOCOLS else "sequential")

    def chunks(self, only: int | None = None) -> Iterator[tuple[ScoredRows, Answers]]:
        """Scored rows and the answers to them, gaps filled where the submission's policy is to hold.

        With ``only`` a sequence, its rows alone are read and checked.

        Raises SubmissionError after the last row, if there was any fault.
        """
        for rows in scored_rows(self.dataset, self.protocol, only):
            scored = rows if self.truth is None else rows.where(self.truth.persons(rows) != NOBODY)
            answers = self._answers(scored)
            if only is None and not self._units_seen:
                self._check_units(scored, answers)
            if not self.faults:
                yield scored, fill_gaps(scored, answers)
        if only is None:
            self._check_sequences()
        if self.faults:
            raise SubmissionError(self.folder, self.faults.listing())

    def _answers(self, rows: ScoredRows) -> Answers:
        """Answers to the scored rows.

        Other rows of the dataset are ignored. Faults are ids that do not exist, rows given twice, values that cannot be
        an answer (`is_credible`) and, unless the submission's policy is to hold, missing rows.
        """
        first, last = rows.grid.first, rows.grid.first + len(rows.grid.frames)
        (poses_file, pose_rows), (positions_file, position_rows) = (
            self._read(name, first, last) for name in self._tables
        )
        poses, posed = _match_poses(rows, poses_file, pose_rows, self.faults)
        positions, placed = _match_positions(rows, positions_file, position_rows, self.faults)
        if self.info.failure_policy == "refuse":
            if self._tables["poses"]:
                ids = {"sequence": rows.pose_sequence, "frame": rows.pose_frame}
                self.faults.add_rows(poses_file, _MISSING, ids, ~posed)
            if self._tables["positions"]:
                ids = {"sequence": rows.sequence, "frame": rows.frame, "track": rows.track}
                self.faults.add_rows(positions_file, _MISSING, ids, ~placed)
        fallback = posed & (poses[:, 3] != 0.0) if FALLBACK in pose_rows else None
        return Answers(poses=poses[:, :3], positions=positions, posed=posed, placed=placed, fallback=fallback)

    def _check_units(self, rows: ScoredRows, answers: Answers) -> None:
        """Add a fault if answers are in other units than the format's, by the truth.

        Without truth, those of the first frames are compared with the last ones that are given.
        """
        self._units_seen = True
        if self.truth is None:
            last = START_FRAMES + GIVEN_LASTS
            poses, positions = rows.pose_frame < last, rows.frame < last
            none = replace(answers, posed=np.zeros_like(answers.posed), placed=np.zeros_like(answers.placed))
            held, early = fill_gaps(rows, none).where(positions, poses), answers.where(positions, poses)
            found = other_readings(early.poses, early.positions, (held.poses, held.positions), early=True)
        else:
            true_poses = self.truth.poses(rows, answers.poses)
            like = (true_poses, self.truth.positions(rows, true_poses))
            found = other_readings(answers.poses, answers.positions, like)
        for fault in found:
            self.faults.add(fault)

    def _read(self, name: str, first: int, last: int) -> tuple[str, Arrays]:
        table = self._tables[name]
        try:
            return (table.file, table.read(first, last)) if table else (name, _NO_ROWS)
        except FileError as error:
            self.faults.add_error(error)
            self._tables[name] = None
            return name, _NO_ROWS

    def _check_sequences(self) -> None:
        for name in self._tables:
            for first, last in ((_BOTTOM, 0), (len(self.dataset), _TOP)):
                file, columns = self._read(name, first, last)
                problem = f"the dataset has sequences 0 to {len(self.dataset) - 1}; remove the row"
                self.faults.add_rows(file, problem, columns, np.ones(len(columns["sequence"]), dtype=bool))


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A submission without a fault.

    Parameters
    ----------
    info, dataset, protocol : the submission's facts, the dataset it answers, and how it was solved.
    posed, placed : numbers of poses and positions that it has of the required ones.
    poses, positions : numbers of required ones; those of false alarms are among them, but are not scored.
    """

    info: SubmissionInfo
    dataset: DatasetInfo
    protocol: Protocol
    posed: int
    poses: int
    placed: int
    positions: int

    def table(self) -> str:
        """The result of the check as text."""
        info, data = self.info, self.dataset
        lines = [
            f"{f'{info.solver} {info.version}'.strip()} on {data.split} ({data.camera.kind}, {data.tier}, {data.id}), "
            f"{self.protocol.id}: no fault",
            f"{self.posed} of {self.poses} poses and {self.placed} of {self.positions} positions that must be answered"
            f"; missing rows: {info.failure_policy}",
        ]
        if self.posed < self.poses or self.placed < self.positions:
            lines.append("A missing row counts as the last one known of the same person in the same sequence.")
        return "\n".join(lines)


def check_submission(submission: Path | str, dataset: Dataset) -> Checked:
    """Check a submission without truth; rows of false alarms, which are never scored, are then required as well.

    Raises SubmissionError with every fault, if there is any.
    """
    checked = CheckedSubmission(Path(submission), dataset, None)
    parts = [
        [answers.posed.sum(), len(answers.posed), answers.placed.sum(), len(answers.placed)]
        for _, answers in checked.chunks()
    ]
    posed, poses, placed, positions = (int(sum(column)) for column in zip(*parts, strict=True))
    return Checked(
        info=checked.info,
        dataset=dataset.info,
        protocol=checked.protocol,
        posed=posed,
        poses=poses,
        placed=placed,
        positions=positions,
    )
