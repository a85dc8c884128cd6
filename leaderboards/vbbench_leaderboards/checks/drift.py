"""Where a committed result or record differs from what is scored or counted now."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench_leaderboards.checks.bundled import SINGLE_PRECISION
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.result import Result

TOLERANCE, SINGLE_TOLERANCE = 1e-6, 1e-4
"""How far a figure may lie from the other, in m or rad, or in parts of it where it is larger than one; and those of
solvers that count with 24 bits, whose last digits depend on the processor."""

_NOT_COMPARED = ("solver_version", "seconds_per_frame")


def drift(old: Result, new: Result) -> list[str]:
    """Where two results of a solver on a board differ by more than the tolerance, one per line.

    Versions, times and descriptions are not compared.
    """
    return _differences(_comparable(old), _comparable(new), "", tolerance_of(new.solver))


def tolerance_of(solver: str) -> float:
    """How far figures of a solver may lie from those that were committed."""
    return SINGLE_TOLERANCE if solver in SINGLE_PRECISION else TOLERANCE


def record_faults(record: BoardDataset, folder: Path) -> Iterator[str]:
    """Where a dataset differs from its record.

    The bytes of tables depend on the library that wrote them; they must agree only if truth is withheld. The seed may
    then have been published since.
    """
    opened = Dataset(folder)
    if not opened.has_truth:
        return
    fresh, loose = BoardDataset.of(opened), ("tables",) if record.seed is not None else ("seed", "command")
    for name, value in vars(fresh).items():
        if name == "scored":
            yield from _scored_faults(record, fresh, folder)
        elif value != vars(record)[name] and name not in loose:
            yield f"$.{name}: is {vars(record)[name]!r}, {folder} gives {value!r}"


def _scored_faults(record: BoardDataset, fresh: BoardDataset, folder: Path) -> Iterator[str]:
    for protocol, recorded in record.scored.items():
        for column, numbers in vars(fresh.scored[protocol]).items():
            if not np.array_equal(getattr(recorded, column), numbers):
                yield f"$.scored.{protocol}: {column} are not those that {folder} gives"


def _comparable(result: Result) -> dict[str, Any]:
    own = result.per_sequence
    columns = {name: values for name, values in vars(own).items() if name != "figures"} | own.figures
    score = {name: value for name, value in result.score.items() if name not in _NOT_COMPARED}
    return {"score": score, "per_sequence": {name: _plain(values) for name, values in columns.items()}}


def _plain(values: Any) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]


def _differences(old: Any, new: Any, name: str, tolerance: float) -> list[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        keys = dict.fromkeys([*old, *new])
        below = {key: f"{name}.{key}".lstrip(".") for key in keys}
        return [line for key in keys for line in _differences(old.get(key), new.get(key), below[key], tolerance)]
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return _differences_of_rows(old, new, name, tolerance)
    return [] if _same(old, new, tolerance) else [f"{name}: was {_short(old)}, is {_short(new)}"]


def _differences_of_rows(old: list[Any], new: list[Any], name: str, tolerance: float) -> list[str]:
    rows = [row for row, pair in enumerate(zip(old, new, strict=True)) if not _same(*pair, tolerance)]
    if not rows:
        return []
    worst = max(rows, key=lambda row: abs((old[row] or 0.0) - (new[row] or 0.0)))
    return [f"{name}: {len(rows)} of {len(old)} differ, most row {worst}: was {old[worst]}, is {new[worst]}"]


def _same(old: Any, new: Any, tolerance: float) -> bool:
    if isinstance(old, float) and isinstance(new, (int, float)):
        return abs(old - new) <= tolerance * max(1.0, abs(old))
    return bool(old == new)


def _short(value: Any) -> str:
    return f"{len(value)} values" if isinstance(value, (dict, list)) else repr(value)
