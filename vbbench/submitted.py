"""What a submission says about one sequence, as an estimate: for pictures and export, where gaps may stay gaps."""

from pathlib import Path
from typing import Any

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.dataset import Dataset
from vbbench.errors import SubmissionError, VbbenchError
from vbbench.estimate import is_credible
from vbbench.faults import Faults
from vbbench.protocol import get_protocol
from vbbench.schemas import COVARIANCES
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
        tables = {name: open_table(Path(submission), name, dataset, faults, COVARIANCES[name]) for name in COVARIANCES}
        self._tables = {name: table for name, table in tables.items() if table is not None}
        if faults:
            raise SubmissionError(submission, faults.listing())

    def of(self, sequence: Sequence) -> Estimate:
        """The estimate of one sequence: what was given filled in, NaN where the submission is silent.

        Covariances come with it where the submission holds them.
        """
        given = self._protocol.select_given(sequence.given)
        poses, positions = given.poses.copy(), given.positions.copy()
        pose_rows, rows = (_rows(self._tables[name], sequence) for name in ("poses", "positions"))
        poses[pose_rows["frame"]] = np.stack([pose_rows["x"], pose_rows["y"], pose_rows["yaw"]], axis=-1)
        where = rows["frame"], np.searchsorted(sequence.tracks, rows["track"])
        positions[where] = np.stack([rows["x"], rows["y"]], axis=-1)
        return Estimate(
            poses=poses,
            positions=positions,
            pose_covariances=_covariances("poses", pose_rows, (pose_rows["frame"],), poses.shape[:1]),
            position_covariances=_covariances("positions", rows, where, positions.shape[:2]),
        )


def _rows(table: SubmissionTable, sequence: Sequence) -> Arrays:
    """Rows of the sequence whose frame and track exist and whose place can be one."""
    rows = table.read(sequence.index, sequence.index + 1)
    usable = (rows["frame"] >= 0) & (rows["frame"] < sequence.frames)
    for name in ("x", "y", "yaw"):
        usable &= is_credible(rows.get(name, np.zeros(1)))
    if "track" in rows:
        usable &= np.isin(rows["track"], sequence.tracks)
    return {column: values[usable] for column, values in rows.items()}


def _covariances(table: str, rows: Arrays, where: tuple[Any, ...], shape: tuple[int, ...]) -> FloatArray | None:
    """Covariances [*shape, D, D] from the columns of their upper triangle, NaN without a row; ``None`` without them."""
    names = COVARIANCES[table]
    if not set(names) <= rows.keys():
        return None
    size = {3: 2, 6: 3}[len(names)]
    found = np.full((*shape, size, size), np.nan)
    for name, (i, j) in zip(names, zip(*np.triu_indices(size), strict=True), strict=True):
        found[(*where, i, j)] = found[(*where, j, i)] = rows[name]
    return found
