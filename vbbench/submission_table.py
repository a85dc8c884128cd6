"""A table of a submission, Parquet or CSV, read a range of sequences at a time."""

from collections.abc import Collection
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vbbench.csv_rows import read_csv_rows
from vbbench.errors import FileError
from vbbench.faults import Faults
from vbbench.schemas import CONVERGED, FALLBACK, SCHEMAS
from vbbench.tables import SequenceTable

Arrays = dict[str, NDArray[Any]]


class SubmissionTable(Protocol):
    """Rows of a submission, in order of sequence."""

    @property
    def file(self) -> str:
        """Name of the file, for messages."""

    def read(self, first: int, last: int) -> Arrays:
        """Rows with first ≤ sequence < last, an array a column; the optional ones that are there, ``line`` from CSV."""


class ParquetRows:
    """A table of a submission as vbbench, or a stranger, wrote it in Parquet."""

    def __init__(self, path: Path, name: str, optional: Collection[str]) -> None:
        self.file = path.name
        self._table = SequenceTable(path, name, optional=optional)

    def read(self, first: int, last: int) -> Arrays:
        """See `SubmissionTable.read`."""
        return self._table.read(first, last)


class RowsInMemory:
    """A table of a submission that is already in memory."""

    def __init__(self, file: str, columns: Arrays) -> None:
        self.file = file
        order = np.argsort(columns["sequence"], kind="stable")
        self._columns = {name: values[order] for name, values in columns.items()}

    def read(self, first: int, last: int) -> Arrays:
        """See `SubmissionTable.read`."""
        start, stop = np.searchsorted(self._columns["sequence"], [first, last])
        return {name: values[start:stop] for name, values in self._columns.items()}


def open_table(
    folder: Path, name: str, faults: Faults, optional: Collection[str] = (FALLBACK,)
) -> SubmissionTable | None:
    """The table called ``name`` (``poses`` or ``positions``); ``None`` and a fault where there is none to read.

    Of the optional columns (`vbbench.schemas.OPTIONAL`) only those named are read.
    """
    parquet, csv = folder / f"{name}.parquet", folder / f"{name}.csv"
    if parquet.is_file() and csv.is_file():
        faults.add(f"{csv.name}: stands beside {parquet.name}; remove one of them")
    if parquet.is_file():
        return _open_parquet(parquet, name, faults, optional)
    if csv.is_file():
        columns = read_csv_rows(csv, SCHEMAS[name].names, faults, optional=optional)
        return None if columns is None else RowsInMemory(csv.name, columns)
    faults.add(f"{parquet.name}: the file is missing, and so is {csv.name}; write one of them")
    return None


def file_fault(error: FileError) -> str:
    """The message of an error about a file of the submission, with the file's name for its path."""
    return str(error).replace(str(error.path), error.path.name, 1)


def _open_parquet(path: Path, name: str, faults: Faults, optional: Collection[str]) -> ParquetRows | None:
    try:
        _require_numbers(path, name, optional)
        return ParquetRows(path, name, optional)
    except FileError as error:
        faults.add(file_fault(error))
        return None


def _require_numbers(path: Path, name: str, optional: Collection[str]) -> None:
    try:
        schema = pq.read_schema(path)
    except (pa.ArrowException, OSError) as error:
        raise FileError(path, f"is damaged or no Parquet file ({error}); write it again") from error
    wanted = {*SCHEMAS[name].names, *optional}
    text = [f.name for f in schema if f.name in wanted and not _is_number(f)]
    if text:
        raise FileError(path, f"column {', '.join(text)} holds no numbers; write integers and floats")


def _is_number(field: pa.Field) -> bool:
    if field.name in (FALLBACK, CONVERGED) and pa.types.is_boolean(field.type):
        return True
    return bool(pa.types.is_integer(field.type) or pa.types.is_floating(field.type))
