"""A real scheduler and real workers, some of them killed: nothing is lost, nothing is there twice."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd
import pytest

from tests.slow_split import SEQUENCES
from tests.test_generation import digests
from vbbench import cluster
from vbbench.dataset import Dataset
from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generator import Options
from vbbench.merging import merge
from vbbench.parts import Part
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench.verification import verify

pytest.importorskip("distributed", reason="needs the extra dask")
pytestmark = pytest.mark.extra

ROOT = Path(__file__).parent.parent
SPLIT, SOLVER = "tests.slow_split:SLOW", "tests.slow_split:SlowSolver"


def wait_until(condition: Callable[[], object], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Cluster:
    """A scheduler that forgives one death a task, and its workers; no nanny brings a killed one back."""

    def __init__(self, folder: Path) -> None:
        self._folder, self.address = folder, f"tcp://127.0.0.1:{free_port()}"
        self.workers: list[subprocess.Popen[bytes]] = []
        self._started = 0
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", self.address.rpartition(":")[2])

    def _start(self, *command: str) -> subprocess.Popen[bytes]:
        settings = {"ALLOWED_FAILURES": "1", "NO_WORKERS_TIMEOUT": "1s"}
        environment = os.environ | {f"DASK_DISTRIBUTED__SCHEDULER__{key}": value for key, value in settings.items()}
        self._started += 1
        with (self._folder / f"{self._started}.log").open("wb") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", *command, "--no-dashboard"],
                stdout=log,
                stderr=log,
                env=environment,
                cwd=self._folder,
            )

    def of(self, count: int) -> str:
        """The address, when so many workers, or more, are there."""
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        while len(self.workers) < count:
            options = ["--no-nanny", "--nthreads", "1", "--memory-limit", "1GiB", "--local-directory", "scratch"]
            self.workers.append(self._start("worker", self.address, *options))
        from distributed import Client

        with Client(self.address, timeout=20, set_as_default=False) as client:
            wait_until(lambda: len(client.scheduler_info(n_workers=-1)["workers"]) >= count)
        return self.address

    def stop(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    started = Cluster(tmp_path_factory.mktemp("cluster"))
    yield started
    started.stop()


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate(SPLIT, tmp_path_factory.mktemp("single") / "slow", Options(), jobs=2)


def vbbench(*arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "vbbench", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)


def finished_parts(out: Path) -> dict[str, int]:
    """Finished parts of an unfinished folder, and when each was written."""
    found = out.with_name(out.name + ".partial").glob("new/partitioned/part-*.json")
    return {path.name: path.stat().st_mtime_ns for path in found}


PARTS = SEQUENCES // 32


def test_a_worker_killed_while_generating_loses_nothing(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run = vbbench("generate", SPLIT, "--out", out, "--scheduler", dask.of(2))
    wait_until(lambda: finished_parts(out))
    dask.workers[0].kill()
    assert len(finished_parts(out)) < PARTS - 2
    assert run.wait(60) == 0, run.communicate()[1]
    with pytest.raises(VbbenchError, match=f"out is partitioned; run 'vbbench merge {out}'"):
        Dataset(out)
    parts = pd.concat([pd.read_parquet(path) for path in sorted((out / "sequences").iterdir())])
    assert parts.sequence.tolist() == list(range(SEQUENCES))
    assert len(pd.read_parquet(out / "observations")) == single.info.counts["observations"]
    merge(out)
    assert digests(out) == digests(single.folder)
    verify(out)


def test_a_worker_killed_while_solving_loses_nothing(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run = vbbench("solve", single.folder, "--solver", SOLVER, "--out", out, "--scheduler", dask.of(2))
    wait_until(lambda: finished_parts(out))
    dask.workers[0].kill()
    assert run.wait(60) == 0, run.communicate()[1]
    with pytest.raises(VbbenchError, match="out is partitioned; run"):
        score(out, single.folder)
    alone = solve(single, SOLVER, "one-step", tmp_path / "alone", jobs=2)
    assert tables(merge(out)) == tables(alone)
    assert score(out, single.folder).coverage == 1.0
    declared, here = (json.loads((folder / "submission.json").read_text()) for folder in (out, alone))
    assert declared | {"seconds_per_frame": 0} == here | {"seconds_per_frame": 0}
    assert declared["seconds_per_frame"] > 0


def tables(folder: Path) -> dict[str, str]:
    return {name: digest for name, digest in digests(folder).items() if name.endswith(".parquet")}


def test_interrupted_and_resumed(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["generate", SPLIT, "--out", out, "--scheduler", dask.of(2)]
    run = vbbench(*command)
    wait_until(lambda: len(finished_parts(out)) > 2)
    run.send_signal(signal.SIGINT)
    errors = run.communicate(timeout=30)[1]
    assert (run.returncode, errors) == (130, "vbbench: stopped; the same command goes on where this one was\n")
    kept = finished_parts(out)
    assert 2 < len(kept) < PARTS
    assert vbbench(*command).wait(60) == 0
    written = {path.name: path.stat().st_mtime_ns for path in (out / "partitioned").glob("part-*.json")}
    assert {name: written[name] for name in kept} == kept
    assert len(written) == PARTS
    assert digests(merge(out)) == digests(single.folder)


def test_all_workers_lost_and_new_ones_go_on(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["generate", SPLIT, "--out", out, "--scheduler", dask.of(2)]
    run = vbbench(*command)
    wait_until(lambda: finished_parts(out))
    for worker in dask.workers:
        worker.kill()
    errors = run.communicate(timeout=60)[1]
    assert run.returncode == 2, errors
    assert errors.count("\n") == 1
    assert "no workers are left; finished parts are kept, and the same command goes on" in errors
    dask.of(2)
    assert vbbench(*command).wait(60) == 0
    assert digests(merge(out)) == digests(single.folder)


def test_a_lost_scheduler_is_one_line_and_another_cluster_goes_on(
    dask: Cluster, single: Dataset, tmp_path: Path
) -> None:
    out, small = tmp_path / "out", Cluster(tmp_path)
    try:
        run = vbbench("generate", SPLIT, "--out", out, "--scheduler", small.of(1))
        wait_until(lambda: finished_parts(out))
        small.scheduler.kill()
        errors = run.communicate(timeout=60)[1]
    finally:
        small.stop()
    assert run.returncode == 2, errors
    assert errors.count("\n") == 1, errors
    assert "the scheduler was lost; finished parts are kept" in errors
    assert vbbench("generate", SPLIT, "--out", out, "--scheduler", dask.of(2)).wait(60) == 0
    assert digests(merge(out)) == digests(single.folder)


def test_workers_that_may_not_start_processes_isolate_solvers(single: Dataset, tmp_path: Path) -> None:
    """Those of a nanny are daemons, which multiprocessing keeps from having children."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as nannies:
        out = solve(single, "cv", "rollout", tmp_path / "out", scheduler=nannies.scheduler_address, isolate=True)
    here = solve(single, "cv", "rollout", tmp_path / "here")
    pd.testing.assert_frame_equal(
        pd.read_parquet(merge(out) / "poses.parquet"), pd.read_parquet(here / "poses.parquet")
    )


def test_work_that_kills_its_workers_is_given_up(dask: Cluster, single: Dataset, tmp_path: Path) -> None:
    address = dask.of(3)
    with pytest.raises(VbbenchError, match="died again and again") as caught:
        solve(single, "tests.slow_split:DeadlySolver", "rollout", tmp_path / "out", scheduler=address)
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


def test_no_scheduler_no_workers_no_dask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    for address in ("nonsense", "nonsense://x", "127.0.0.1:eighty", ""):
        with pytest.raises(VbbenchError, match=f"is an address such as tcp://127.0.0.1:8786, not '{address}'"):
            list(cluster.on_cluster(one_pose, [(0, 1)], address))
    for address in (f"tcp://127.0.0.1:{free_port()}", f"127.0.0.1:{free_port()}"):
        with pytest.raises(VbbenchError, match=f"no Dask scheduler answers at {address}; start one"):
            list(cluster.on_cluster(one_pose, [(0, 32)], address))
    lonely = Cluster(tmp_path)
    monkeypatch.setattr(cluster, "PATIENCE", 3.0)
    try:
        with pytest.raises(VbbenchError, match=f"has no workers; start some with 'dask worker {lonely.address}'"):
            list(cluster.on_cluster(one_pose, [(0, 32)], lonely.address))
    finally:
        lonely.stop()
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(VbbenchError, match=r"pip install 'vbbench\[dask\]'"):
        list(cluster.on_cluster(one_pose, [(0, 32)], lonely.address))
