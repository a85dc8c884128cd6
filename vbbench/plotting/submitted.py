"""The estimate that a submission holds for one sequence, and the picture of it."""

from pathlib import Path

import numpy as np

from vbbench.dataset import Dataset
from vbbench.errors import SubmissionError, VbbenchError
from vbbench.faults import Faults
from vbbench.plotting.figure import plot_sequence, save_png
from vbbench.sequence import Sequence
from vbbench.solver import Estimate
from vbbench.submission import SubmissionInfo
from vbbench.submission_table import Arrays, open_table


def plot_to_file(
    dataset: Dataset, index: int, out: Path | str, *, submission: Path | str | None = None, frame: int | None = None
) -> Path:
    """Draw a sequence, and a submission's answer to it, into a PNG file; see `plot_sequence`.

    Raises
    ------
    VbbenchError
        If the submission cannot be read or answers another dataset.
    """
    if submission is None:
        figure = plot_sequence(dataset, index, frame=frame)
    else:
        estimate, solver = read_estimate(dataset, index, Path(submission))
        figure = plot_sequence(dataset, index, estimate, frame=frame, solver=solver)
    save_png(figure, out)
    return Path(out)


def read_estimate(dataset: Dataset, index: int, submission: Path) -> tuple[Estimate, str]:
    """What a submission says about one sequence, what was given filled in, NaN where it says nothing; and its solver."""
    info = SubmissionInfo.read(submission)
    if info.dataset != dataset.info.id:
        raise VbbenchError(f"{submission} answers dataset {info.dataset}, {dataset.folder} is {dataset.info.id}")
    sequence = dataset.sequence(index)
    poses, positions = sequence.given.poses.copy(), sequence.given.positions.copy()
    rows = _rows(submission, "poses", sequence)
    poses[rows["frame"]] = np.stack([rows["x"], rows["y"], rows["yaw"]], axis=-1)
    rows = _rows(submission, "positions", sequence)
    column = np.searchsorted(sequence.tracks, rows["track"])
    positions[rows["frame"], column] = np.stack([rows["x"], rows["y"]], axis=-1)
    return Estimate(poses=poses, positions=positions), f"{info.solver} ({info.protocol})"


def _rows(submission: Path, name: str, sequence: Sequence) -> Arrays:
    """Rows of one table that name a frame and a track of the sequence; a score lists the others as faults."""
    faults = Faults()
    table = open_table(submission, name, faults)
    if table is None or faults:
        raise SubmissionError(submission, faults.listing())
    rows = table.read(sequence.index, sequence.index + 1)
    usable = (rows["frame"] >= 0) & (rows["frame"] < sequence.frames)
    if "track" in rows:
        usable &= np.isin(rows["track"], sequence.tracks)
    return {column: values[usable] for column, values in rows.items()}
