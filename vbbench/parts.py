"""Long work done in parts: in parallel, resumable, and with the same bytes for any number of workers.

The work on N sequences is cut into parts of a fixed size. A worker writes its part's tables, one Arrow stream after the
other, into a file that gets its final name when it is whole; the parts are then appended, in order, to the tables.
"""

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pyarrow as pa

from vbbench.tables import SCHEMAS, TableWriter

PART_SIZE = 32
"""Sequences a part: large enough to outweigh its overhead, small enough that an interruption loses little."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part's row groups (a table a sequence), by table name, and facts about it that go to JSON."""

    groups: dict[str, list[pa.Table]]
    facts: dict[str, Any]


FACTS = b"facts"
"""Key of the facts in the metadata of a part's streams."""

Work = Callable[[int, int], Part]
"""Makes the part of sequences first ≤ index < last."""


def prepare_parts(folder: Path, key: str) -> None:
    """Make ``folder`` ready; parts of the same work (the same key) are kept, those of any other are removed."""
    key_file = folder / "key"
    if not (key_file.is_file() and key_file.read_text("utf-8") == key):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        key_file.write_text(key, encoding="utf-8")


def write_in_parts(
    work: Work, count: int, parts: Path, tables: dict[str, Path], *, jobs: int = 1, label: str
) -> list[dict[str, Any]]:
    """Do the work on sequences 0 … count − 1 and write ``tables`` (path by name); return every part's facts in order.

    Parts found whole in the folder ``parts`` are not made again.
    """
    make = partial(_make_part, work, list(tables), parts)
    with ExitStack() as stack:
        writers = {name: stack.enter_context(TableWriter(path, name)) for name, path in tables.items()}
        facts = [_append_part(file, writers) for file in _make_parts(make, count, jobs, label)]
    shutil.rmtree(parts)
    return facts


def _make_parts(make: Callable[[int, int], Path], count: int, jobs: int, label: str) -> Iterator[Path]:
    from joblib import Parallel, delayed
    from tqdm import tqdm

    ranges = [(first, min(first + PART_SIZE, count)) for first in range(0, count, PART_SIZE)]
    run = Parallel(n_jobs=jobs, return_as="generator", pre_dispatch="4*n_jobs")
    done = run(delayed(make)(first, last) for first, last in ranges)
    with tqdm(total=count, desc=label, unit="seq", disable=None) as bar:
        for (first, last), file in zip(ranges, done, strict=True):
            yield file
            bar.update(last - first)


def _make_part(work: Work, names: list[str], parts: Path, first: int, last: int) -> Path:
    """Make one part unless it is there; a half-written one is made again."""
    path = parts / f"{first:08d}.arrows"
    if not path.is_file():
        part = work(first, last)
        draft = path.with_suffix(".partial")
        with pa.OSFile(str(draft), "wb") as file:
            for name in names:
                schema = SCHEMAS[name].with_metadata({FACTS: json.dumps(part.facts)})
                with pa.ipc.new_stream(file, schema) as stream:
                    for group in part.groups[name]:
                        stream.write_table(group)
        draft.replace(path)
    return path


def _append_part(path: Path, writers: dict[str, TableWriter]) -> dict[str, Any]:
    """Append a part's row groups to the tables, in the order of writing, and return its facts."""
    facts: dict[str, Any] = {}
    with pa.memory_map(str(path)) as file:
        for writer in writers.values():
            stream = pa.ipc.open_stream(file)
            facts = json.loads(stream.schema.metadata[FACTS])
            for batch in stream:
                writer.add(pa.Table.from_batches([batch]).replace_schema_metadata())
    return facts
