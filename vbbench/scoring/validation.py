"""Checks a submission against its dataset: every fault is reported, all at once."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, SubmissionError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SUBMISSION_FILE, Faults, SubmissionInfo, read_info
from vbbench.files.submission_tables import SubmissionTable, open_table
from vbbench.protocol import PROTOCOLS, Protocol, get_protocol
from vbbench.scoring.failure_policy import hold
from vbbench.scoring.matched_rows import Answers, match, require_poses, require_positions
from vbbench.scoring.scored_rows import ScoredRows, scored_rows
from vbbench.scoring.truth_rows import NOBODY, TruthRows

Arrays = dict[str, NDArray[Any]]

_BOTTOM, _TOP = -(2**31), 2**31
_NO_ROWS: Arrays = {
    **{name: np.empty(0, dtype=np.int32) for name in ("sequence", "frame", "track")},
    **{name: np.empty(0) for name in ("x", "y", "yaw")},
}


class CheckedSubmission:
    """A submission folder opened against a dataset; faults gather while its rows are read.

    Parameters
    ----------
    folder : the submission folder.
    dataset : the dataset it answers.
    truth : where it is at hand, tracks that belong to nobody need no answer.
    """

    def __init__(self, folder: Path, dataset: Dataset, truth: TruthRows | None) -> None:
        self.folder, self.dataset, self.truth = folder, dataset, truth
        self.faults = Faults()
        self.info: SubmissionInfo = read_info(folder, self.faults)
        self._check_dataset_id()
        self._tables: dict[str, SubmissionTable | None] = {
            name: open_table(folder, name, dataset, self.faults) for name in ("poses", "positions")
        }

    @property
    def protocol(self) -> Protocol:
        """The protocol named, or, where there is none of that name, the one that scores no row that others do not."""
        return get_protocol(self.info.protocol if self.info.protocol in PROTOCOLS else "sequential")

    def chunks(self) -> Iterator[tuple[ScoredRows, Answers]]:
        """Scored rows and the answers to them, gaps filled where the submission's policy is to hold.

        Raises
        ------
        SubmissionError
            After the last row, if there was any fault; the answers are of use only when there was none.
        """
        for rows in scored_rows(self.dataset, self.protocol):
            scored = rows if self.truth is None else rows.where(self.truth.persons(rows) != NOBODY)
            answers = self._answers(scored)
            if not self.faults:
                yield scored, hold(scored, answers)
        self._check_sequences()
        if self.faults:
            raise SubmissionError(self.folder, self.faults.listing())

    def _answers(self, rows: ScoredRows) -> Answers:
        first, last = rows.grid.first, rows.grid.first + len(rows.grid.frames)
        (poses_file, poses), (positions_file, positions) = (self._read(name, first, last) for name in self._tables)
        answers = match(rows, (poses_file, poses), (positions_file, positions), self.faults)
        if self.info.failure_policy == "refuse":
            if self._tables["poses"]:
                require_poses(rows, answers, poses_file, self.faults)
            if self._tables["positions"]:
                require_positions(rows, answers, positions_file, self.faults)
        return answers

    def _read(self, name: str, first: int, last: int) -> tuple[str, Arrays]:
        table = self._tables[name]
        try:
            return (table.file, table.read(first, last)) if table else (name, _NO_ROWS)
        except FileError as error:
            self.faults.add_error(error)
            self._tables[name] = None
            return name, _NO_ROWS

    def _check_dataset_id(self) -> None:
        wanted = self.dataset.info.id
        if self.info.dataset and self.info.dataset != wanted:
            self.faults.add(
                f"{SUBMISSION_FILE}: made for dataset '{self.info.dataset}', this one is '{wanted}'; "
                "solve this dataset, or score against that one"
            )

    def _check_sequences(self) -> None:
        for name in self._tables:
            for first, last in ((_BOTTOM, 0), (len(self.dataset), _TOP)):
                file, columns = self._read(name, first, last)
                problem = f"the dataset has sequences 0 to {len(self.dataset) - 1}; remove the row"
                self.faults.add_rows(file, problem, columns, np.ones(len(columns["sequence"]), dtype=bool))


def validate(submission: Path | str, dataset: Path | str, truth: Path | str | None = None) -> SubmissionInfo:
    """Check a submission; truth need not be at hand.

    Without truth the rows of false alarms, which are never scored, are asked for like all others.

    Raises
    ------
    SubmissionError
        With every fault, if there is any.
    """
    opened = Dataset(dataset, truth)
    checked = CheckedSubmission(Path(submission), opened, TruthRows(opened) if opened.has_truth else None)
    for _ in checked.chunks():
        pass
    return checked.info
