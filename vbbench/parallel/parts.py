"""Long work in parts: parallel, resumable, and with the same bytes for any number of workers.

The work on N sequences is divided into parts of a fixed number of sequences, or fewer if these are large, so that
workers and the writer of the tables need only some megabytes each. A worker writes its part's tables, one Arrow stream
after the other, into a file that is renamed when it is complete; one of a cluster sends them, and the file is written
here. The tables are then written from the parts in order.
The division depends on the work alone, and is visible only as row groups of ``sequences``, one per part.
"""

import json
import os
import signal
import sys
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, redirect_stderr
from dataclasses import dataclass
from functools import partial
from io import StringIO
from itertools import chain, islice
from multiprocessing.resource_tracker import ensure_running
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, NoReturn

import pyarrow as pa

from vbbench.errors import VbbenchError, plain_errors
from vbbench.files.sequence_tables import Ranges
from vbbench.files.tables import OPTIONAL, TableWriter, table_schema, with_columns
from vbbench.folders.replacing import write_bytes_atomically
from vbbench.parallel.stopping import HAS_SIGNALS, REASONS, end_with_parent

if TYPE_CHECKING:
    from tqdm import tqdm

PATIENCE = 5.0
"""Seconds of work that an interruption may cost: parts made in this process within that time are not saved to files."""

BYTES_IN_MEMORY = 1 << 26
"""Bytes of parts that are kept in memory; further parts are saved to files at once."""

JOBS_A_CORE = 8
"""Most processes per core: more only cost memory."""

_END = b"\xff\xff\xff\xff\0\0\0\0"
"""Last bytes of a complete Arrow stream."""

NAME, FACTS, COLUMNS = b"name", b"facts", b"columns"
"""Keys of the table's name, the part's facts and its columns in the metadata of a part's streams."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part's row groups (one table per sequence), by table name, and facts about it that go to JSON."""

    groups: dict[str, list[pa.Table]]
    facts: dict[str, Any]

    @property
    def columns(self) -> dict[str, set[str]]:
        """The columns of each table's row groups."""
        tables = self.groups.items()
        return {name: {column for group in groups for column in group.column_names} for name, groups in tables}

    @property
    def nbytes(self) -> int:
        """Approximate size of its row groups in memory, in bytes."""
        return sum(sum(map(len, groups)) * _row_bytes(groups[0].schema) for groups in self.groups.values() if groups)


def packed(part: Part) -> bytes:
    """The content of a part's file, compressed for the network."""
    sink = pa.BufferOutputStream()
    _write_streams(part, sink, pa.ipc.IpcWriteOptions(compression="zstd"))
    content: bytes = sink.getvalue().to_pybytes()
    return content


def _row_bytes(schema: pa.Schema) -> int:
    return sum(field.type.bit_width // 8 if pa.types.is_primitive(field.type) else 16 for field in schema)


Work = Callable[[int, int], Part]
"""Makes the part of sequences first ≤ index < last."""


class _LogLines:
    """Stderr as a stream for a progress bar without a terminal: each state of the bar is a line."""

    def write(self, text: str) -> None:
        if line := text.strip():
            sys.stderr.write(line + "\n")

    def flush(self) -> None:
        sys.stderr.flush()


SILENCE = 60.0
"""Seconds between two lines of progress where stderr is no terminal."""


def progress_bar(total: int | None, label: str | None, *, done: int = 0, unit: str = "seq") -> "tqdm[NoReturn]":
    """A progress bar on stderr; without a terminal, a line per minute after the first."""
    from tqdm import tqdm

    bar = partial(tqdm, total=total, initial=done, desc=label, unit=unit, unit_scale=unit == "B")
    if sys.stderr.isatty():
        return bar()
    return bar(file=_LogLines(), delay=SILENCE, mininterval=SILENCE, maxinterval=SILENCE, ncols=0, leave=False)


@contextmanager
def without_bars() -> Iterator[None]:
    """Draw no bars in the block, where those of several processes would overlap; messages are printed at its end."""
    said = StringIO()
    with redirect_stderr(said):
        yield
    sys.stderr.write(said.getvalue())


def write_in_parts(
    work: Work,
    ranges: Ranges,
    parts: Path,
    tables: dict[str, Path],
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    label: str,
) -> list[dict[str, Any]]:
    """Do the work on ``ranges`` and write ``tables`` (path by name); return every part's facts in order.

    The work is done by ``jobs`` processes, or on the Dask cluster at ``scheduler`` (`cluster.on_cluster`). Complete
    parts in the folder ``parts`` are kept. A table gets an optional column if any part has it. The first table
    is written while parts are computed, the others after it, one by one, since open tables keep footers in memory.
    """
    if scheduler is not None:
        _make_on_cluster(work, ranges, parts, scheduler, label)
        jobs, label = 1, "tables"  # nothing is left to do but to write them
    make = partial(_make_part, work, parts)
    made = _make_here(make, ranges) if jobs == 1 else in_parallel(partial(make, keep=True), ranges, jobs)
    parts_made: list[Part | Path] = []
    (first, path), *others = tables.items()
    with progress_bar(ranges[-1][1] if ranges else 0, label) as bar:
        arriving = _noted(zip(ranges, made, strict=True), parts_made, bar)
        opening = list(islice(arriving, 1))
        columns = _optional(first, opening)
        _write_table(path, first, columns, chain(opening, arriving))
    if _optional(first, parts_made) != columns:  # a later part has others
        others.append((first, path))
    with progress_bar(len(others) * len(parts_made), "tables", unit="part") as bar:
        for name, path in others:
            _write_table(path, name, _optional(name, parts_made), _counted(parts_made, bar))
    return [part.facts if isinstance(part, Part) else _metadata(part, FACTS) for part in parts_made]


def _noted(
    made: Iterable[tuple[tuple[int, int], Part | Path]], parts_made: list[Part | Path], bar: Any
) -> Iterator[Part | Path]:
    """The parts as they arrive; appends each to ``parts_made``."""
    for (first, last), part in made:
        parts_made.append(part)
        bar.update(last - first)
        yield part


def _counted(parts_made: Iterable[Part | Path], bar: Any) -> Iterator[Part | Path]:
    for part in parts_made:
        yield part
        bar.update()


def _write_table(path: Path, name: str, optional: Collection[str], parts_made: Iterable[Part | Path]) -> None:
    with TableWriter(path, name, optional) as writer:
        for part in parts_made:
            for group in _groups(part, name):
                writer.add(group)


def _optional(name: str, parts_made: Iterable[Part | Path]) -> set[str]:
    """The optional columns that a table has in any of the parts."""
    if name not in OPTIONAL:
        return set()
    columns = (part.columns if isinstance(part, Part) else _metadata(part, COLUMNS) for part in parts_made)
    return {column for one in columns for column in one.get(name, ())}


def _metadata(path: Path, key: bytes) -> dict[str, Any]:
    """Metadata of a part from its file, in which every stream repeats them."""
    with pa.memory_map(str(path)) as file:
        values: dict[str, Any] = json.loads(pa.ipc.open_stream(file).schema.metadata[key])
    return values


def _make_on_cluster(work: Work, ranges: Ranges, parts: Path, scheduler: str, label: str) -> None:
    """Have a cluster compute the parts whose files are not complete, and write each as it comes."""
    from vbbench.parallel.cluster import on_cluster

    left = [(first, last) for first, last in ranges if not _is_whole(_part_file(parts, first, last))]
    count = sum(last - first for first, last in ranges)
    with progress_bar(count, label, done=count - sum(last - first for first, last in left)) as bar:
        for first, last, content in on_cluster(work, left, scheduler) if left else ():
            write_bytes_atomically(_part_file(parts, first, last), content)
            bar.update(last - first)


def _part_file(parts: Path, first: int, last: int) -> Path:
    return parts / f"{first:08d}-{last:08d}.arrows"


def _make_here(make: Callable[..., Part | Path], ranges: Ranges) -> Iterator[Part | Path]:
    started, held = perf_counter(), 0
    for first, last in ranges:
        part = make(first, last, keep=held > BYTES_IN_MEMORY or perf_counter() - started > PATIENCE)
        held += part.nbytes if isinstance(part, Part) else 0
        yield part


def _make_part(work: Work, parts: Path, first: int, last: int, *, keep: bool) -> Part | Path:
    """Compute one part unless its file is complete; a power cut may have truncated it."""
    path = _part_file(parts, first, last)
    if _is_whole(path):
        return path
    part = work(first, last)
    if not keep:
        return part
    draft = path.with_suffix(".half")
    with plain_errors(path), pa.OSFile(str(draft), "wb") as file:
        _write_streams(part, file)
    draft.replace(path)
    return path


def _is_whole(path: Path) -> bool:
    if not path.is_file() or path.stat().st_size < len(_END):
        return False
    with path.open("rb") as file:
        file.seek(-len(_END), os.SEEK_END)
        return file.read() == _END


def _write_streams(part: Part, file: pa.NativeFile, options: pa.ipc.IpcWriteOptions | None = None) -> None:
    columns = part.columns
    common = {FACTS: json.dumps(part.facts), COLUMNS: json.dumps({name: sorted(c) for name, c in columns.items()})}
    for name, groups in part.groups.items():
        schema = table_schema(name, columns[name])
        with pa.ipc.new_stream(file, schema.with_metadata({NAME: name, **common}), options=options) as stream:
            for group in groups:
                stream.write_table(with_columns(group, schema))


def _groups(part: Part | Path, name: str) -> Iterator[pa.Table]:
    """The row groups of one table of a part."""
    if isinstance(part, Part):
        yield from part.groups.get(name, ())
        return
    with pa.memory_map(str(part)) as file:
        while file.tell() < file.size():
            stream = pa.ipc.open_stream(file)
            for batch in stream:
                if stream.schema.metadata[NAME] == name.encode():
                    yield pa.Table.from_batches([batch]).replace_schema_metadata()


def check_jobs(jobs: int) -> None:
    """Raise VbbenchError unless ``jobs`` is 1 to `JOBS_A_CORE` per core, or −1 for one process per core."""
    most = JOBS_A_CORE * (os.cpu_count() or 1)
    if jobs != -1 and not 1 <= jobs <= most:
        raise VbbenchError(f"jobs is a number of processes: 1 to {most} here, or -1 for one per core, not {jobs}")


def processes_of(jobs: int) -> int:
    """The number of processes for ``jobs``; raises what `check_jobs` raises."""
    check_jobs(jobs)
    return (os.cpu_count() or 1) if jobs == -1 else jobs


def in_parallel(function: Callable[..., Any], calls: Iterable[tuple[Any, ...]], jobs: int) -> Iterator[Any]:
    """The results of ``function`` for each tuple of arguments, in order, from ``jobs`` processes (−1: one per core).

    Raises VbbenchError if a worker dies.
    """
    from joblib import Parallel, delayed

    check_jobs(jobs)
    run = Parallel(
        n_jobs=jobs,
        backend="loky",
        return_as="generator",
        pre_dispatch="4*n_jobs",
        initializer=_start_worker,
        initargs=(os.getpid(),),
    )
    with warnings.catch_warnings():
        # Workers that grow are replaced, which loses nothing.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        try:
            with _apart_from_the_terminal():
                results = run(delayed(function)(*call) for call in calls)
            yield from results
        except BrokenProcessPool as error:
            raise VbbenchError(
                "a worker process died (out of memory?); run the same command again to continue, "
                "with fewer jobs if necessary"
            ) from error


@contextmanager
def _apart_from_the_terminal() -> Iterator[None]:
    """Start processes that ignore the terminal's signals, and whose clean-up is silent."""
    if not HAS_SIGNALS:
        yield
        return
    kept = os.environ.get("PYTHONWARNINGS")
    quiet = "ignore:resource_tracker:UserWarning"  # of what a process that was killed could not remove itself
    before = signal.pthread_sigmask(signal.SIG_BLOCK, REASONS)
    os.environ["PYTHONWARNINGS"] = f"{kept},{quiet}" if kept else quiet
    try:
        ensure_running()
        signal.pthread_sigmask(signal.SIG_BLOCK, REASONS)  # Python 3.11 let them through when it had started that
        yield
    finally:
        if kept is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = kept
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_worker(parent: int) -> None:
    end_with_parent(parent)
    for number in REASONS.keys() - {signal.SIGTERM}:
        signal.signal(number, signal.SIG_IGN)
    if HAS_SIGNALS:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, REASONS)
