"""Runs parts of work on a Dask cluster through joblib; every result crosses the network, no disk is shared.

`distributed` is the optional dependency ``vbbench[dask]``; it is imported where it is needed.
"""

import logging
import os
import pickle
import platform
import re
import ssl
import sys
import threading
import uuid
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from joblib._dask import DaskDistributedBackend

from vbbench.errors import FileError, VbbenchError, needs_extra
from vbbench.parallel.parts import PackedPart, Work, pack, part_name

PATIENCE = 10
"""Seconds to wait for the scheduler, and for a first worker."""

PARTS_A_CORE = 16
"""Parts per core that are sent at a time: the most results, of about 1 MB each, that wait here to be written."""

TELLINGS = 5
"""Times that the work is sent to all workers, if some leave meanwhile."""

PACKAGES = ("vbbench", "numpy", "scipy")
"""Packages that results may depend on: all workers must have the same versions."""

CERTIFICATES = {"tls_ca_file": "ca.pem", "tls_client_cert": "cert.pem", "tls_client_key": "key.pem"}
"""The files in a folder of certificates, by Dask's name for them."""
_CERTIFICATE_FILES = "{}, {} and {}".format(*CERTIFICATES.values())

ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?[^\s/]+:\d+/?")
"""The form of a scheduler's address; with any other Dask would wait, and then show a traceback."""

_opened = threading.local()


def on_cluster(
    work: Work, ranges: Sequence[tuple[int, int]], scheduler: str, tls: Path | None = None
) -> Iterator[PackedPart]:
    """Do the work on ranges of sequences, in any order.

    Parameters
    ----------
    scheduler : address; ``tls://`` is encrypted.
    tls : folder of the certificates that a ``tls://`` address needs (`CERTIFICATES`).

    Raises
    ------
    VbbenchError
        If there is no such cluster, its workers run other versions, too many of them were lost, or address and
        certificates do not go together.
    """
    with _client(scheduler, tls) as client, _plain_errors(scheduler), _published(client, work) as name:
        _check_workers(client)
        make, left = delayed(partial(_run_part, name, versions())), list(ranges)
        while left:
            size = PARTS_A_CORE * max(1, sum(client.ncores().values()))
            now, left = left[:size], left[size:]
            with parallel_config(backend=_Backend(client=client)):
                run = Parallel(return_as="generator_unordered", batch_size=1, pre_dispatch="3*n_jobs")
                yield from run(make(first, last) for first, last in now)


def versions() -> dict[str, str]:
    """Versions of Python and of `PACKAGES`."""
    found = {"Python": ".".join(platform.python_version_tuple()[:2])}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "missing"
    return found


class _Backend(DaskDistributedBackend):  # type: ignore[misc]
    """joblib's own backend waits for ever for a part that the cluster gave up; this one learns of the failure.

    It also uses a cluster of one core, whose work joblib would do in this process.
    """

    def submit(self, func: Any, callback: Any = None) -> Any:
        future = super().submit(func, callback)
        future.add_done_callback(partial(_report_failure, callback))
        return future

    def retrieve_result_callback(self, out: Any) -> Any:
        if isinstance(out, BaseException):
            raise out
        return super().retrieve_result_callback(out)

    def effective_n_jobs(self, n_jobs: int = -1) -> int:
        cores: int = super().effective_n_jobs(n_jobs)
        return max(2, cores)


def _report_failure(callback: Any, future: "Future[Any]") -> None:
    error = future.exception()
    if error is not None:
        callback(error)


@contextmanager
def _client(scheduler: str, tls: Path | None) -> Iterator[Any]:
    with needs_extra("dask", "a cluster"):
        from distributed import Client
    if not ADDRESS.fullmatch(scheduler):
        raise VbbenchError(f"a scheduler is an address such as tcp://127.0.0.1:8786, not '{scheduler}'")
    security = _security(scheduler, tls)
    with _silence():
        try:
            client = Client(scheduler, timeout=PATIENCE, set_as_default=False, security=security)
        except (OSError, ValueError, TypeError) as error:
            if isinstance(error.__cause__, ssl.SSLError):
                raise VbbenchError(f"{tls}: the scheduler at {scheduler} has other certificates") from error
            raise VbbenchError(
                f"no Dask scheduler answers at {scheduler}; "
                "start one with 'dask scheduler' and give the address it prints"
            ) from error
        with client:
            try:
                client.wait_for_workers(1, timeout=PATIENCE)
            except TimeoutError as error:
                raise VbbenchError(
                    f"the Dask scheduler at {scheduler} has no workers; start some with 'dask worker {scheduler}'"
                ) from error
            yield client


def _security(scheduler: str, tls: Path | None) -> Any:
    """Dask's security settings; ``None`` without encryption, otherwise unencrypted connections are refused."""
    from distributed import Security

    encrypted = scheduler.startswith("tls://")
    if tls is None:
        if encrypted:
            raise VbbenchError(f"{scheduler} needs certificates: name the folder that holds {_CERTIFICATE_FILES} (tls)")
        return None
    if not encrypted:
        raise VbbenchError(f"certificates are for an address tls://HOST:PORT, and {scheduler} is not encrypted")
    files = {role: tls / name for role, name in CERTIFICATES.items()}
    for path in files.values():
        if not path.is_file():
            raise FileError(path, f"the file is missing; a folder of certificates holds {_CERTIFICATE_FILES}")
    security = Security(require_encryption=True, **{role: str(path) for role, path in files.items()})
    try:
        security.get_connection_args("client")
    except OSError as error:
        raise VbbenchError(f"{tls}: the certificates cannot be used ({error}); make them again") from error
    return security


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

    A worker that leaves meanwhile makes Dask's call fail: the work is sent to the others again.
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

    A worker that left while it was asked gets no work, and is no reason to stop.
    """
    for worker, answer in client.run(_differences, versions(), on_error="return").items():
        if isinstance(answer, OSError):
            continue
        if isinstance(answer, BaseException):
            raise VbbenchError(f"worker {worker} cannot run vbbench: {answer}; install the same version there")
        if answer:
            raise VbbenchError(f"worker {worker} {answer}")


def _differences(wanted: dict[str, str]) -> str:
    """What differs here from the client's versions, as the end of a sentence."""
    here = versions()
    differing = [f"{name} {here[name]} (here {wanted[name]})" for name in wanted if here[name] != wanted[name]]
    return f"has {', '.join(differing)}; results might differ: install the same versions" if differing else ""


def _run_part(name: str, wanted: dict[str, str], first: int, last: int) -> PackedPart:
    """Make one part on a worker, which may have joined after the others were checked."""
    from distributed import get_worker

    worker = get_worker()
    problem = _differences(wanted)
    if problem:
        raise VbbenchError(f"worker {worker.address} {problem}")
    if getattr(_opened, "name", None) != name:  # a thread keeps its own: open tables are not to be shared
        _opened.work, _opened.name = pickle.loads(worker.plugins[name].work), name  # noqa: S301
    return pack(_opened.work(first, last), part_name(first))
