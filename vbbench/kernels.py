"""How inner loops are compiled: by numba, when they are first called, and cached on disk.

Every package compiles with these decorators, so that the rules are the same everywhere. No ``fastmath``: sums are taken
in the order in which they are written, so that results depend neither on the width of vectors nor on the number of
threads, and neighbouring triangles share their edges to the last bit. The cache is beside the source, or in the user's
cache folder where nothing can be written there. ``docs/development.md`` says how to write kernels that compile fast.

Of the core only this module imports numba; who has no kernels does not import it.
"""

import errno
import multiprocessing
import sys
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit
from numba.core import event

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

F = TypeVar("F", bound=Callable[..., Any])

MESSAGE = "compiling kernels, once"
"""What is said on a terminal before the first of them is compiled."""

_functions: set[Callable[..., Any]] = set()


def kernel(function: F) -> F:
    """Compile ``function`` when it is first called; division by zero gives inf or NaN, as in NumPy."""
    return _compiled(function, parallel=False)


def parallel_kernel(function: F) -> F:
    """Compile ``function`` with its ``prange`` loops spread over numba's threads."""
    return _compiled(function, parallel=True)


def _compiled(function: F, *, parallel: bool) -> F:
    _functions.add(function)
    return cast(F, njit(cache=True, error_model="numpy", parallel=parallel)(function))


class _Announcer(event.Listener):  # type: ignore[misc]
    """Hears of every function that is really compiled: what the cache has is no such event."""

    def on_start(self, compiling: Any) -> None:
        """Say so where it is one of ours."""
        if compiling.data["dispatcher"].py_func in _functions:
            _announce()

    def on_end(self, compiling: Any) -> None:
        """Say no more."""


_ANNOUNCER = _Announcer()
event.register("numba:compile", _ANNOUNCER)


def _announce() -> None:
    event.unregister("numba:compile", _ANNOUNCER)
    if sys.stderr is not None and sys.stderr.isatty() and _is_first(sys.stderr.fileno()):
        sys.stderr.write(f"\r\x1b[K{MESSAGE}\n")  # over a progress bar, which is drawn again below
        sys.stderr.flush()


def _is_first(terminal: int) -> bool:
    """Whether no process beside this one has said it: who says it holds a lock on the terminal until it ends."""
    if fcntl is None:
        return multiprocessing.parent_process() is None
    try:
        fcntl.lockf(terminal, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EACCES, errno.EAGAIN)
    return True
