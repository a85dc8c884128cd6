"""Signals at every moment: one line, the exit status says which, and no process is left."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.generation.test_datasets import digests
from tests.lib.commands import ended, kill_session, session, start, wait_until
from tests.lib.slow_split import BEFORE_THE_GATE, GATE, SEQUENCES
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.parallel.parts import in_parallel
from vbbench.solving import solve

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="lists processes as Linux does")

SPLIT = "tests.lib.slow_split:SLOW"
GOES_ON = "run the same command again to continue\n"
SAID = {
    signal.SIGINT: f"vbbench: stopped; {GOES_ON}",
    signal.SIGTERM: f"vbbench: stopped by SIGTERM; {GOES_ON}",
    signal.SIGHUP: f"vbbench: stopped by SIGHUP; {GOES_ON}",
}

STUBBORN = """
import ctypes, os, pathlib, subprocess, sys, time

def here():
    pathlib.Path("here").touch()

class Still:
    def start(self, problem): pass

class Locked(Still):
    '''Compiled code that never comes back, as a compiler may not for a while.'''
    def step(self, frame):
        lock, libc = ctypes.create_string_buffer(64), ctypes.CDLL(None)
        libc.pthread_mutex_lock(lock)
        here()
        libc.pthread_mutex_lock(lock)

class Deaf(Still):
    '''Code that takes an interruption for a fault of its own, and complains.'''
    def step(self, frame):
        here()
        while True:
            try:
                time.sleep(600)
            except BaseException as error:
                print("what is that?", repr(error), file=sys.stderr, flush=True)

class Employer(Still):
    '''Has another program do its work.'''
    def step(self, frame):
        program = subprocess.Popen(["sleep", "600"])
        here()
        program.wait()
"""


@pytest.fixture
def begin(tmp_path: Path) -> Iterator[Callable[..., "subprocess.Popen[str]"]]:
    """Starts commands that do not outlive the test; the gate of the slow split is closed for them."""
    started = []

    def begin_one(*arguments: object, **options: Any) -> "subprocess.Popen[str]":
        options = {"env": os.environ | {GATE: str(tmp_path / "gate")}, **options}
        started.append(start(*arguments, **options))
        return started[-1]

    yield begin_one
    for process in started:
        kill_session(process.pid)
        process.communicate()


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("demo") / "demo", Options())


@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate(SPLIT, tmp_path_factory.mktemp("slow") / "slow", Options())


def at_the_gate(folder: Path, jobs: int) -> Callable[[], bool]:
    """Whether a command that makes ``folder/out`` has done what it can, all its workers at work."""
    parts = BEFORE_THE_GATE if jobs > 1 else 0  # a single process keeps its first parts in memory

    def there() -> bool:
        made = list((folder / "out.partial" / "parts").glob("*.arrows"))
        return (folder / "gate.reached").exists() and len(made) == parts

    return there


def assert_nothing_left(process: "subprocess.Popen[str]") -> None:
    wait_until(lambda: not session(process.pid), 10)
    shared = Path("/dev/shm").iterdir()  # noqa: S108
    assert not [path.name for path in shared if re.search(rf"[-_]{process.pid}[-_]", path.name)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "receivers", "times", "jobs"),
    [
        (signal.SIGINT, "all", 3, 2),  # as a terminal sends ctrl-C, to every process
        (signal.SIGTERM, "one", 1, 1),
        (signal.SIGHUP, "all", 1, 2),
    ],
)
def test_a_signal_is_one_line_and_the_end(
    begin: Callable[..., Any], tmp_path: Path, number: signal.Signals, receivers: str, times: int, jobs: int
) -> None:
    if signal.getsignal(number) is signal.SIG_IGN:  # under nohup; what is ignored here would be there, too
        signal.signal(number, signal.SIG_DFL)
    run = begin("generate", SPLIT, "--out", tmp_path / "out", "--jobs", jobs)
    wait_until(at_the_gate(tmp_path, jobs))
    for _ in range(times):
        if run.poll() is None:
            (os.killpg if receivers == "all" else os.kill)(run.pid, number)
    assert ended(run) == (128 + number, SAID[number])
    assert_nothing_left(run)


@pytest.mark.slow
def test_what_was_done_before_a_signal_is_not_done_again(
    begin: Callable[..., Any], slow: Dataset, tmp_path: Path
) -> None:
    out, parts = tmp_path / "out", tmp_path / "out.partial" / "parts"
    run = begin("generate", SPLIT, "--out", out, "--jobs", 2)
    wait_until(at_the_gate(tmp_path, 2))
    run.terminate()
    ended(run)
    written = {path.name: path.stat().st_mtime_ns for path in parts.glob("*.arrows")}
    (tmp_path / "gate.reached").unlink()
    run = begin("generate", SPLIT, "--out", out, "--jobs", 2)
    wait_until(at_the_gate(tmp_path, 2))
    assert {path.name: path.stat().st_mtime_ns for path in parts.glob("*.arrows")} == written
    (tmp_path / "gate").touch()
    assert ended(run)[0] == 0
    assert len(Dataset(out)) == SEQUENCES
    assert digests(out) == digests(slow.folder)


@pytest.mark.slow
def test_workers_do_not_outlive_a_killed_command(begin: Callable[..., Any], tmp_path: Path) -> None:
    run = begin("generate", SPLIT, "--out", tmp_path / "out", "--jobs", 2)
    wait_until(at_the_gate(tmp_path, 2))
    run.kill()
    assert ended(run) == (-signal.SIGKILL, "")
    assert_nothing_left(run)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("solver", "jobs"),
    [
        ("Locked", 1),
        *[pytest.param(name, 1, marks=pytest.mark.slow) for name in ("Deaf", "Employer")],
        *[pytest.param(name, 2, marks=pytest.mark.slow) for name in ("Locked", "Deaf", "Employer")],
    ],
)
def test_code_that_hears_no_signal_is_stopped(
    begin: Callable[..., Any], dataset: Dataset, tmp_path: Path, solver: str, jobs: int
) -> None:
    (tmp_path / "stubborn.py").write_text(STUBBORN)
    name = f"stubborn:{solver}"
    run = begin("solve", dataset.folder, "--solver", name, "--out", "out", "--jobs", jobs, cwd=tmp_path)
    wait_until(lambda: (tmp_path / "here").exists())
    run.terminate()
    assert ended(run) == (143, SAID[signal.SIGTERM])
    assert_nothing_left(run)


def test_a_signal_while_importing(begin: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import pathlib, sys, time\n"
        "class Slow:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'vbbench.cli':\n"
        f"            pathlib.Path({str(tmp_path / 'here')!r}).touch()\n"
        "            time.sleep(600)\n"
        "sys.meta_path.insert(0, Slow())\n"
    )
    run = begin("splits", env=os.environ | {"PYTHONPATH": str(tmp_path)})
    wait_until(lambda: (tmp_path / "here").exists())
    run.send_signal(signal.SIGINT)
    assert ended(run) == (130, SAID[signal.SIGINT])


@pytest.mark.slow
def test_signals_that_are_ignored_stay_ignored(begin: Callable[..., Any], tmp_path: Path) -> None:
    run = begin(
        *("generate", SPLIT, "--out", tmp_path / "out"),
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),  # as nohup does
    )
    wait_until(at_the_gate(tmp_path, 1))
    run.send_signal(signal.SIGHUP)
    (tmp_path / "gate").touch()
    assert ended(run)[0] == 0


@pytest.mark.slow
def test_a_worker_that_dies_is_one_line(slow: Dataset, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=r"^a worker process died \(out of memory\?\); run the same command again"):
        solve(slow, "tests.lib.slow_split:DeadlySolver", "rollout", tmp_path / "out", jobs=2)


@pytest.mark.parametrize("jobs", [0, -5, -2, 100_000_000])
def test_a_senseless_number_of_jobs_is_one_line(
    dataset: Dataset, tmp_path: Path, mistake: Callable[..., str], jobs: int
) -> None:
    most = 8 * (os.cpu_count() or 1)
    for command in (["generate", "demo"], ["solve", dataset.folder, "--solver", "cv"]):
        error = mistake(*command, "--out", tmp_path / "out", "--jobs", jobs)
        assert f"jobs is a number of processes: 1 to {most} here, or -1 for one per core, not {jobs}" in error
    assert not list(tmp_path.iterdir())


def test_results_of_workers_come_in_order() -> None:
    assert list(in_parallel(divmod, [(number, 3) for number in range(20)], 2)) == [divmod(n, 3) for n in range(20)]
    assert list(in_parallel(divmod, [], 1)) == []
