"""Finds a submission's answer to every scored row, and whatever is wrong with its rows."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.estimate import LARGEST, is_credible
from vbbench.files.schemas import FALLBACK
from vbbench.files.submission import Faults
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scoring.row_grid import rows_by_number
from vbbench.scoring.scored_rows import ScoredRows

Arrays = dict[str, NDArray[Any]]
_MISSING = "the row is missing; add it, or declare the failure policy 'hold'"


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


def match(rows: ScoredRows, poses: tuple[str, Arrays], positions: tuple[str, Arrays], faults: Faults) -> Answers:
    """Answers to the scored rows, from the file name and columns of the two tables.

    Rows that exist in the dataset and are not scored are ignored; ids that do not exist, rows given twice and values
    that cannot be an answer (`vbbench.estimate.is_credible`) go to ``faults``. Missing rows do not (`require_poses`).
    """
    pose_values, posed = _match_poses(rows, *poses, faults)
    position_values, placed = _match_positions(rows, *positions, faults)
    fallback = posed & (pose_values[:, 3] != 0.0) if FALLBACK in poses[1] else None
    return Answers(poses=pose_values[:, :3], positions=position_values, posed=posed, placed=placed, fallback=fallback)


def require_poses(rows: ScoredRows, answers: Answers, file: str, faults: Faults) -> None:
    """Every scored pose without an answer goes to ``faults``."""
    faults.add_rows(file, _MISSING, {"sequence": rows.pose_sequence, "frame": rows.pose_frame}, ~answers.posed)


def require_positions(rows: ScoredRows, answers: Answers, file: str, faults: Faults) -> None:
    """Every scored position without an answer goes to ``faults``."""
    ids = {"sequence": rows.sequence, "frame": rows.frame, "track": rows.track}
    faults.add_rows(file, _MISSING, ids, ~answers.placed)


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
    """Values [W, len(names)] of the rows whose numbers are wanted, and whether they are there [W]."""
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
