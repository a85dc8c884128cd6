"""A real scheduler and real workers, some of them killed: nothing is lost, nothing is there twice."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pandas as pd
import pytest

from tests.generation.test_datasets import digests
from tests.lib.commands import ended, start, wait_until
from tests.lib.slow_split import BEFORE_THE_GATE, GATE
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.parallel import cluster
from vbbench.parallel.parts import Part
from vbbench.reproduction.grid import Making
from vbbench.solving import solve

pytest.importorskip("distributed", reason="needs the extra dask")
pytestmark = pytest.mark.extra

SPLIT = "tests.lib.slow_split:SLOW"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def reachable(address: str) -> bool:
    with suppress(OSError), socket.create_connection(("127.0.0.1", int(address.rpartition(":")[2])), 1):
        return True
    return False


class Cluster:
    """A scheduler that forgives a task two deaths, and its workers; no nanny brings a killed one back.

    Its workers wait at the gate of the slow split until that is opened.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self._started, self.gate = folder, 0, folder / "gate"
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self.workers: list[subprocess.Popen[bytes]] = []
        port = self.address.rpartition(":")[2]
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", port)
        wait_until(lambda: reachable(self.address))

    def _start(self, *command: str) -> "subprocess.Popen[bytes]":
        settings = {"ALLOWED_FAILURES": "2", "NO_WORKERS_TIMEOUT": "1s"}
        environment = os.environ | {f"DASK_DISTRIBUTED__SCHEDULER__{key}": value for key, value in settings.items()}
        self._started += 1
        with (self._folder / f"{self._started}.log").open("wb") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", *command, "--no-dashboard"],
                stdout=log,
                stderr=log,
                env=environment | {GATE: str(self.gate)},
                cwd=self._folder,
            )

    def worker(self) -> "subprocess.Popen[bytes]":
        """One more."""
        options = ["--no-nanny", "--nthreads", "1", "--memory-limit", "1GiB", "--local-directory", "scratch"]
        return self._start("worker", self.address, *options)

    def of(self, count: int) -> str:
        """The address, when so many workers, or more, are there; one that ends meanwhile is replaced."""
        self._fill(count)
        with cluster._client(self.address) as client:
            wait_until(lambda: self._fill(count) and len(client.scheduler_info(n_workers=-1)["workers"]) >= count)
        return self.address

    def _fill(self, count: int) -> bool:
        """Start as many workers as are missing; true if none was."""
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        missing = count - len(self.workers)
        self.workers += [self.worker() for _ in range(missing)]
        return missing <= 0

    def close_gate(self) -> None:
        for path in (self.gate, self.gate.with_name("gate.reached")):
            path.unlink(missing_ok=True)

    def open_gate(self) -> None:
        self.gate.touch()

    def stop(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@contextmanager
def started(folder: Path) -> Iterator[Cluster]:
    running = Cluster(folder)
    try:
        yield running
    finally:
        running.stop()


@pytest.fixture(scope="module", autouse=True)
def patience() -> Iterator[None]:
    """A scheduler may take its time on a machine that is busy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cluster, "PATIENCE", 120)
        yield


@pytest.fixture(scope="module")
def shared_cluster(tmp_path_factory: pytest.TempPathFactory, patience: None) -> Iterator[Cluster]:
    with started(tmp_path_factory.mktemp("cluster")) as running:
        yield running


@pytest.fixture
def dask(shared_cluster: Cluster) -> Iterator[Cluster]:
    """The cluster, its gate closed; whoever still waits there is let through in the end."""
    shared_cluster.close_gate()
    yield shared_cluster
    shared_cluster.open_gate()


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate(SPLIT, tmp_path_factory.mktemp("single") / "slow", Options())


def finished_parts(out: Path) -> dict[str, int]:
    """Finished parts of an unfinished folder, and when each was written."""
    found = out.with_name(out.name + ".partial").glob("parts/*.arrows")
    return {path.name: path.stat().st_mtime_ns for path in found}


def at_the_gate(out: Path, cluster: Cluster) -> Callable[[], bool]:
    """Whether all is done that can be while the gate is closed, and the rest has begun."""
    return lambda: len(finished_parts(out)) == BEFORE_THE_GATE and cluster.gate.with_name("gate.reached").exists()


@pytest.mark.slow
def test_a_worker_killed_while_generating_loses_nothing(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run = start("generate", SPLIT, "--out", out, "--scheduler", dask.of(2))
    wait_until(at_the_gate(out, dask))
    dask.workers[0].kill()
    dask.open_gate()
    status, errors = ended(run)
    assert status == 0, errors
    assert digests(out) == digests(single.folder)
    verify(out)


@contextmanager
def busy_machine() -> Iterator[None]:
    """Three programs a core that do nothing but take time."""
    count = 3 * (os.cpu_count() or 1)
    programs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


@pytest.mark.slow
def test_interrupted_and_resumed(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["generate", SPLIT, "--out", out, "--scheduler", dask.of(2)]
    run = start(*command)
    wait_until(at_the_gate(out, dask))
    with busy_machine():
        for _ in range(3):
            run.send_signal(signal.SIGINT)
        assert ended(run) == (130, "vbbench: stopped; run the same command again to continue\n")
    kept = finished_parts(out)
    assert len(kept) == BEFORE_THE_GATE
    dask.close_gate()
    run = start(*command)
    wait_until(at_the_gate(out, dask))
    assert finished_parts(out) == kept
    dask.open_gate()
    assert ended(run)[0] == 0
    assert digests(out) == digests(single.folder)


@pytest.mark.slow
def test_all_workers_lost_and_new_ones_go_on(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["generate", SPLIT, "--out", out, "--scheduler", dask.of(2)]
    run = start(*command)
    wait_until(at_the_gate(out, dask))
    for worker in dask.workers:
        worker.kill()
    status, errors = ended(run)
    assert (status, errors.count("\n")) == (2, 1), errors
    assert "no workers are left; finished parts are kept; run the same command again" in errors
    dask.open_gate()
    dask.of(2)
    assert ended(start(*command))[0] == 0
    assert digests(out) == digests(single.folder)


@pytest.mark.slow
def test_a_lost_scheduler_is_one_line_and_another_cluster_goes_on(
    dask: Cluster, single: Dataset, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    with started(tmp_path) as small:
        run = start("generate", SPLIT, "--out", out, "--scheduler", small.of(1))
        wait_until(at_the_gate(out, small))
        small.scheduler.kill()
        status, errors = ended(run)
    assert (status, errors.count("\n")) == (2, 1), errors
    assert "the scheduler was lost; finished parts are kept" in errors
    dask.open_gate()
    assert ended(start("generate", SPLIT, "--out", out, "--scheduler", dask.of(2)))[0] == 0
    assert digests(out) == digests(single.folder)


def test_workers_that_may_not_start_processes_isolate_solvers(single: Dataset, tmp_path: Path) -> None:
    """Those of a nanny are daemons, which multiprocessing keeps from having children."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as nannies:
        out = solve(single, "cv", "rollout", tmp_path / "out", scheduler=nannies.scheduler_address, isolate=True)
    here = solve(single, "cv", "rollout", tmp_path / "here")
    pd.testing.assert_frame_equal(pd.read_parquet(out / "poses.parquet"), pd.read_parquet(here / "poses.parquet"))


@pytest.mark.slow
def test_work_that_kills_its_workers_is_given_up(single: Dataset, tmp_path: Path) -> None:
    """On a cluster of its own: workers that still have such work when it is given up die later."""
    with started(tmp_path) as doomed:
        address = doomed.of(5)  # more than die before dask gives up
        with pytest.raises(VbbenchError, match="died again and again") as caught:
            solve(single, "tests.lib.slow_split:DeadlySolver", "rollout", tmp_path / "out", scheduler=address)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_workers_need_the_dataset_on_a_shared_disk(
    dask: Cluster, single: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "only-here").symlink_to(single.folder)
    hidden = Dataset(tmp_path / "only-here")
    monkeypatch.setattr(Path, "resolve", lambda path: Path("elsewhere"))
    with pytest.raises(VbbenchError, match="a worker cannot open the dataset; keep it on a disk that all share"):
        solve(hidden, "cv", "rollout", tmp_path / "out", scheduler=dask.of(2))


def test_what_studies_need_is_made_on_a_cluster_as_it_is_here(dask: Cluster, tmp_path: Path) -> None:
    there, here = Making(scheduler=dask.of(2)), Making()
    data = there.dataset("demo", tmp_path / "there" / "dataset", Options())
    assert digests(data.folder) == digests(here.dataset("demo", tmp_path / "here" / "dataset", Options()).folder)
    made = there.cell(data, "cv", "sequential")
    same = here.cell(Dataset(tmp_path / "here" / "dataset"), "cv", "sequential")
    assert made.summaries == same.summaries
    nowhere = Making(scheduler="tcp://127.0.0.1:1")  # nothing is left to make
    assert nowhere.cell(data, "cv", "sequential").summaries == made.summaries


def one_pose(first: int, last: int) -> Part:
    raise VbbenchError(f"the file of sequence {first} is bad")


def test_a_users_mistake_comes_back_as_itself(dask: Cluster) -> None:
    with pytest.raises(VbbenchError, match=r"^the file of sequence 0 is bad$"):
        list(cluster.on_cluster(one_pose, [(0, 32)], dask.of(1)))


def test_workers_of_other_versions_are_refused(dask: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    here = cluster.versions()
    monkeypatch.setattr(cluster, "versions", lambda: here | {"vbbench": "9.9", "Python": "3.99"})
    with pytest.raises(VbbenchError, match=r"worker tcp.* has Python .*\(here 3\.99\), vbbench .*\(here 9\.9\); "):
        list(cluster.on_cluster(one_pose, [(0, 32)], dask.of(1)))


@pytest.mark.parametrize("address", ["nonsense", "nonsense://x", "127.0.0.1:eighty", ""])
def test_nonsense_is_no_address(address: str) -> None:
    with pytest.raises(VbbenchError, match=f"is an address such as tcp://127.0.0.1:8786, not '{address}'"):
        list(cluster.on_cluster(one_pose, [(0, 1)], address))


def test_no_scheduler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.1)
    for address in (f"tcp://127.0.0.1:{free_port()}", f"127.0.0.1:{free_port()}"):
        with pytest.raises(VbbenchError, match=f"no Dask scheduler answers at {address}; start one"):
            list(cluster.on_cluster(one_pose, [(0, 32)], address))


@pytest.mark.slow
def test_no_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import Client

    wait = Client.wait_for_workers
    monkeypatch.setattr(Client, "wait_for_workers", lambda client, count, timeout: wait(client, count, timeout=0.1))
    with started(tmp_path) as lonely, pytest.raises(VbbenchError, match="has no workers; start some with") as caught:
        list(cluster.on_cluster(one_pose, [(0, 32)], lonely.address))
    assert f"'dask worker {lonely.address}'" in str(caught.value)


def test_no_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(VbbenchError, match=r"pip install 'vbbench\[dask\]'"):
        list(cluster.on_cluster(one_pose, [(0, 32)], "tcp://127.0.0.1:8786"))


def test_an_address_must_fit_the_settings_of_encryption(monkeypatch: pytest.MonkeyPatch) -> None:
    from dask import config

    monkeypatch.setattr(cluster, "PATIENCE", 0.1)
    tcp, tls = (f"{protocol}://127.0.0.1:{free_port()}" for protocol in ("tcp", "tls"))
    encrypted, plain = config.set({"distributed.comm.require-encryption": True}), "is not encrypted, as Dask's settings"
    with encrypted, pytest.raises(VbbenchError, match=plain):
        list(cluster.on_cluster(one_pose, [(0, 32)], tcp))
    with pytest.raises(VbbenchError, match="check that it knows the certificates of Dask's"):
        list(cluster.on_cluster(one_pose, [(0, 32)], tls))
