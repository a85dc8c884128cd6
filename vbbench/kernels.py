"""How inner loops are compiled: by numba, when they are first called, and cached on disk.

Every package compiles with these decorators, so that the rules are the same everywhere. No ``fastmath``: sums are taken
in the order in which they are written, so that results depend neither on the width of vectors nor on the number of
threads, and neighbouring triangles share their edges to the last bit. The cache is beside the source, or in the user's
cache folder if nothing can be written there. ``docs/development.md`` explains how to write kernels that compile fast.

Only this module of the core, `vbbench.inner_kernels` and `vbbench.returned_tuples` import numba;
`vbbench.solving.isolation.kernel_cache` does when numba asks it for a cache.
"""

import errno
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

from filelock import lock_descriptor
from numba import njit
from numba.core import event
from numba.core.caching import IndexDataCacheFile
from numba.core.compiler_lock import global_compiler_lock

from vbbench.inner_kernels import leave_inner_kernels_unfinished
from vbbench.kernel_sources import fingerprint

try:  # for a lock of the terminal, which filelock does not have
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

F = TypeVar("F", bound=Callable[..., Any])

MESSAGE = "compiling kernels, once"
"""Printed on a terminal before the first of them is compiled."""

_HOW = fingerprint(__name__)
"""By what rules kernels are compiled: those in a cache that were compiled by others are compiled again."""

_functions: set[Callable[..., Any]] = set()


def kernel(function: F) -> F:
    """Compile ``function`` when it is first called; division by zero gives inf or NaN, as in NumPy."""
    return _compiled(function, parallel=False)


def parallel_kernel(function: F) -> F:
    """Compile ``function`` with its ``prange`` loops spread over numba's threads."""
    return _compiled(function, parallel=True)


def _compiled(function: F, *, parallel: bool) -> F:
    _functions.add(function)
    options: dict[str, Any] = {"error_model": "numpy", "parallel": parallel}
    dispatcher = njit(cache=True, **options)(function)
    file = dispatcher._cache._cache_file
    file.__class__, file._source_stamp = _CacheFile, (fingerprint(function.__module__) or file._source_stamp, _HOW)
    leave_inner_kernels_unfinished(dispatcher)
    dispatcher.compile = _one_process_at_a_time(dispatcher)
    return cast(F, dispatcher)


class _CacheFile(IndexDataCacheFile):  # type: ignore[misc]
    """Numba's cache of a function, with the code saved before the index that names it.

    Numba writes the index first: a process that is killed after that leaves an index whose name refers to code of an
    older version of the source, which the next process would run. An older version's index may also name classes that
    have moved since: a cache that cannot be read counts as empty, and its function is compiled again.
    """

    def load(self, key: Any) -> Any:
        """The code of one signature; ``None`` where there is none that can be read."""
        try:
            return super().load(key)
        except Exception:  # whatever unpickling raises
            return None

    def _load_index(self) -> dict[Any, str]:
        try:
            index: dict[Any, str] = super()._load_index()
        except Exception:
            return {}
        return index

    def save(self, key: Any, data: Any) -> None:
        """Save the code of one signature, in one process at a time."""
        index = self._load_index()
        name = index.get(key) or self._data_name(1 + len(index))
        self._save_data(name, data)
        self._save_index({**index, key: name})


def _one_process_at_a_time(dispatcher: Any) -> Callable[[Any], Any]:
    """A dispatcher's ``compile`` with which one of several processes compiles a function and the others load it."""
    compile_here = dispatcher.compile

    @wraps(compile_here)
    def compile_or_load(signature: Any) -> Any:
        with global_compiler_lock, _alone(Path(dispatcher.stats.cache_path), dispatcher.py_func):
            return compile_here(signature)

    return compile_or_load


_held: set[Path] = set()
"""Locks that this process holds: a recursive function compiles itself while it is compiled."""


@contextmanager
def _alone(folder: Path, function: Callable[..., Any]) -> Iterator[None]:
    """Keep other processes from compiling a function, if there are locks and the folder is writable."""
    path = folder / f"{Path(function.__code__.co_filename).stem}.{function.__qualname__}.lock"
    handle = None
    if path not in _held:
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            lock_descriptor(handle)
    if handle is None:
        yield
        return
    _held.add(path)
    try:
        yield
    finally:
        _held.discard(path)
        os.close(handle)


class _Announcer(event.Listener):  # type: ignore[misc]
    """Is notified of every function that is compiled rather than loaded from the cache."""

    def on_start(self, compiling: Any) -> None:
        if compiling.data["dispatcher"].py_func in _functions:
            _announce()

    def on_end(self, compiling: Any) -> None:
        """Required by numba."""


_ANNOUNCER = _Announcer()
event.register("numba:compile", _ANNOUNCER)


def _announce() -> None:
    event.unregister("numba:compile", _ANNOUNCER)
    terminal = sys.__stderr__  # also where a worker's progress is not shown
    if terminal is not None and terminal.isatty() and _is_first(terminal.fileno()):
        terminal.write(f"\r\x1b[K{MESSAGE}\n")  # over a progress bar, which is drawn again below
        terminal.flush()


def _is_first(terminal: int) -> bool:
    """Whether no other process has printed it: the first holds a lock on the terminal until it ends."""
    if fcntl is None:
        return multiprocessing.parent_process() is None
    try:
        fcntl.lockf(terminal, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EACCES, errno.EAGAIN)
    return True
