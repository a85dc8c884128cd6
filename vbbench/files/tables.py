"""Parquet tables of datasets and submissions: their schemas, and writers by row group."""

import hashlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import ArrayLike, NDArray

from vbbench.folders.replacing import replacing
from vbbench.geometry import BoolArray, IntArray

Columns = Mapping[str, NDArray[Any]]

_I, _F, _F4 = pa.int32(), pa.float64(), pa.float32()

LARGEST_ID = 2**31 - 1
"""The largest id that a table can hold."""

MOTION = ("forward", "left", "turn")
"""Columns of ``odometry``: the motion since the frame before, in its axes."""

MOTION_COVARIANCE = ("ff", "fl", "f_turn", "ll", "l_turn", "turn_turn")
"""Columns of ``odometry``: the upper triangle of the motion's covariance, row by row."""

SCHEMAS: dict[str, pa.Schema] = {
    "sequences": pa.schema(
        [(name, _I) for name in ("sequence", "scene", "observer", "first_frame", "frames", "people")]
        + [("split", pa.string())]
    ),
    "observations": pa.schema(
        [("sequence", _I), ("frame", _I), ("track", _I), ("u", _F), ("v", _F), ("l", _F), ("visible", pa.float32())]
    ),
    "given": pa.schema([("sequence", _I), ("frame", _I), ("track", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "odometry": pa.schema([("sequence", _I), ("frame", _I)] + [(name, _F) for name in (*MOTION, *MOTION_COVARIANCE)]),
    "truth/scenes": pa.schema([("scene", _I), ("frame", _I), ("person", _I), ("x", _F), ("y", _F)]),
    "truth/people": pa.schema([("scene", _I), ("person", _I), ("height", _F)]),
    "truth/poses": pa.schema([("sequence", _I), ("frame", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "truth/frames": pa.schema([("sequence", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "truth/tracks": pa.schema([("sequence", _I), ("frame", _I), ("track", _I), ("person", _I)]),
    "poses": pa.schema([("sequence", _I), ("frame", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "positions": pa.schema([("sequence", _I), ("frame", _I), ("track", _I), ("x", _F), ("y", _F)]),
    "heights": pa.schema([("sequence", _I), ("track", _I), ("height", _F), ("variance", _F)]),
}
"""Columns of every table, by its path in the folder without ``.parquet``; rows ascend by sequence (or scene)."""

ODOMETRY_TABLE = "odometry"
"""The table of what observers measure of their motion, with the upper triangle of its covariance row by row."""

TRACK_TABLE = "truth/tracks"
"""The table of the person behind each track: one row where it begins to stand for a person, until its next row."""

FRAME_TABLE = "truth/frames"
"""The table of worlds: where the scene lies in each sequence's own."""

SCENE_TABLES = ("truth/scenes", "truth/people")
"""The tables of scenes: written by sequence where every sequence has its own scene."""

FALLBACK = "fallback"
"""Optional column of ``poses``: whether the observer's prior decided the frame, as too few people were seen."""

CONVERGED = "converged"
"""Optional column of ``poses``: whether the solver found its optimum, by its own account."""

COVARIANCES = {"poses": ("xx", "xy", "x_yaw", "yy", "y_yaw", "yaw_yaw"), "positions": ("xx", "xy", "yy")}
"""Optional columns of ``poses`` and ``positions``: the upper triangle, row by row, of a covariance."""

CAMERA = "camera"
"""Optional column of ``sequences``: the number of the sequence's camera, in datasets of several."""

OPTIONAL: dict[str, pa.Schema] = {
    "sequences": pa.schema([(CAMERA, _I)]),
    "poses": pa.schema(
        [(FALLBACK, pa.bool_()), (CONVERGED, pa.bool_())] + [(name, _F4) for name in COVARIANCES["poses"]]
    ),
    "positions": pa.schema([(name, _F4) for name in COVARIANCES["positions"]]),
}
"""Optional columns of a table, which follow the others."""


def table_schema(name: str, columns: Collection[str]) -> pa.Schema:
    """Schema of the table called ``name``: its required columns, and the optional ones in ``columns``."""
    extra = [field for field in OPTIONAL.get(name, ()) if field.name in columns]
    return pa.schema([*SCHEMAS[name], *extra]) if extra else SCHEMAS[name]


def to_arrow(name: str, columns: Columns) -> pa.Table:
    """Columns as an Arrow table of the schema called ``name``, with those optional columns that are given."""
    schema = table_schema(name, columns.keys())
    return pa.Table.from_arrays([arrow_array(columns[field.name], field.type) for field in schema], schema=schema)


def row_groups(name: str, pieces: Sequence[Columns]) -> list[pa.Table]:
    """The pieces as Arrow tables, like `to_arrow`; all have the same columns, and share their memory.

    One conversion of all is faster than one for each: sequences have only a few hundred rows.
    """
    if len(pieces) == 1:
        return [to_arrow(name, pieces[0])]
    whole = to_arrow(name, {column: np.concatenate([piece[column] for piece in pieces]) for column in pieces[0]})
    ends = np.cumsum([len(piece[whole.column_names[0]]) for piece in pieces]).tolist()
    return [whole.slice(start, end - start) for start, end in pairwise([0, *ends])]


def arrow_array(values: ArrayLike, kind: pa.DataType) -> pa.Array:
    """The values, copied, as an Arrow array; raises pyarrow.ArrowInvalid if an integer does not fit.

    `pyarrow.array` is slower, and imports pandas, which takes half a second.
    """
    array = np.asarray(values)
    if pa.types.is_string(kind) and array.dtype.kind == "U":
        texts = [text.encode() for text in array.tolist()]
        ends = np.cumsum([0, *map(len, texts)], dtype=np.int32)
        return pa.Array.from_buffers(kind, len(texts), [None, pa.py_buffer(ends), pa.py_buffer(b"".join(texts))])
    if not (pa.types.is_primitive(kind) and array.dtype.kind in "biuf"):
        return pa.array(values, type=kind)
    if pa.types.is_boolean(kind):
        own = np.packbits(array.astype(np.bool_), bitorder="little")
    else:
        own = np.array(array, dtype=kind.to_pandas_dtype(), order="C")
        if pa.types.is_integer(kind) and own.dtype != array.dtype and not np.array_equal(own, array):
            return pa.array(values, type=kind)
    return pa.Array.from_buffers(kind, len(array), [None, pa.py_buffer(own)])


def column_values(column: pa.ChunkedArray) -> NDArray[Any]:
    """A column without empty cells as a NumPy array: Arrow's own ``to_numpy`` imports pandas, too."""
    if pa.types.is_boolean(column.type) and not column.null_count:
        return column_values(column.cast(pa.uint8())).astype(np.bool_)
    if not pa.types.is_primitive(column.type) or column.null_count:
        return np.asarray(column.to_numpy(zero_copy_only=False) if column.null_count else column.to_pylist())
    chunks = [np.from_dlpack(chunk) for chunk in column.chunks]
    return chunks[0] if len(chunks) == 1 else np.concatenate([np.empty(0, column.type.to_pandas_dtype()), *chunks])


def with_columns(group: pa.Table, schema: pa.Schema) -> pa.Table:
    """The row group with the columns of ``schema``; missing ones are False or NaN."""
    if group.schema.equals(schema):
        return group
    for field in schema:
        if field.name not in group.column_names:
            absent = pa.scalar(False if pa.types.is_boolean(field.type) else np.nan, field.type)
            group = group.append_column(field, pa.repeat(absent, len(group)))
    return group.select(schema.names)


ZSTD_LEVEL = -5
"""A fast level: after byte-stream splitting a slower one saves less than 2 % of the bytes."""

BUFFER = 1 << 18
"""Bytes that are handed to the system together: a row group of a short sequence has pages of some hundred bytes."""

GROUP_ROWS = 2048
"""Sequences share a row group until it has so many rows: a group of a few rows costs as much to write as of these."""

GROUPS_OF_A_SIZE = 4096
"""After this many row groups they have at least twice as many rows, after as many again four times, …: so the footer,
which writer and reader hold in memory, grows with the logarithm of the number of sequences."""


class WholeWriter:
    """A context that writes under temporary names, which are renamed when the block ends without error.

    Subclasses enter the files that they write into ``_open``.
    """

    _open: ExitStack

    def finish(self) -> None:
        """Write the remaining data; after this, files are only renamed."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._open.callback(self.finish)
        self._open.__exit__(kind, error, trace)


class TableWriter(WholeWriter):
    """Writes a table by row groups under a temporary name, which is renamed when the block ends without error.

    Parameters
    ----------
    path : the file.
    name : name of the table in `SCHEMAS`.
    optional : its optional columns; a row group without one has False or NaN there.
    """

    def __init__(self, path: Path, name: str, optional: Collection[str] = ()) -> None:
        self.path = path
        self.rows = 0
        self._schema = table_schema(name, optional)
        self._written = 0
        self._waiting: list[pa.Table] = []
        self._waiting_rows = 0
        with ExitStack() as stack:
            temporary = stack.enter_context(replacing(path))
            self._sink = stack.enter_context(pa.output_stream(str(temporary), compression=None, buffer_size=BUFFER))
            self._writer = stack.enter_context(_parquet_writer(self._sink, self._schema))
            self._open = stack.pop_all()

    def add(self, group: pa.Table) -> None:
        """Append the rows of a sequence or scene; those of short ones share a row group (`GROUP_ROWS`)."""
        if len(group):
            self._waiting.append(with_columns(group, self._schema))
            self._waiting_rows += len(group)
            self.rows += len(group)
        if self._waiting_rows >= GROUP_ROWS * 2 ** (self._written // GROUPS_OF_A_SIZE):
            self._flush()

    def finish(self) -> None:
        """Write the remaining rows; nothing can be added after this."""
        self._flush()
        self._writer.close()
        self._sink.close()

    def _flush(self) -> None:
        if self._waiting:
            rows = pa.concat_tables(self._waiting) if len(self._waiting) > 1 else self._waiting[0]
            self._writer.write_table(rows, row_group_size=len(rows))
            self._written += 1
            self._waiting.clear()
            self._waiting_rows = 0


def _parquet_writer(sink: pa.NativeFile, schema: pa.Schema) -> pq.ParquetWriter:
    return pq.ParquetWriter(
        sink,
        schema,
        compression="zstd",
        compression_level=ZSTD_LEVEL,
        use_dictionary=False,
        write_statistics=[schema.names[0]],
        column_encoding={field.name: _encoding(field.type) for field in schema},
    )


def _encoding(kind: pa.DataType) -> str:
    if pa.types.is_floating(kind):
        return "BYTE_STREAM_SPLIT"
    return "DELTA_BINARY_PACKED" if pa.types.is_integer(kind) else "PLAIN"


def file_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def content_sha256(path: Path) -> str:
    """SHA-256 of a file's bytes, or of those of the files in a folder by their names, in hex."""
    if not path.is_dir():
        return file_sha256(path)
    files = sorted(one for one in path.rglob("*") if one.is_file())
    listed = "\n".join(f"{one.relative_to(path).as_posix()} {file_sha256(one)}" for one in files)
    return hashlib.sha256(listed.encode()).hexdigest()


def first_repetition(*columns: IntArray) -> tuple[int, int] | None:
    """The first row that equals an earlier one in all ``columns`` [N], as (earlier, later); ``None`` without any.

    Ascending rows, as in most files, are not sorted again.
    """
    if _steps(columns)[1].all():
        return None
    order = np.lexsort(columns)  # stable: of two equal ones, the earlier row comes first
    same = np.flatnonzero(_steps([column[order] for column in columns])[0])
    if not len(same):
        return None
    place = same[order[same + 1].argmin()]
    return int(order[place]), int(order[place + 1])


def _steps(columns: Iterable[IntArray]) -> tuple[BoolArray, BoolArray]:
    """[N − 1] whether each row equals the one before, and whether it is greater in the first column that differs."""
    equal: BoolArray = np.array(True)
    greater: BoolArray = np.array(False)
    for column in columns:
        step = np.diff(column)
        greater = greater | (equal & (step > 0))
        equal = equal & (step == 0)
    return equal, greater
