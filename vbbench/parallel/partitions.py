"""Partitioned datasets and submissions of a cluster: a folder per table, a Parquet file per part.

Next to the tables' folders is the folder ``partitioned``: one JSON file per part, written after all its tables, the
facts of the whole (``dataset.json`` or ``submission.json``), and last of all ``layout.json``.
"""

import json
import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.errors import FileError, VbbenchError
from vbbench.files.cards.writing import write_cards
from vbbench.files.dataset_checks import PUBLIC, TABLES
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo, describe_tables, table_paths
from vbbench.files.sequence_tables import Ranges
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.files.tables import OPTIONAL, TableWriter, table_schema
from vbbench.files.withholding import check_truth_free, truth_folder_of, withhold
from vbbench.folders.replacing import write_bytes_atomically, write_text_atomically
from vbbench.folders.work_folder import PARTITIONED, WorkFolder, check_free, finish_swaps, real
from vbbench.parallel.parts import PackedPart, Work, part_name, progress_bar
from vbbench.parsing.json_text import read_object

LAYOUT_FILE = "layout.json"
SCENES = "scenes"
"""Name of the part with the scenes that sequences share; `part_name` gives the names of the others."""

_ADVICE = "copy the partitions again"
_PART = re.compile(rf"part-\d{{8}}|{SCENES}")
_KNOWN: dict[str, tuple[list[str], list[str]]] = {
    INFO_FILE: ([*PUBLIC], [name for name in TABLES if name not in PUBLIC]),
    SUBMISSION_FILE: (["poses", "positions"], ["heights"]),
}
"""Required and optional tables, by marker."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Contents of a partitioned folder.

    Parameters
    ----------
    marker : ``dataset.json`` or ``submission.json``, the file of its merged form.
    tables : names of the tables of its merged form.
    parts : names of the parts, in order.
    withheld : whether the truth tables go to another folder.
    """

    marker: str
    tables: list[str]
    parts: list[str]
    withheld: bool = False


def write_partitions(work: Work, ranges: Ranges, folder: Path, scheduler: str, *, label: str) -> list[dict[str, Any]]:
    """Do the work on ``ranges`` on a cluster (`cluster.on_cluster`); return every part's facts in order.

    Complete parts in ``folder`` are kept.
    """
    from vbbench.parallel.cluster import on_cluster

    left = [(first, last) for first, last in ranges if not _facts_path(folder, part_name(first)).is_file()]
    sizes = {part_name(first): last - first for first, last in ranges}
    count = sum(sizes.values())
    with progress_bar(count, label, done=count - sum(last - first for first, last in left)) as bar:
        for part in on_cluster(work, left, scheduler) if left else ():
            write_partition(folder, part)
            bar.update(sizes[part.name])
    return [read_object(_facts_path(folder, name), _ADVICE)["facts"] for name in sizes]


def write_partition(folder: Path, part: PackedPart) -> None:
    """Write one part's files; the JSON file that declares it complete comes last."""
    for table, data in part.files.items():
        write_bytes_atomically(_table_path(folder, table, part.name), data)
    digests = {table: sha256(data).hexdigest() for table, data in part.files.items()}
    text = json.dumps({"facts": part.facts, "columns": part.columns, "sha256": digests})
    write_text_atomically(_facts_path(folder, part.name), text)


def write_layout(folder: Path, layout: Layout, facts: str) -> None:
    """Declare a partitioned folder complete; ``facts`` is the text of ``dataset.json`` or ``submission.json``."""
    write_text_atomically(folder / PARTITIONED / layout.marker, facts)
    write_text_atomically(folder / PARTITIONED / LAYOUT_FILE, json.dumps(asdict(layout), indent=2) + "\n")


def read_layout(folder: Path) -> Layout:
    """Read the layout of the partitioned ``folder``; raise VbbenchError if it is not partitioned or is damaged."""
    path = folder / PARTITIONED / LAYOUT_FILE
    finish_swaps(folder)
    if not path.is_file():
        raise VbbenchError(
            f"{folder} is not partitioned; 'vbbench merge' takes what 'generate' and 'solve' make on a cluster"
        )
    try:
        layout = Layout(**read_object(path, _ADVICE))
        problem = _problem(layout)
    except TypeError as error:
        problem = str(error)
    if problem:
        raise FileError(path, f"is damaged ({problem}); {_ADVICE}")
    return layout


def _problem(layout: Layout) -> str | None:
    """The first invalid value of a layout, ``None`` without any; names are checked since they become parts of paths."""
    if not isinstance(layout.marker, str) or layout.marker not in _KNOWN:
        return f"marker is {layout.marker!r}"
    needed, extra = _KNOWN[layout.marker]
    if not _are_names(layout.tables) or not set(needed) <= set(layout.tables) <= {*needed, *extra}:
        return f"tables are {layout.tables!r}"
    if not _are_names(layout.parts) or not all(map(_PART.fullmatch, layout.parts)):
        return f"parts are {layout.parts!r}"
    return None if isinstance(layout.withheld, bool) else f"withheld is {layout.withheld!r}"


def _are_names(values: object) -> bool:
    """Whether a value is a list of distinct texts."""
    return isinstance(values, list) and all(isinstance(v, str) for v in values) and len(set(values)) == len(values)


class PartitionedTable:
    """One table of a partitioned folder, read part by part; every file is checked against its SHA-256."""

    def __init__(self, folder: Path, name: str, parts: Iterable[str]) -> None:
        self._folder, self._name = folder, name
        self._facts = {part: _read_facts(folder, part, name) for part in parts}
        self.columns = {column for columns, _ in self._facts.values() for column in columns}

    def groups(self, part: str) -> Iterable[pa.Table]:
        """The row groups of one part; raises FileError if its file is missing or damaged."""
        columns, digest = self._facts[part]
        if digest is None:
            return
        path = _table_path(self._folder, self._name, part)
        if not path.is_file():
            raise FileError(path, f"the file is missing; {_ADVICE}")
        data = path.read_bytes()
        if sha256(data).hexdigest() != digest:
            raise FileError(path, f"SHA-256 differs from what was written; {_ADVICE}")
        try:
            file = pq.ParquetFile(pa.BufferReader(data))
            if file.schema_arrow != table_schema(self._name, columns):
                raise FileError(path, f"has the columns {file.schema_arrow.names}; {_ADVICE}")
            for number in range(file.num_row_groups):
                yield file.read_row_group(number, use_threads=False).combine_chunks()
        except (pa.ArrowException, OSError) as error:
            raise FileError(path, f"is damaged ({error}); {_ADVICE}") from error


def _read_facts(folder: Path, part: str, table: str) -> tuple[list[str], str | None]:
    """Columns and SHA-256 of a table's file in one part; SHA-256 is ``None`` if the part has no such file."""
    path = _facts_path(folder, part)
    known = read_object(path, _ADVICE)
    columns, digests = known.get("columns"), known.get("sha256")
    if not isinstance(columns, dict) or not isinstance(digests, dict):
        raise FileError(path, f"is damaged (columns or sha256 are missing); {_ADVICE}")
    own, digest = columns.get(table, []), digests.get(table)
    allowed = set(table_schema(table, OPTIONAL.get(table, pa.schema([])).names).names)
    if not _are_names(own) or not set(own) <= allowed or not isinstance(digest, str | None):
        raise FileError(path, f"is damaged (no columns or SHA-256 of {table}); {_ADVICE}")
    return own, digest


def _table_path(folder: Path, table: str, part: str) -> Path:
    return folder / table / f"{part}.parquet"


def _facts_path(folder: Path, part: str) -> Path:
    return folder / PARTITIONED / f"{part}.json"


def merge(folder: Path | str, out: Path | str | None = None, *, overwrite: bool = False) -> Path:
    """Merge the partitions in ``folder`` into complete tables, there or in the folder ``out``; return their folder.

    The same call continues an interrupted merge: partitions are removed only after everything is written.

    Raises VbbenchError if ``folder`` is not partitioned, one of its files is missing or damaged, or ``out`` or the
    truth next to it exists and may not be replaced.

    Parameters
    ----------
    overwrite : replace the dataset or submission that is in ``out``, and the truth next to it.
    """
    folder = Path(folder)
    target = folder if out is None else Path(out)
    in_place = real(target) == real(folder)
    with WorkFolder(target, partial(_check, folder, target, overwrite or in_place, overwrite)) as work:
        if work.begin(f"merge {real(folder)}"):
            layout = read_layout(folder)
            _write_whole(folder, layout, work)
            own = {PARTITIONED, *(Path(name).parts[0] for name in layout.tables)}
            work.publish({path.name for path in folder.iterdir()} - own if in_place else ())
    return target


def _check(folder: Path, target: Path, overwrite: bool, overwrite_truth: bool) -> None:
    layout = read_layout(folder)
    check_free(target, layout.marker, "merged folder", overwrite)
    if layout.withheld:
        check_truth_free(truth_folder_of(target), overwrite_truth)


def _write_whole(folder: Path, layout: Layout, work: WorkFolder) -> None:
    paths = table_paths(layout.tables, work, layout.withheld)
    with progress_bar(len(paths) * len(layout.parts), "merge", unit="file") as bar:
        for name, path in paths.items():
            table = PartitionedTable(folder, name, layout.parts)
            with TableWriter(path, name, table.columns) as writer:
                for part in layout.parts:
                    for group in table.groups(part):
                        writer.add(group)
                    bar.update()
    write_text_atomically(work.new / layout.marker, _facts(folder, layout, paths, work))
    if layout.marker == INFO_FILE:
        write_cards(work.new)


def _facts(folder: Path, layout: Layout, paths: dict[str, Path], work: WorkFolder) -> str:
    """The text of the merged ``dataset.json`` or ``submission.json``."""
    if layout.marker != INFO_FILE:
        return SubmissionInfo.read(folder / PARTITIONED).to_json()
    info = replace(DatasetInfo.read(folder / PARTITIONED), tables=describe_tables(paths))
    return (withhold(info, work.new_truth) if layout.withheld else info).to_json()
