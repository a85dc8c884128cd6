"""Parquet tables of a dataset or submission, read a range of sequences at a time; sequences from their rows."""

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import ArrayLike, NDArray

from vbbench.errors import FileError
from vbbench.files.dataset_checks import PathOf, Rows, check_frame, check_sequence, check_tracks
from vbbench.files.tables import (
    CAMERA,
    MOTION,
    MOTION_COVARIANCE,
    OPTIONAL,
    SCHEMAS,
    arrow_array,
    column_values,
    table_schema,
)
from vbbench.geometry import IntArray
from vbbench.scene import World
from vbbench.sequence import NOBODY, Given, Odometry, Sequence, held_persons

KEYS_AT_ONCE = 1 << 20
"""Rows of the key column that are read together if the footer is not trusted."""

_IDS = np.iinfo(np.int32)

UNREADABLE = (pa.ArrowException, OSError, ValueError)
"""What the Parquet library raises for damaged or malicious files; a bad column name is a ValueError."""

BYTES_A_VALUE, BYTES_A_COLUMN = 64, 1 << 20
"""Unpacked bytes that a column of numbers may have: 8 per number at most, and pages have headers and dictionaries."""

SPARE_ROWS = 1 << 16
"""Rows that may be too many before a table is refused unread: their faults are listed one by one."""


@dataclass(frozen=True)
class RowBound:
    """The rows that a table can have: one per frame, or per track in each frame, of the dataset."""

    possible: int

    @property
    def most(self) -> int:
        """Greatest number of rows that is accepted: twice the possible ones, plus `SPARE_ROWS`."""
        return 2 * self.possible + SPARE_ROWS

    def check(self, path: Path, rows: int) -> None:
        """Raise FileError if the table at ``path`` has more than `most` rows."""
        if rows > self.most:
            raise FileError(path, f"{rows} rows or more; the dataset has {self.possible} at most, remove the others")


class SequenceTable:
    """A table on disk, read a range of sequences at a time.

    Row groups in order of sequence, as vbbench writes them, are read on demand; any other order is sorted in memory.

    Raises FileError if the file is missing, is not a Parquet file, lacks a column or has it twice, has one without
    numbers, or more rows than it can have.

    Parameters
    ----------
    path : the file.
    name : name of the table in `SCHEMAS`.
    key : the column by which it is ordered.
    optional : optional columns to read if they exist.
    bound : limit of the rows of an untrusted table, whose footer is then checked; ``None`` for a table of a dataset,
        whose bytes `vbbench verify` checks.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        key: str = "sequence",
        optional: Collection[str] = (),
        bound: RowBound | None = None,
    ) -> None:
        self.path, self._key = path, key
        known = [field.name for field in OPTIONAL.get(name, ()) if field.name in optional]
        self._file, there = open_parquet(path, SCHEMAS[name].names, known)
        self._schema = table_schema(name, there.names)
        self._columns = self._schema.names
        wrong = [field.name for field in there if not _may_hold(field.type, self._schema.field(field.name).type)]
        if wrong:
            raise FileError(path, f"column {', '.join(wrong)} holds no numbers; write integers and floats")
        if bound is not None:
            bound.check(path, self.rows)
            bound.check(path, self._file.num_row_groups)
            check_footer(path, self._file, self._columns)
        rows = [self._file.metadata.row_group(number).num_rows for number in range(self._file.num_row_groups)]
        self._groups = np.flatnonzero(rows)
        self._rows = np.array(rows, np.int64)[self._groups]
        self._first, self._last = self._ranges_by_statistics() if bound is None else self._ranges_by_rows()
        in_order = np.all(self._first[1:] >= self._last[:-1])
        self._whole = None if in_order else self._read(self._groups, self._columns).sort_by(key)
        self._ahead: tuple[frozenset[int], dict[str, NDArray[Any]]] = frozenset(), {}

    @property
    def file(self) -> str:
        """Name of the file, for messages."""
        return self.path.name

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self._file.metadata.num_rows)

    def read(self, first: int, last: int, columns: list[str] | None = None) -> dict[str, NDArray[Any]]:
        """Rows with first ≤ sequence < last, in order of sequence, one NumPy array per column."""
        held, ahead = self._ahead
        if last == first + 1 and first in held:
            start, stop = np.searchsorted(ahead[self._key], [first, last])
            return {name: ahead[name][start:stop] for name in columns or self._columns}
        wanted = list(dict.fromkeys([self._key, *(columns or self._columns)]))
        table = self._in_groups(first, last, wanted) if self._whole is None else self._whole
        arrays = {name: column_values(table.column(name)) for name in wanted}
        start, stop = np.searchsorted(arrays[self._key], [first, last])
        return {name: arrays[name][start:stop] for name in columns or self._columns}

    def read_ahead(self, keys: IntArray) -> None:
        """Read the rows of these sequences at once into memory, for `read`; they replace those read ahead before."""
        keys = np.unique(keys)
        begins, ends = np.searchsorted(keys, self._first), np.searchsorted(keys, self._last, side="right")
        table = self._read(self._groups[ends > begins], self._columns) if self._whole is None else self._whole
        rows = {name: column_values(table.column(name)) for name in self._columns}
        order = np.argsort(rows[self._key], kind="stable")
        self._ahead = frozenset(keys.tolist()), {name: values[order] for name, values in rows.items()}

    def _in_groups(self, first: int, last: int, columns: list[str]) -> pa.Table:
        groups = self._groups[(self._last >= first) & (self._first < last)]
        table = self._read(groups, columns)
        keys = column_values(table.column(self._key))
        return table if np.all(keys[1:] >= keys[:-1]) else table.sort_by(self._key)

    def _read(self, groups: NDArray[np.int64], columns: list[str]) -> pa.Table:
        schema = pa.schema([self._schema.field(name) for name in columns])
        try:
            table = self._file.read_row_groups(groups.tolist(), columns=columns, use_threads=False).select(columns)
            marks = [name for name in columns if _is_mark(schema, table.schema, name)]
            wrong = [
                name
                for name in marks
                if not pc.all(pc.is_in(table.column(name).cast(_F), _ZERO_ONE), min_count=0).as_py()
            ]
            table = table.cast(schema)
        except UNREADABLE as error:
            raise FileError(self.path, f"cannot be read ({error}); generate or copy it again") from error
        empty = [name for name in columns if table.column(name).null_count]
        if empty:
            raise FileError(self.path, f"column {', '.join(empty)} has empty cells; write a number into each")
        if wrong:
            raise FileError(
                self.path, f"column {', '.join(wrong)} holds other numbers than 0 and 1; write True or False"
            )
        return table

    def _ranges_by_statistics(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First and last key of each row group from its statistics; the widest range if it has none."""
        leaf = leaf_of(self._file, self._key)
        stats = [self._file.metadata.row_group(group).column(leaf).statistics for group in self._groups.tolist()]
        try:
            known = [(s.min, s.max) if s is not None and s.has_min_max else (_IDS.min, _IDS.max) for s in stats]
            first, last = np.array(known, np.int64).reshape(-1, 2).T
        except (OverflowError, ValueError) as error:
            raise FileError(self.path, f"its statistics are damaged ({error}); generate or copy it again") from error
        return first, last

    def _ranges_by_rows(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First and last key of each row group from its rows."""
        run, ranges = np.cumsum(self._rows) // KEYS_AT_ONCE, []
        for number in np.unique(run):
            places = np.flatnonzero(run == number)
            keys = column_values(self._read(self._groups[places], [self._key]).column(self._key))
            starts = np.cumsum(self._rows[places]) - self._rows[places]
            ranges.append(np.stack([np.minimum.reduceat(keys, starts), np.maximum.reduceat(keys, starts)]))
        first, last = np.concatenate(ranges, axis=1, dtype=np.int64) if ranges else np.empty((2, 0), np.int64)
        return first, last


_F = pa.float64()
_ZERO_ONE = arrow_array([0.0, 1.0], pa.float64())


def _may_hold(there: pa.DataType, wanted: pa.DataType) -> bool:
    """Whether a column of a type can hold the wanted values; numbers and marks may have several types."""
    if pa.types.is_string(wanted):
        return bool(pa.types.is_string(there) or pa.types.is_large_string(there))
    number = pa.types.is_integer(there) or pa.types.is_floating(there)
    return bool(number or (pa.types.is_boolean(wanted) and pa.types.is_boolean(there)))


def _is_mark(wanted: pa.Schema, there: pa.Schema, name: str) -> bool:
    """Whether the column ``name`` of numbers stands for True and False."""
    return bool(pa.types.is_boolean(wanted.field(name).type) and not pa.types.is_boolean(there.field(name).type))


def open_parquet(
    path: Path, wanted: Collection[str], optional: Collection[str] = ()
) -> tuple[pq.ParquetFile, pa.Schema]:
    """The open file, and the fields of the ``wanted`` and ``optional`` columns.

    Raises FileError if it is missing or not a Parquet file, lacks a wanted column, or has one twice or nested.
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
        raise FileError(path, f"column {', '.join(twice)} is there twice; keep one")
    nested = [name for name in there if leaves[name] != 1]
    if nested:
        raise FileError(path, f"column {', '.join(nested)} is nested; write one column of numbers of that name")
    return file, pa.schema([schema.field(name) for name in there])


def leaf_of(file: pq.ParquetFile, name: str) -> int:
    """Index of the flat column called ``name`` among the leaf columns: a nested column before it has several."""
    return _leaf_paths(file).index(name)


def check_footer(path: Path, file: pq.ParquetFile, names: Collection[str]) -> None:
    """Raise FileError if a flat column in ``names`` unpacks to more than its rows need, or not one value per row."""
    for leaf in [leaf_of(file, name) for name in names]:
        for number in range(file.num_row_groups):
            group = file.metadata.row_group(number)
            column = group.column(leaf)
            rows, values, unpacked = group.num_rows, column.num_values, column.total_uncompressed_size
            if values != rows or not 0 <= unpacked <= BYTES_A_VALUE * rows + BYTES_A_COLUMN:
                problem = f"says that {rows} rows of a column are {values} values and unpack to {unpacked} bytes"
                raise FileError(path, f"is damaged or a trap: it {problem}; write it again")


def _leaf_paths(file: pq.ParquetFile) -> list[str]:
    schema = file.metadata.schema
    return [schema.column(number).path for number in range(len(schema))]


PART_SIZE = 32
"""Sequences per part: large enough to outweigh its overhead, small enough that an interruption loses little."""

ROWS_A_PART = 1 << 20
"""Rows per part, unless a single sequence has more: about 40 MB of observations."""

Ranges = list[tuple[int, int]]
"""Parts of the work: sequences first ≤ index < last of each."""


def part_ranges(count: int, rows: ArrayLike | None = None) -> Ranges:
    """Ranges of ``count`` sequences: at most `PART_SIZE` each, and at most `ROWS_A_PART` rows if these are known.

    Parameters
    ----------
    rows : [count] approximate rows of each sequence; ``None`` if they are not known in advance.
    """
    return ranges_within(count, PART_SIZE, [] if rows is None else [(ROWS_A_PART, rows)])


def ranges_within(count: int, size: int, budgets: Iterable[tuple[int, ArrayLike]] = ()) -> Ranges:
    """Ranges of ``count`` sequences: at most ``size`` each, and within all budgets unless one sequence exceeds them.

    Parameters
    ----------
    budgets : pairs of a greatest sum, and the values [count] of the sequences that are summed.
    """
    sums = [(most, np.cumsum(np.append(0, values), dtype=np.int64)) for most, values in budgets]
    starts = [0]
    while starts[-1] < count:
        first = starts[-1]
        fitting = [int(np.searchsorted(sum_of, sum_of[first] + most, side="right")) - 1 for most, sum_of in sums]
        starts.append(min(max(first + 1, min(fitting, default=count)), first + size, count))
    return list(pairwise(starts))


OBSERVER = -1
"""The track number that stands for the observer in ``given.parquet``."""


def sequence_of(path_of: PathOf, facts: dict[str, Any], boxes: Rows, given: Rows, moved: Rows | None) -> Sequence:
    """The sequence, checked.

    Raises FileError if the rows contradict one another.

    Parameters
    ----------
    path_of : the path of a table, by name, for messages.
    facts : its row of ``sequences``.
    boxes, given, moved : its rows of ``observations``, ``given`` and ``odometry``, if there is that table.
    """
    tracks, column = np.unique(boxes["track"], return_inverse=True)
    shape = (int(facts["frames"]), len(tracks))
    check_sequence(path_of, int(facts["sequence"]), shape[0], boxes, given, tracks)
    observations = np.full((*shape, 3), np.nan)
    observations[boxes["frame"], column] = np.stack([boxes["u"], boxes["v"], boxes["l"]], axis=-1)
    visible = np.full(shape, np.nan)
    visible[boxes["frame"], column] = boxes["visible"]
    return Sequence(
        index=int(facts["sequence"]),
        scene=int(facts["scene"]),
        observer=int(facts["observer"]),
        first_frame=int(facts["first_frame"]),
        tracks=tracks,
        observations=observations,
        visible=visible,
        given=_dense_given(given, tracks, shape, moved),
        camera=int(facts[CAMERA]),
    )


def persons_of(path_of: PathOf, index: int, frames: int, tracks: IntArray, rows: Rows) -> IntArray:
    """[T, K] the person behind each of the ``tracks`` of a sequence, from its ``rows`` of ``truth/tracks``.

    Raises FileError if they name other tracks or frames.
    """
    check_tracks(path_of, index, frames, tracks, rows)
    column = np.searchsorted(tracks, rows["track"])
    persons, begun = np.full((frames, len(tracks)), NOBODY), np.zeros((frames, len(tracks)), np.bool_)
    persons[rows["frame"], column] = rows["person"]
    begun[rows["frame"], column] = True
    return held_persons(persons, begun)


def world_of(path_of: PathOf, index: int, rows: Rows) -> World:
    """The world of a sequence, from its ``rows`` of ``truth/frames``; raises FileError unless there is one."""
    check_frame(path_of, index, rows)
    return World(**{name: float(rows[name][0]) for name in ("x", "y", "yaw")})


def _dense_given(rows: Rows, tracks: IntArray, shape: tuple[int, int], moved: Rows | None) -> Given:
    poses, positions = np.full((shape[0], 3), np.nan), np.full((*shape, 2), np.nan)
    own = rows["track"] == OBSERVER
    poses[rows["frame"][own]] = np.stack([rows["x"][own], rows["y"][own], rows["yaw"][own]], axis=-1)
    column = np.searchsorted(tracks, rows["track"][~own])
    positions[rows["frame"][~own], column] = np.stack([rows["x"][~own], rows["y"][~own]], axis=-1)
    odometry = None if moved is None else _dense_odometry(moved, shape[0])
    return Given(poses=poses, positions=positions, odometry=odometry)


def _dense_odometry(rows: Rows, frames: int) -> Odometry:
    motions, covariances = np.full((frames, 3), np.nan), np.full((frames, 3, 3), np.nan)
    motions[rows["frame"]] = np.stack([rows[name] for name in MOTION], axis=-1)
    i, j = np.triu_indices(3)
    triangle = np.stack([rows[name] for name in MOTION_COVARIANCE], axis=-1)
    for where in ((i, j), (j, i)):
        covariances[rows["frame"][:, None], where[0], where[1]] = triangle
    return Odometry(motions=motions, covariances=covariances)
