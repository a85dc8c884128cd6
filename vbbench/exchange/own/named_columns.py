"""Tables of numbers under names: CSV with a header, read fast, and by line where something is wrong."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from vbbench.errors import FileError, quoted, suggestion
from vbbench.files.tables import column_values
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.numbers import finite_number


@dataclass(frozen=True)
class NamedColumns:
    """Columns of a table.

    Parameters
    ----------
    path : the file, for messages.
    columns : [N] numbers by name; of optional ones NaN for an empty cell.
    lines : [N] their line numbers, from 1.
    ignored : names of columns that are not read.
    """

    path: Path
    columns: dict[str, FloatArray]
    lines: IntArray
    ignored: tuple[str, ...]

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> FloatArray:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.lines)


def read_named(path: Path, wanted: Sequence[Collection[str]], optional: Collection[str] = ()) -> NamedColumns:
    """The columns of a CSV file whose first line names them, in any order; blank lines are skipped.

    Parameters
    ----------
    path : the file.
    wanted : of each collection, one name must be there: ``[("frame", "time"), ("x",)]``.
    optional : names that may be there, with empty cells.

    Raises
    ------
    FileError
        If it cannot be read or has no rows, a name is missing, or, with the line, a cell is not a finite number.
    """
    if not path.is_file():
        raise FileError(path, "the file is missing")
    content = path.read_bytes().removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    header = [cell.strip(" \t\"'") for cell in content.partition(b"\n")[0].decode("utf-8", "replace").split(",")]
    known = [name for names in wanted for name in names]
    for names in wanted:
        here = [name for name in names if name in header]
        if len(here) != 1:
            _refuse_header(path, header, list(names), here, wanted)
    used = [name for name in header if name in known or name in optional]
    if len(set(used)) < len(used):
        raise FileError(path, f"a column stands twice: {', '.join(header)}", 1)
    table = _read_fast(content, header, used, optional) or _read_carefully(path, content, header, used, optional)
    columns, lines = table
    if not len(lines):
        raise FileError(path, "holds no row")
    return NamedColumns(path, columns, lines, tuple(name for name in header if name not in used))


def _refuse_header(
    path: Path, header: list[str], names: list[str], here: list[str], wanted: Sequence[Collection[str]]
) -> None:
    shown = quoted(",".join(header))
    if here:
        raise FileError(path, f"has columns {' and '.join(here)}, which say the same; keep one of them ({shown})", 1)
    near = [suggestion(name, names) for name in header if "?" in suggestion(name, names)]
    everything = ", ".join(" or ".join(names) for names in wanted)
    hint = near[0] if near else f"its first line is {shown}, wanted: {everything}"
    if len(header) == 1 and ";" in header[0]:
        hint = "columns are separated by ',', not by ';'"
    raise FileError(path, f"has no column {' or '.join(names)}; {hint}", 1)


Rows = tuple[dict[str, FloatArray], IntArray]


def _read_fast(content: bytes, header: list[str], used: list[str], optional: Collection[str]) -> Rows | None:
    """The rows of a table whose cells are all numbers, empty only where they may be; else ``None``."""
    kinds = {name: pa.float64() for name in used}
    convert = csv.ConvertOptions(column_types=kinds, include_columns=used, null_values=["", "nan", "NaN"])
    parse = csv.ParseOptions(ignore_empty_lines=False)
    names = [name if name in used else f"{number}: {name}" for number, name in enumerate(header)]
    try:
        table = csv.read_csv(BytesIO(content), csv.ReadOptions(column_names=names, skip_rows=1), parse, convert)
    except pa.ArrowException:
        return None
    columns = {
        name: np.array(column_values(cells), np.float64) for name, cells in zip(used, table.columns, strict=True)
    }
    if not all(np.isfinite(values).all() for name, values in columns.items() if name not in optional):
        return None
    return columns, np.arange(2, 2 + len(table))


def _read_carefully(path: Path, content: bytes, header: list[str], used: list[str], optional: Collection[str]) -> Rows:
    lines, rows = [], []
    for line, text in enumerate(re.split("\r\n|\r|\n", content.decode("utf-8", "replace")), 1):
        if line == 1 or not text.strip():
            continue
        cells = dict(zip(header, text.split(","), strict=False))
        if text.count(",") + 1 != len(header):
            raise FileError(path, f"{text.count(',') + 1} columns, the first line names {len(header)}", line)
        rows.append([_number(path, line, name, cells[name], name in optional) for name in used])
        lines.append(line)
    values = np.array(rows, np.float64).reshape(-1, len(used))
    return dict(zip(used, values.T, strict=True)), np.array(lines, np.int64)


def _number(path: Path, line: int, name: str, cell: str, may_be_empty: bool) -> float:
    cell = cell.strip(" \t\"'")
    if may_be_empty and cell.lower() in ("", "nan"):
        return float("nan")
    return finite_number(path, line, name, cell)
