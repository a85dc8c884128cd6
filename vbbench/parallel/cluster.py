"""Runs parts of work on a Dask cluster by its public client; every result crosses the network, no disk is shared.

`distributed` is the optional dependency ``vbbench[dask]``; it is imported where it is needed.
"""

import logging
import os
import pickle
import platform
import re
import sys
import threading
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from itertools import islice
from typing import Any

from vbbench.errors import VbbenchError, needs_extra
from vbbench.parallel.parts import Work, packed

PATIENCE = 10
"""Seconds to wait for the scheduler, and for a first worker."""

PARTS_A_CORE = 3
"""Parts per core that are sent ahead: the most results, of about 1 MB each, that wait to be written."""

TELLINGS = 5
"""Times that the work is sent to all workers, if some leave meanwhile."""

PACKAGES = ("vbbench", "numpy", "scipy")
"""Packages that results may depend on: all workers must have the same versions."""

ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?[^\s/]+:\d+/?")
"""The form of a scheduler's address; with any other Dask would wait, and then show a traceback."""

PackedPart = tuple[int, int, bytes]
"""First and last of the sequences of a part, and the content of its file (`parts.packed`)."""

_opened = threading.local()


def on_cluster(work: Work, ranges: Sequence[tuple[int, int]], scheduler: str) -> Iterator[PackedPart]:
    """Do the work on ranges of sequences, in any order; yields each range's first and last, and its part as a file.

    Raises VbbenchError if there is no such cluster, its workers run other versions, or too many of them were lost.

    Parameters
    ----------
    scheduler : address; ``tls://`` is encrypted with the certificates of Dask's own settings.
    """
    with _client(scheduler) as client, _plain_errors(scheduler), _published(client, work) as name:
        _check_workers(client)
        yield from _results(client, partial(_run_part, name, versions()), ranges)


def _results(client: Any, run: Callable[[int, int], PackedPart], ranges: Iterable[tuple[int, int]]) -> Iterator[Any]:
    """The results of ``run`` for the ranges, in any order; workers that join later get work, too."""
    from distributed import as_completed
    from distributed.comm import CommClosedError

    left, running = iter(ranges), as_completed(loop=client.loop)

    def send() -> None:
        try:
            cores = sum(client.ncores().values())
        except OSError as error:  # the scheduler does not answer again
            raise CommClosedError(str(error)) from error
        missing = PARTS_A_CORE * max(1, cores) - running.count()
        running.update([client.submit(run, *one, pure=False) for one in islice(left, max(0, missing))])

    send()
    for future in running:
        yield future.result()
        send()


def versions() -> dict[str, str]:
    """Versions of Python and of `PACKAGES`."""
    found = {"Python": ".".join(platform.python_version_tuple()[:2])}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "missing"
    return found


@contextmanager
def _client(scheduler: str) -> Iterator[Any]:
    with needs_extra("dask", "a cluster"):
        from distributed import Client
    if not ADDRESS.fullmatch(scheduler):
        raise VbbenchError(f"a scheduler is an address such as tcp://127.0.0.1:8786, not '{scheduler}'")
    with _silence():
        try:
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
        except RuntimeError as error:  # Dask refuses
            raise VbbenchError(
                f"{scheduler} is not encrypted, as Dask's settings demand; give a tls:// address"
            ) from error
        except (OSError, ValueError, TypeError) as error:
            known = "it knows the certificates of Dask's settings (docs/scale.md)"
            start = "start one with 'dask scheduler' and give the address it prints"
            advice = f"check that {known}" if scheduler.startswith("tls://") else start
            raise VbbenchError(f"no Dask scheduler answers at {scheduler}; {advice}") from error
        with client:
            try:
                client.wait_for_workers(1, timeout=PATIENCE)
            except TimeoutError as error:
                raise VbbenchError(
                    f"the Dask scheduler at {scheduler} has no workers; start some with 'dask worker {scheduler}'"
                ) from error
            yield client


@contextmanager
def _silence() -> Iterator[None]:
    """Hide Dask's logs about lost connections, which `_plain_errors` reports in one line."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "tornado.application")]
    levels = {logger: logger.level for logger in loggers}
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


@contextmanager
def _plain_errors(scheduler: str) -> Iterator[None]:
    """Report failures of a cluster in one line."""
    from asyncio import CancelledError

    from distributed import KilledWorker
    from distributed.client import FutureCancelledError
    from distributed.comm import CommClosedError
    from distributed.scheduler import NoValidWorkerError, NoWorkerError

    after = "finished parts are kept; run the same command again for the others"
    try:
        yield
    except KilledWorker as error:
        raise VbbenchError(
            f"cluster {scheduler}: one part's workers died again and again (out of memory?); {after}"
        ) from error
    except (NoValidWorkerError, NoWorkerError) as error:
        raise VbbenchError(f"cluster {scheduler}: no workers are left; {after}") from error
    except (FutureCancelledError, CancelledError, CommClosedError) as error:
        raise VbbenchError(f"cluster {scheduler}: the scheduler was lost; {after}") from error


@contextmanager
def _published(client: Any, work: Work) -> Iterator[str]:
    """Send the work to every worker once, also to those that join later; tasks refer to it by this name.

    If a worker leaves meanwhile, Dask's call fails, and the work is sent to the others again.
    """
    from distributed import WorkerPlugin
    from distributed.protocol.pickle import dumps

    class Published(WorkerPlugin):  # type: ignore[misc]
        """Holds the work, and makes solvers in the user's current folder importable."""

        def __init__(self, work: bytes, place: str) -> None:
            self.work, self.place = work, place

        def setup(self, worker: Any) -> None:  # noqa: ARG002
            sys.path.append(self.place)

        def teardown(self, worker: Any) -> None:  # noqa: ARG002
            sys.path.remove(self.place)

    name = f"vbbench-{uuid.uuid4().hex}"
    published = Published(dumps(work), os.getcwd())  # noqa: PTH109
    for further in reversed(range(TELLINGS)):
        try:
            client.register_plugin(published, name=name)
            break
        except OSError:
            if not further:
                raise
    try:
        yield name
    finally:
        if client.status == "running":
            with suppress(OSError):  # what is no longer there has nothing to forget
                client.unregister_worker_plugin(name)


def _check_workers(client: Any) -> None:
    """Raise VbbenchError if a worker lacks vbbench, or has other versions, before any work is done.

    A worker that leaves during the check is ignored.
    """
    for worker, answer in client.run(_differences, versions(), on_error="return").items():
        if isinstance(answer, OSError):
            continue
        if isinstance(answer, BaseException):
            raise VbbenchError(f"worker {worker} cannot run vbbench: {answer}; install the same version there")
        if answer:
            raise VbbenchError(f"worker {worker} {answer}")


def _differences(wanted: dict[str, str]) -> str:
    """The differences of this worker's versions from the client's, as the end of a sentence."""
    here = versions()
    differing = [f"{name} {here[name]} (here {wanted[name]})" for name in wanted if here[name] != wanted[name]]
    return f"has {', '.join(differing)}; results might differ: install the same versions" if differing else ""


def _run_part(name: str, wanted: dict[str, str], first: int, last: int) -> PackedPart:
    """Compute one part on a worker; checks its versions, since it may have joined late."""
    from distributed import get_worker

    worker = get_worker()
    problem = _differences(wanted)
    if problem:
        raise VbbenchError(f"worker {worker.address} {problem}")
    if getattr(_opened, "name", None) != name:  # a thread keeps its own: open tables are not to be shared
        _opened.work, _opened.name = pickle.loads(worker.plugins[name].work), name  # noqa: S301
    return first, last, packed(_opened.work(first, last))
