"""The columns of every table of datasets and submissions."""

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import ArrayLike, NDArray

Columns = Mapping[str, NDArray[Any]]

_I, _F, _F4 = pa.int32(), pa.float64(), pa.float32()

SCHEMAS: dict[str, pa.Schema] = {
    "sequences": pa.schema(
        [(name, _I) for name in ("sequence", "scene", "observer", "first_frame", "frames", "people")]
        + [("split", pa.string())]
    ),
    "observations": pa.schema(
        [("sequence", _I), ("frame", _I), ("track", _I), ("u", _F), ("v", _F), ("l", _F), ("visible", pa.float32())]
    ),
    "given": pa.schema([("sequence", _I), ("frame", _I), ("track", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "truth/scenes": pa.schema([("scene", _I), ("frame", _I), ("person", _I), ("x", _F), ("y", _F)]),
    "truth/people": pa.schema([("scene", _I), ("person", _I), ("height", _F)]),
    "truth/poses": pa.schema([("sequence", _I), ("frame", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "truth/tracks": pa.schema([("sequence", _I), ("frame", _I), ("track", _I), ("person", _I)]),
    "poses": pa.schema([("sequence", _I), ("frame", _I), ("x", _F), ("y", _F), ("yaw", _F)]),
    "positions": pa.schema([("sequence", _I), ("frame", _I), ("track", _I), ("x", _F), ("y", _F)]),
    "heights": pa.schema([("sequence", _I), ("track", _I), ("height", _F), ("variance", _F)]),
}
"""Columns of every table, by its path in the folder without ``.parquet``; one row group per sequence (or scene)."""

TRACK_TABLE = "truth/tracks"
"""The table of the person behind each track, in tiers that track people: in others a track is a person."""

SCENE_TABLES = ("truth/scenes", "truth/people")
"""The tables of scenes: written by sequence where every sequence has a scene of its own."""

FALLBACK = "fallback"
"""Optional column of ``poses``: whether the observer's prior decided the frame, as too few people were seen."""

CONVERGED = "converged"
"""Optional column of ``poses``: whether the solver believes that it found its own optimum."""

COVARIANCES = {"poses": ("xx", "xy", "x_yaw", "yy", "y_yaw", "yaw_yaw"), "positions": ("xx", "xy", "yy")}
"""Optional columns of ``poses`` and ``positions``: the upper triangle, row by row, of a covariance."""

OPTIONAL: dict[str, pa.Schema] = {
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


def arrow_array(values: ArrayLike, kind: pa.DataType) -> pa.Array:
    """The values, copied, as an Arrow array; raises pyarrow.ArrowInvalid if an integer does not fit.

    `pyarrow.array` is slower, and imports pandas, which takes half a second.
    """
    array = np.asarray(values)
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
    if group.column_names == schema.names:
        return group
    for field in schema:
        if field.name not in group.column_names:
            absent = pa.scalar(False if pa.types.is_boolean(field.type) else np.nan, field.type)
            group = group.append_column(field, pa.repeat(absent, len(group)))
    return group.select(schema.names)
