"""Long work done in parts: in parallel, resumable, and with the same bytes for any number of workers.

The work on N sequences is cut into parts of a fixed size. A worker writes its part's tables as Arrow files into a
folder that gets its final name when it is whole; the parts are then appended, in order, to the final tables.
"""

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa

from vbbench.tables import SCHEMAS, TableWriter

PART_SIZE = 16
"""Sequences a part: large enough to outweigh its overhead, small enough that an interruption loses little."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part's row groups (a table a sequence), by table name, and facts about it that go to JSON."""

    groups: dict[str, list[pa.Table]]
    facts: dict[str, Any]


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
    facts = []
    with ExitStack() as stack:
        writers = {name: stack.enter_context(TableWriter(path, name)) for name, path in tables.items()}
        for folder in _make_parts(work, count, parts, jobs, label):
            for name, writer in writers.items():
                for group in _read_groups(folder / f"{name.replace('/', '-')}.arrow"):
                    writer.add(group)
            facts.append(json.loads((folder / "facts.json").read_text("utf-8")))
    shutil.rmtree(parts)
    return facts


def _make_parts(work: Work, count: int, parts: Path, jobs: int, label: str) -> Iterator[Path]:
    from joblib import Parallel, delayed
    from tqdm import tqdm

    ranges = [(first, min(first + PART_SIZE, count)) for first in range(0, count, PART_SIZE)]
    run = Parallel(n_jobs=jobs, return_as="generator", pre_dispatch="4*n_jobs")
    done = run(delayed(_make_part)(work, first, last, parts) for first, last in ranges)
    with tqdm(total=count, desc=label, unit="seq", disable=None) as bar:
        for (first, last), folder in zip(ranges, done, strict=True):
            yield folder
            bar.update(last - first)


def _make_part(work: Work, first: int, last: int, parts: Path) -> Path:
    """Make one part unless it is there; a half-written one is made again."""
    folder = parts / f"{first:08d}"
    if not folder.is_dir():
        part = work(first, last)
        draft = parts / f"{first:08d}.partial"
        shutil.rmtree(draft, ignore_errors=True)
        draft.mkdir()
        for name, groups in part.groups.items():
            _write_groups(draft / f"{name.replace('/', '-')}.arrow", name, groups)
        (draft / "facts.json").write_text(json.dumps(part.facts), encoding="utf-8")
        draft.replace(folder)
    return folder


def _write_groups(path: Path, name: str, groups: list[pa.Table]) -> None:
    with pa.OSFile(str(path), "wb") as file, pa.ipc.new_file(file, SCHEMAS[name]) as writer:
        for group in groups:
            writer.write_table(group)


def _read_groups(path: Path) -> Iterator[pa.Table]:
    with pa.memory_map(str(path)) as file:
        reader = pa.ipc.open_file(file)
        for number in range(reader.num_record_batches):
            yield pa.Table.from_batches([reader.get_batch(number)])
