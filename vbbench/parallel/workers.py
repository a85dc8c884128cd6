"""Calls done by worker processes, which end when the process that started them does."""

import os
import signal
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.resource_tracker import ensure_running
from typing import Any

from vbbench.errors import VbbenchError
from vbbench.parallel.stopping import REASONS, end_with_parent

JOBS_A_CORE = 8
"""More processes than this only cost memory."""


def check_jobs(jobs: int) -> None:
    """Refuse a number of processes that makes no sense on this machine.

    Raises
    ------
    VbbenchError
        Unless it is 1 to `JOBS_A_CORE` per core, or −1 for one per core.
    """
    most = JOBS_A_CORE * (os.cpu_count() or 1)
    if jobs != -1 and not 1 <= jobs <= most:
        raise VbbenchError(f"jobs is a number of processes: 1 to {most} here, or -1 for one per core, not {jobs}")


def in_parallel(function: Callable[..., Any], calls: Iterable[tuple[Any, ...]], jobs: int) -> Iterator[Any]:
    """The results of ``function`` for each tuple of arguments, in order, made by ``jobs`` processes (−1: one per core).

    Raises
    ------
    VbbenchError
        If a worker dies.
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
        # Workers that grow while they compile are replaced, which is said and loses nothing.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        try:
            with _apart_from_the_terminal():
                results = run(delayed(function)(*call) for call in calls)
            yield from results
        except BrokenProcessPool as error:
            raise VbbenchError(
                "a worker process died (out of memory?); the same command goes on where this one was, "
                "with fewer jobs if need be"
            ) from error


@contextmanager
def _apart_from_the_terminal() -> Iterator[None]:
    """Start processes that leave the signals of a terminal to this one, and clean up after it without a word."""
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
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, REASONS)
