"""An estimate as rows of a submission's tables: what is scored, and what the solver reports about it."""

from typing import Any

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.errors import VbbenchError
from vbbench.estimate import Estimate
from vbbench.protocol import Protocol, scored_frames, scored_positions
from vbbench.schemas import CONVERGED, COVARIANCES, FALLBACK, Columns
from vbbench.sequence import Sequence


def answer_rows(sequence: Sequence, protocol: Protocol, estimate: Estimate, covariance: bool) -> dict[str, Columns]:
    """The columns of ``poses`` and ``positions``, and of ``heights`` where they are reported.

    Parameters
    ----------
    covariance : whether to write covariances, too.

    Raises
    ------
    VbbenchError
        If covariances are wanted and not reported.
    """
    if covariance and estimate.pose_covariances is None and estimate.position_covariances is None:
        raise VbbenchError("the solver reports no covariances; leave --covariance out")
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
    """Covariances [N, D, D] as the columns of the table that hold them."""
    i, j = np.triu_indices(covariances.shape[-1])
    return dict(zip(COVARIANCES[table], covariances[:, i, j].T, strict=True))
