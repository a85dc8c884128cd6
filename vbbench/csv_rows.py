"""CSV tables written by hand: every cell that is no number is reported with its line."""

import csv
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
from numpy.typing import NDArray

from vbbench.faults import Faults

IDS = ("sequence", "frame", "track")
_LARGEST_ID = 2**31 - 1

Arrays = dict[str, NDArray[Any]]


def read_csv_rows(path: Path, wanted: list[str], faults: Faults, optional: Collection[str] = ()) -> Arrays | None:
    """Columns of a CSV file with a header, and the 1-based ``line`` of each row.

    Parameters
    ----------
    path : the file; commas, a header line, any order of columns, more columns than wanted are fine.
    wanted : names of the columns.
    faults : takes what is wrong.
    optional : names of columns to read where they are there.

    Returns
    -------
    The rows whose ids could be read (0.0 stands for a value that could not), or ``None`` without usable header.
    """
    try:
        header = _header(path)
    except (UnicodeDecodeError, csv.Error) as error:
        faults.add(f"{path.name}: is no UTF-8 text ({error}); save it as CSV with commas")
        return None
    missing = [name for name in wanted if name not in header]
    for name in missing:
        faults.add(f"{path.name}, line 1: column '{name}' is missing; the header must read {','.join(wanted)}")
    if missing:
        return None
    wanted = [*wanted, *(name for name in optional if name in header)]
    return _read_fast(path, header, wanted) or _read_carefully(path, header, wanted, faults)


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.reader(file)
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield reader.line_num, cells


def _header(path: Path) -> list[str]:
    return [cell.strip() for cell in next(_lines(path), (0, [""]))[1]]


def _read_fast(path: Path, header: list[str], wanted: list[str]) -> Arrays | None:
    """Read a file without any fault in its cells; ``None`` where it has one, or its rows are not its lines."""
    kinds = {name: pa.int64() if name in IDS else pa.float64() for name in wanted}
    try:
        table = pa_csv.read_csv(
            path,
            pa_csv.ReadOptions(column_names=header, skip_rows=1, use_threads=False),
            pa_csv.ParseOptions(ignore_empty_lines=False),
            pa_csv.ConvertOptions(column_types=kinds, include_columns=wanted, null_values=[]),
        )
    except (pa.ArrowException, KeyError):
        return None
    columns = {name: table.column(name).to_numpy() for name in wanted}
    if any(np.any(np.abs(columns[name]) > _LARGEST_ID) for name in wanted if name in IDS):
        return None
    return {**columns, "line": np.arange(2, table.num_rows + 2)}


def _read_carefully(path: Path, header: list[str], wanted: list[str], faults: Faults) -> Arrays:
    rows = []
    for line, cells in list(_lines(path))[1:]:
        if len(cells) != len(header):
            problem = f"{len(cells)} cells, the header has {len(header)}; write one for each column"
            faults.add(f"{path.name}, line {line}: {problem}", kind=f"{path.name}: {problem}")
            continue
        row = _row(dict(zip(header, cells, strict=True)), wanted, f"{path.name}, line {line}", faults)
        if all(row[name] is not None for name in wanted if name in IDS):
            rows.append([*(row[name] or 0 for name in wanted), line])
    columns = zip(*rows, strict=True) if rows else [()] * (len(wanted) + 1)
    kinds = [*(np.int64 if name in IDS else np.float64 for name in wanted), np.int64]
    return {
        name: np.array(values, dtype=kind) for name, values, kind in zip([*wanted, "line"], columns, kinds, strict=True)
    }


def _row(cells: dict[str, str], wanted: list[str], place: str, faults: Faults) -> dict[str, float | None]:
    row = {name: _number(cells[name], whole=name in IDS) for name in wanted}
    for name, value in row.items():
        if value is None:
            kind = "a whole number" if name in IDS else "a number"
            problem = f"{name} is '{cells[name].strip()}'; write {kind}"
            faults.add(f"{place}: {problem}", kind=f"{place.split(', ')[0]}: {name} is not {kind}")
    return row


def _number(text: str, *, whole: bool) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    if not whole:
        return value
    return int(value) if value.is_integer() and abs(value) <= _LARGEST_ID else None
