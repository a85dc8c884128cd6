"""Parquet tables of datasets and submissions, written row group by row group, and the folders that hold them."""

import hashlib
from collections.abc import Collection, Iterable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.files.schemas import table_schema, with_columns
from vbbench.folders.replacing import replacing

ZSTD_LEVEL = -5
"""A fast level: after byte-stream splitting a slower one saves less than 2 % of the bytes."""

GROUPS_ALONE = 4096
"""This many row groups are written one by one, then as many of two each, of four, …: so the footer, which writer and
reader hold in memory, grows with the logarithm of the number of sequences."""


class TableWriter:
    """Writes one table row group by row group under a temporary name; it appears, whole, when the block ends well.

    Parameters
    ----------
    path : the file.
    name : what the table is called in `SCHEMAS`.
    optional : the optional columns that it is to have; a row group without one has False or NaN there.
    """

    def __init__(self, path: Path, name: str, optional: Collection[str] = ()) -> None:
        self.path = path
        self.rows = 0
        self._schema = table_schema(name, optional)
        self._written = 0
        self._waiting: list[pa.Table] = []
        with ExitStack() as stack:
            temporary = stack.enter_context(replacing(path))
            self._writer = stack.enter_context(_parquet_writer(temporary, self._schema))
            self._open = stack.pop_all()

    def add(self, group: pa.Table) -> None:
        """Append a row group, unless it is empty. In very long tables several are written as one (`GROUPS_ALONE`)."""
        if len(group):
            self._waiting.append(with_columns(group, self._schema))
            self.rows += len(group)
        if len(self._waiting) >= 2 ** (self._written // GROUPS_ALONE):
            self._flush()

    def finish(self) -> None:
        """Write the remaining rows; nothing can be added after this, and only the renaming of the file remains."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        if self._waiting:
            rows = pa.concat_tables(self._waiting) if len(self._waiting) > 1 else self._waiting[0]
            self._writer.write_table(rows, row_group_size=len(rows))
            self._written += 1
            self._waiting.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._open.callback(self.finish)
        self._open.__exit__(kind, error, trace)


def table_bytes(name: str, groups: Iterable[pa.Table], optional: Collection[str] = ()) -> bytes:
    """The Parquet file that `TableWriter` would write."""
    schema, sink = table_schema(name, optional), pa.BufferOutputStream()
    with _parquet_writer(sink, schema) as writer:
        for group in groups:
            if len(group):
                writer.write_table(with_columns(group, schema), row_group_size=len(group))
    data: bytes = sink.getvalue().to_pybytes()
    return data


def _parquet_writer(sink: Path | pa.NativeFile, schema: pa.Schema) -> pq.ParquetWriter:
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
