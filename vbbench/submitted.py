"""What a submission says about one sequence, as an estimate: for pictures and export, where gaps may stay gaps."""

from pathlib import Path

import numpy as np

from vbbench.dataset import Dataset
from vbbench.errors import SubmissionError, VbbenchError
from vbbench.faults import Faults
from vbbench.protocol import get_protocol
from vbbench.sequence import Sequence
from vbbench.solver import Estimate
from vbbench.submission import SubmissionInfo
from vbbench.submission_table import Arrays, SubmissionTable, open_table


class SubmittedEstimates:
    """A submission, opened for reading a sequence at a time; a score, not this, lists all its faults.

    Parameters
    ----------
    dataset : the dataset that it answers.
    submission : its folder.

    Raises
    ------
    VbbenchError
        If it cannot be read, or answers another dataset.
    """

    def __init__(self, dataset: Dataset, submission: Path | str) -> None:
        self.info = SubmissionInfo.read(submission)
        if self.info.dataset != dataset.info.id:
            raise VbbenchError(
                f"{submission} answers dataset {self.info.dataset}, {dataset.folder} is {dataset.info.id}"
            )
        self._protocol = get_protocol(self.info.protocol)
        faults = Faults()
        tables = {name: open_table(Path(submission), name, faults) for name in ("poses", "positions")}
        self._tables = {name: table for name, table in tables.items() if table is not None}
        if faults:
            raise SubmissionError(submission, faults.listing())

    def of(self, sequence: Sequence) -> Estimate:
        """The estimate of one sequence: what was given filled in, NaN where the submission is silent."""
        given = self._protocol.select_given(sequence.given)
        poses, positions = given.poses.copy(), given.positions.copy()
        rows = _rows(self._tables["poses"], sequence)
        poses[rows["frame"]] = np.stack([rows["x"], rows["y"], rows["yaw"]], axis=-1)
        rows = _rows(self._tables["positions"], sequence)
        column = np.searchsorted(sequence.tracks, rows["track"])
        positions[rows["frame"], column] = np.stack([rows["x"], rows["y"]], axis=-1)
        return Estimate(poses=poses, positions=positions)


def _rows(table: SubmissionTable, sequence: Sequence) -> Arrays:
    """Rows of the sequence whose frame and track exist."""
    rows = table.read(sequence.index, sequence.index + 1)
    usable = (rows["frame"] >= 0) & (rows["frame"] < sequence.frames)
    if "track" in rows:
        usable &= np.isin(rows["track"], sequence.tracks)
    return {column: values[usable] for column, values in rows.items()}
