"""A table of a submission, Parquet or CSV, read a range of sequences at a time."""

from collections.abc import Collection
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.csv_rows import read_csv_rows
from vbbench.dataset import Dataset
from vbbench.errors import FileError
from vbbench.faults import Faults
from vbbench.row_bound import RowBound
from vbbench.schemas import FALLBACK, SCHEMAS
from vbbench.sequence_table import SequenceTable

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

    def __init__(self, path: Path, name: str, optional: Collection[str], bound: RowBound) -> None:
        self.file = path.name
        self._table = SequenceTable(path, name, optional=optional, bound=bound)

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
    folder: Path, name: str, dataset: Dataset, faults: Faults, optional: Collection[str] = (FALLBACK,)
) -> SubmissionTable | None:
    """The table called ``name`` (``poses`` or ``positions``); ``None`` and a fault where there is none to read.

    Of the optional columns (`vbbench.schemas.OPTIONAL`) only those named are read. A table with more rows than one
    that answers ``dataset`` can have is not read at all.
    """
    parquet, csv = folder / f"{name}.parquet", folder / f"{name}.csv"
    bound = row_bound(name, dataset)
    if parquet.is_file() and csv.is_file():
        faults.add(f"{csv.name}: stands beside {parquet.name}; remove one of them")
    try:
        if parquet.is_file():
            return ParquetRows(parquet, name, optional, bound)
        if csv.is_file():
            columns = read_csv_rows(csv, SCHEMAS[name].names, faults, optional, bound)
            return None if columns is None else RowsInMemory(csv.name, columns)
    except FileError as error:
        faults.add_error(error)
        return None
    faults.add(f"{parquet.name}: the file is missing, and so is {csv.name}; write one of them")
    return None


def row_bound(name: str, dataset: Dataset) -> RowBound:
    """The rows that ``poses`` (one a frame) or ``positions`` (one for each track in each frame) can have."""
    rows = dataset.rows["frames"] if name == "poses" else dataset.cells
    return RowBound(int(rows.sum(dtype=np.int64)))
