"""A table of a submission, Parquet or CSV, read a range of sequences at a time."""

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.csv_rows import read_csv_rows
from vbbench.errors import FileError
from vbbench.faults import Faults
from vbbench.tables import SCHEMAS, SequenceTable

Arrays = dict[str, NDArray[Any]]


class SubmissionTable(Protocol):
    """Rows of a submission, in order of sequence."""

    @property
    def file(self) -> str:
        """Name of the file, for messages."""

    def read(self, first: int, last: int) -> Arrays:
        """Rows with first ≤ sequence < last, an array a column; from CSV also the 1-based ``line``."""


class ParquetRows:
    """A table of a submission as vbbench, or a stranger, wrote it in Parquet."""

    def __init__(self, path: Path, name: str) -> None:
        self.file = path.name
        self._table = SequenceTable(path, name)

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


def open_table(folder: Path, name: str, faults: Faults) -> SubmissionTable | None:
    """The table called ``name`` (``poses`` or ``positions``); ``None`` and a fault where there is none to read."""
    parquet, csv = folder / f"{name}.parquet", folder / f"{name}.csv"
    if parquet.is_file() and csv.is_file():
        faults.add(f"{csv.name}: stands beside {parquet.name}; remove one of them")
    if not parquet.is_file() and not csv.is_file():
        faults.add(f"{parquet.name}: the file is missing, and so is {csv.name}; write one of them")
        return None
    try:
        if parquet.is_file():
            return ParquetRows(parquet, name)
        columns = read_csv_rows(csv, [field.name for field in SCHEMAS[name]], faults)
        return None if columns is None else RowsInMemory(csv.name, columns)
    except FileError as error:
        faults.add(str(error).replace(str(error.path), error.path.name, 1))
        return None
