"""Partitioned datasets and submissions: a folder a table, a Parquet file a part, as a cluster of workers leaves them.

Beside the tables' folders stands the folder ``partitioned``: a JSON file a part, written when all its tables are there,
the facts of the whole (``dataset.json`` or ``submission.json``), and last of all ``layout.json``.
"""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.errors import FileError, VbbenchError
from vbbench.parts import Part, Ranges, Work, progress_bar
from vbbench.tables import PARTITIONED, table_bytes, write_bytes_atomically, write_text_atomically

LAYOUT_FILE = "layout.json"


@dataclass(frozen=True, kw_only=True)
class PackedPart:
    """One part as files: the bytes of its Parquet files and their columns, by table, and facts that go to JSON."""

    name: str
    files: dict[str, bytes]
    columns: dict[str, list[str]]
    facts: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Layout:
    """What a partitioned folder holds.

    Parameters
    ----------
    marker : the file that its merged form has: ``dataset.json`` or ``submission.json``.
    tables : names of the tables that its merged form has.
    parts : names of the parts, in order.
    withheld : whether the truth tables are to go elsewhere.
    """

    marker: str
    tables: list[str]
    parts: list[str]
    withheld: bool = False


def part_name(first: int) -> str:
    """Name of the part that begins with the sequence ``first``."""
    return f"part-{first:08d}"


def pack(part: Part, name: str) -> PackedPart:
    """Encode a part; a table without rows makes no file."""
    columns = part.columns
    full = {table: groups for table, groups in part.groups.items() if any(len(group) for group in groups)}
    return PackedPart(
        name=name,
        files={table: table_bytes(table, groups, columns[table]) for table, groups in full.items()},
        columns={table: sorted(columns[table]) for table in full},
        facts=part.facts,
    )


def write_partitions(
    work: Work, ranges: Ranges, folder: Path, scheduler: str, *, tls: Path | None, label: str
) -> list[dict[str, Any]]:
    """Have the work, cut into ``ranges``, done by a cluster (`cluster.on_cluster`); return every part's facts in order.

    Parts that are whole in ``folder`` are not made again.
    """
    from vbbench.cluster import on_cluster

    left = [(first, last) for first, last in ranges if not _facts_path(folder, part_name(first)).is_file()]
    sizes = {part_name(first): last - first for first, last in ranges}
    count = sum(sizes.values())
    with progress_bar(count, label, done=count - sum(last - first for first, last in left)) as bar:
        for part in on_cluster(work, left, scheduler, tls) if left else ():
            write_partition(folder, part)
            bar.update(sizes[part.name])
    return [_read_json(_facts_path(folder, name))["facts"] for name in sizes]


def write_partition(folder: Path, part: PackedPart) -> None:
    """Write one part's files; the one that says that all are there comes last."""
    for table, data in part.files.items():
        write_bytes_atomically(_table_path(folder, table, part.name), data)
    digests = {table: sha256(data).hexdigest() for table, data in part.files.items()}
    text = json.dumps({"facts": part.facts, "columns": part.columns, "sha256": digests})
    write_text_atomically(_facts_path(folder, part.name), text)


def write_layout(folder: Path, layout: Layout, facts: str) -> None:
    """Declare a partitioned folder complete; ``facts`` is the text of its ``dataset.json`` or ``submission.json``."""
    write_text_atomically(folder / PARTITIONED / layout.marker, facts)
    write_text_atomically(folder / PARTITIONED / LAYOUT_FILE, json.dumps(asdict(layout), indent=2) + "\n")


def read_layout(folder: Path) -> Layout:
    """What the partitioned ``folder`` holds.

    Raises
    ------
    VbbenchError
        If it is none, or its layout is damaged.
    """
    path = folder / PARTITIONED / LAYOUT_FILE
    if not path.is_file():
        raise VbbenchError(
            f"{folder} is not partitioned; 'vbbench merge' takes what 'generate' and 'solve' make with --scheduler"
        )
    try:
        return Layout(**_read_json(path))
    except TypeError as error:
        raise FileError(path, f"is damaged ({error}); copy the partitions again") from error


class PartitionedTable:
    """One table of a partitioned folder, read part by part; every file is checked against its SHA-256."""

    def __init__(self, folder: Path, name: str, parts: Iterable[str]) -> None:
        self._folder, self._name = folder, name
        facts = {part: _read_json(_facts_path(folder, part)) for part in parts}
        self._digests = {part: known["sha256"][name] for part, known in facts.items() if name in known["sha256"]}
        self.columns = {column for known in facts.values() for column in known["columns"].get(name, ())}

    def groups(self, part: str) -> Iterable[pa.Table]:
        """The row groups of one part.

        Raises
        ------
        FileError
            If its file is missing or damaged.
        """
        if part not in self._digests:
            return
        path = _table_path(self._folder, self._name, part)
        if not path.is_file():
            raise FileError(path, "the file is missing; copy the partitions again")
        data = path.read_bytes()
        if sha256(data).hexdigest() != self._digests[part]:
            raise FileError(path, "SHA-256 differs from what was written; copy the partitions again")
        file = pq.ParquetFile(pa.BufferReader(data))
        for number in range(file.num_row_groups):
            yield file.read_row_group(number, use_threads=False).combine_chunks()


def _table_path(folder: Path, table: str, part: str) -> Path:
    return folder / table / f"{part}.parquet"


def _facts_path(folder: Path, part: str) -> Path:
    return folder / PARTITIONED / f"{part}.json"


def _read_json(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise FileError(path, "the file is missing; copy the partitions again")
    try:
        values: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise FileError(path, f"is damaged ({error}); copy the partitions again") from error
    return values
