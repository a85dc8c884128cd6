"""Parquet files of anybody, opened: what is believed of a footer, and what must be so before a row is read."""

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.errors import FileError

UNREADABLE = (pa.ArrowException, OSError, ValueError)
"""What the Parquet library raises for files that are damaged or made to harm; a bad column name is a ValueError."""

BYTES_A_VALUE, BYTES_A_COLUMN = 64, 1 << 20
"""Unpacked bytes that a column of numbers may have: no number has over 8, and pages have heads and dictionaries."""


def open_parquet(
    path: Path, wanted: Collection[str], optional: Collection[str] = ()
) -> tuple[pq.ParquetFile, pa.Schema]:
    """The open file, and the fields of its columns of those names.

    Raises
    ------
    FileError
        If it is missing or no Parquet file, lacks a column that is wanted, or has one twice or nested.
    """
    if not path.is_file():
        raise FileError(path, "the file is missing")
    try:
        file = pq.ParquetFile(path)
        schema = file.schema_arrow
        count = Counter(schema.names)
        leaves = Counter(path.partition(".")[0] for path in _leaf_paths(file))
    except UNREADABLE as error:
        raise FileError(path, f"is damaged or no Parquet file ({error}); write or copy it again") from error
    missing = [name for name in wanted if not count[name]]
    if missing:
        raise FileError(path, f"column {', '.join(missing)} is missing; wanted {', '.join(wanted)}")
    there = [name for name in (*wanted, *optional) if count[name]]
    twice = [name for name in there if count[name] > 1]
    if twice:
        raise FileError(path, f"column {', '.join(twice)} stands there twice; keep one")
    nested = [name for name in there if leaves[name] != 1]
    if nested:
        raise FileError(path, f"column {', '.join(nested)} is nested; write one column of numbers of that name")
    return file, pa.schema([schema.field(name) for name in there])


def leaf_of(file: pq.ParquetFile, name: str) -> int:
    """Number of the leaf column that the flat column called ``name`` is: a nested column before it has several."""
    return _leaf_paths(file).index(name)


def check_footer(path: Path, file: pq.ParquetFile, names: Collection[str]) -> None:
    """Check that the flat columns called ``names`` unpack to no more than their rows need.

    Raises
    ------
    FileError
        At the first that does not, or says that it has more values than rows.
    """
    for leaf in [leaf_of(file, name) for name in names]:
        for rows, values, unpacked in _column_sizes(file, leaf):
            if values != rows or not 0 <= unpacked <= BYTES_A_VALUE * rows + BYTES_A_COLUMN:
                problem = f"says that {rows} rows of a column are {values} values and unpack to {unpacked} bytes"
                raise FileError(path, f"is damaged or a trap: it {problem}; write it again")


def _leaf_paths(file: pq.ParquetFile) -> list[str]:
    schema = file.metadata.schema
    return [schema.column(number).path for number in range(len(schema))]


def _column_sizes(file: pq.ParquetFile, leaf: int) -> Iterator[tuple[int, int, int]]:
    """Of each row group the rows, and the values and unpacked bytes of a leaf column, as the footer says."""
    for number in range(file.num_row_groups):
        group = file.metadata.row_group(number)
        column = group.column(leaf)
        yield group.num_rows, column.num_values, column.total_uncompressed_size


SPARE_ROWS = 1 << 16
"""Rows that may be too many before a table is refused unread: their faults are listed one by one."""


@dataclass(frozen=True)
class RowBound:
    """The rows that a table can have.

    Parameters
    ----------
    possible : one for each frame, or for each track in each frame, of the dataset.
    """

    possible: int

    @property
    def most(self) -> int:
        """Rows that are read: each of the possible ones twice, and some to spare."""
        return 2 * self.possible + SPARE_ROWS

    def check(self, path: Path, rows: int) -> None:
        """Check a number of rows.

        Raises
        ------
        FileError
            If there are more than `most`.
        """
        if rows > self.most:
            raise FileError(path, f"{rows} rows or more; the dataset has {self.possible} at most, remove the others")
