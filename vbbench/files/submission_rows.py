"""Estimates as rows of a submission's tables, and back: gaps may stay gaps."""

from collections.abc import Sequence as Several
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import SubmissionError, VbbenchError
from vbbench.estimate import Estimate, is_credible
from vbbench.files.dataset import Dataset
from vbbench.files.submission import Faults, SubmissionInfo
from vbbench.files.submission_tables import Arrays, SubmissionTable, open_table
from vbbench.files.tables import CONVERGED, COVARIANCES, FALLBACK, Columns
from vbbench.geometry import FloatArray
from vbbench.protocol import Protocol, get_protocol, scored_frames, scored_positions
from vbbench.sequence import Sequence


def answer_rows(sequence: Sequence, protocol: Protocol, estimate: Estimate, covariance: bool) -> dict[str, Columns]:
    """The columns of ``poses`` and ``positions``, and of ``heights`` if reported; with ``covariance`` covariances, too.

    Raises
    ------
    VbbenchError
        If covariances are wanted and not reported.
    """
    if covariance and estimate.pose_covariances is None and estimate.position_covariances is None:
        raise VbbenchError("the solver reports no covariances; leave `covariance` out")
    tables = {
        "poses": _pose_rows(sequence, estimate, covariance),
        "positions": _position_rows(sequence, protocol, estimate, covariance),
    }
    return tables if estimate.heights is None else {**tables, "heights": _height_rows(sequence, estimate)}


def _pose_rows(sequence: Sequence, estimate: Estimate, covariance: bool) -> Columns:
    frame = np.flatnonzero(scored_frames(sequence.observed))
    x, y, yaw = estimate.poses[frame].T
    rows: dict[str, Any] = {"sequence": np.full(len(frame), sequence.index), "frame": frame, "x": x, "y": y, "yaw": yaw}
    if estimate.fallback is not None:
        rows[FALLBACK] = estimate.fallback[frame]
    if estimate.converged is not None:
        rows[CONVERGED] = estimate.converged[frame]
    if covariance and estimate.pose_covariances is not None:
        rows |= _upper_triangle("poses", estimate.pose_covariances[frame])
    return rows


def _position_rows(sequence: Sequence, protocol: Protocol, estimate: Estimate, covariance: bool) -> Columns:
    given = protocol.select_given(sequence.given)
    frame, column = np.nonzero(scored_positions(sequence.observed, given))
    x, y = estimate.positions[frame, column].T
    where = {"sequence": np.full(len(frame), sequence.index), "frame": frame, "track": sequence.tracks[column]}
    rows: dict[str, Any] = {**where, "x": x, "y": y}
    if covariance and estimate.position_covariances is not None:
        rows |= _upper_triangle("positions", estimate.position_covariances[frame, column])
    return rows


def _height_rows(sequence: Sequence, estimate: Estimate) -> Columns:
    unknown = np.full(len(sequence.tracks), np.nan)
    return {
        "sequence": np.full(len(sequence.tracks), sequence.index),
        "track": sequence.tracks,
        "height": unknown if estimate.heights is None else estimate.heights,
        "variance": unknown if estimate.height_variances is None else estimate.height_variances,
    }


def _upper_triangle(table: str, covariances: FloatArray) -> dict[str, FloatArray]:
    """Covariances [N, D, D] as the columns of the table that hold them; NaN, not reported, where one is infinite."""
    finite = (np.abs(covariances) < np.finfo(np.float32).max).all(axis=(1, 2), keepdims=True)
    covariances = np.where(finite, covariances, np.nan)
    i, j = np.triu_indices(covariances.shape[-1])
    return dict(zip(COVARIANCES[table], covariances[:, i, j].T, strict=True))


def info_of_answer(dataset: Dataset, submission: Path | str) -> SubmissionInfo:
    """What a submission to ``dataset`` declares.

    Raises
    ------
    VbbenchError
        If it cannot be read, or answers another dataset.
    """
    info = SubmissionInfo.read(submission)
    if info.dataset != dataset.info.id:
        raise VbbenchError(f"{submission} answers dataset {info.dataset}, {dataset.folder} is {dataset.info.id}")
    return info


class SubmittedEstimates:
    """The folder of a submission to ``dataset``, read a sequence at a time; only scoring checks every row.

    Raises
    ------
    VbbenchError
        If it cannot be read, or answers another dataset.
    """

    def __init__(self, dataset: Dataset, submission: Path | str) -> None:
        self.info = info_of_answer(dataset, submission)
        self._protocol = get_protocol(self.info.protocol)
        faults = Faults()
        tables = {name: open_table(Path(submission), name, dataset, faults, COVARIANCES[name]) for name in COVARIANCES}
        self._tables = {name: table for name, table in tables.items() if table is not None}
        if faults:
            raise SubmissionError(submission, faults.listing())

    def of(self, sequence: Sequence) -> Estimate:
        """The estimate of one sequence: given values filled in, NaN without a row; with covariances if it has them."""
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
    """Rows of the sequence whose frame and track exist and whose values are credible."""
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


def unique_names(infos: Several[SubmissionInfo], submissions: Several[Path | str]) -> list[str]:
    """Names, no two alike: of solvers, with the protocol for one that comes twice, else with folder and number."""
    solvers = [info.solver for info in infos]
    protocols = [f"{info.solver} {info.protocol}" if solvers.count(info.solver) > 1 else info.solver for info in infos]
    folders = [
        f"{info.solver} ({Path(folder).resolve().name})" for info, folder in zip(infos, submissions, strict=True)
    ]
    for names in (solvers, protocols, folders):
        if len(set(names)) == len(names):
            return names
    return [f"{name} {number}" for number, name in enumerate(folders, 1)]
