"""What is done to a Parquet table: columns and values that no honest table has, in a file that is whole."""

from io import BytesIO
from random import Random
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from tests.fuzz.mutations import BYTES, Mutation

NAMES = ("x", "sequence", "", "a\nb", "\x1b[2J", "frame", "ü" * 200, "yaw ", "X")


def table_structure(content: bytes, random: Random) -> bytes:
    """Columns and values change; the file is whole."""
    try:
        table = pq.read_table(BytesIO(content), use_threads=False)
    except (pa.ArrowException, OSError, ValueError):
        return BYTES[0](content, random)
    for _ in range(random.choice((1, 1, 2))):
        table = random.choice(_CHANGES)(table, random)
    sink = BytesIO()
    try:
        pq.write_table(table, sink, **_layout(table, random))
    except (pa.ArrowException, ValueError):
        return content
    return sink.getvalue()


def _layout(table: pa.Table, random: Random) -> dict[str, Any]:
    """How the file is laid out."""
    return {
        "row_group_size": random.choice((1, 7, max(1, len(table)))),
        "use_dictionary": random.random() < 0.5,
        "write_statistics": random.random() < 0.7,
        "compression": random.choice(("none", "zstd", "snappy", "gzip")),
    }


def _without(table: pa.Table, random: Random) -> pa.Table:
    return table.remove_column(random.randrange(table.num_columns)) if table.num_columns else table


def _renamed(table: pa.Table, random: Random) -> pa.Table:
    names = list(table.column_names)
    if names:
        names[random.randrange(len(names))] = random.choice(NAMES)
    return table.rename_columns(names)


def _swapped(table: pa.Table, random: Random) -> pa.Table:
    names = list(table.column_names)
    random.shuffle(names)
    return table.rename_columns(names)


def _retyped(table: pa.Table, random: Random) -> pa.Table:
    """A column of another type, cast where that is possible and made up where it is not."""
    if not table.num_columns:
        return table
    kinds = (pa.int8(), pa.int64(), pa.uint64(), pa.float16(), pa.float32(), pa.string(), pa.bool_(), pa.date32())
    kinds += (pa.decimal128(30, 2), pa.timestamp("ns"), pa.large_string(), pa.binary(), pa.null(), pa.float64())
    place, kind = random.randrange(table.num_columns), random.choice(kinds)
    try:
        column = table.column(place).cast(kind, safe=False)
    except (pa.ArrowException, ValueError):
        column = pa.nulls(len(table), kind)
    return table.set_column(place, table.column_names[place], column)


def _nested(table: pa.Table, random: Random) -> pa.Table:
    """A column of lists or of structs, before ours or in the place of one."""
    made: Any = [[1, 2]] * len(table) if random.random() < 0.5 else [{"a": 1, "b": 2}] * len(table)
    name = random.choice(table.column_names) if table.num_columns and random.random() < 0.3 else "extra"
    return table.add_column(random.randrange(table.num_columns + 1), name, pa.array(made))


def _revalued(table: pa.Table, random: Random) -> pa.Table:
    """Some cells hold what no place, id or frame can be."""
    if not table.num_columns or not len(table):
        return table
    place = random.randrange(table.num_columns)
    kind = table.schema.field(place).type
    wild = (
        [np.nan, np.inf, -np.inf, 1e308, -1e308, 0.0, 1e7, None]
        if pa.types.is_floating(kind)
        else [-1, -2, 2**31 - 1, -(2**31), 0, 10**6, 300, None]
    )
    values = table.column(place).to_pylist()
    for _ in range(random.choice((1, 1, 5, len(values)))):
        values[random.randrange(len(values))] = random.choice(wild)
    try:
        column = pa.array(values, kind, from_pandas=False)
    except (pa.ArrowException, ValueError, OverflowError, TypeError):
        return table
    return table.set_column(place, table.column_names[place], column)


def _reordered(table: pa.Table, random: Random) -> pa.Table:
    rows = list(range(len(table)))
    random.shuffle(rows)
    kept = rows[: random.choice((0, 1, len(rows), len(rows)))]
    return table.take(pa.array(kept, pa.int64()))


def _repeated(table: pa.Table, random: Random) -> pa.Table:
    return pa.concat_tables([table] * random.choice((2, 3)))


def _shifted(table: pa.Table, random: Random) -> pa.Table:
    """A whole column is off."""
    if not table.num_columns:
        return table
    place = random.randrange(table.num_columns)
    try:
        column = pc.add(table.column(place), pa.scalar(random.choice((1, -1, 100)), table.schema.field(place).type))
    except (pa.ArrowException, ValueError):
        return table
    return table.set_column(place, table.column_names[place], column)


_CHANGES = (_without, _renamed, _swapped, _retyped, _nested, _revalued, _revalued, _reordered, _repeated, _shifted)
PARQUET: tuple[Mutation, ...] = (*BYTES, *[table_structure] * 14)
