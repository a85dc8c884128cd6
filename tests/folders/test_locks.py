"""One command at a time: who comes second ends at once in one line, whatever either of them does."""

import json
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from tests.lib.challenges import withheld_challenge
from tests.lib.stopping import contents, names, stopped_at
from vbbench.cli import main
from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.exchange.tum import export_dataset_tum
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import LOCK, BusyError, locked
from vbbench.folders.work_folder import WorkFolder
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.solving import solve

OPTIONS = Options(limit=2)
HOLDER = """
import sys
from pathlib import Path
from vbbench.folders.locks import locked
with locked(Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.read()
"""


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("room")
    dataset = generate("demo", folder / "data", OPTIONS)
    export_dataset_tum(dataset, folder / "files")
    solve(dataset, "cv", "rollout", folder / "answer")
    withheld_challenge(folder / "tiny", "demo", OPTIONS)
    return folder


@contextmanager
def held(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Somebody else writes into ``folder``."""
    command = [sys.executable, "-c", HOLDER, str(folder)]
    holder = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert holder.stdout.readline() == "locked\n"
    yield holder
    holder.communicate()


COMMANDS = {
    "out.partial": [
        "generate demo --limit 2 --out out",
        "generate demo --limit 2 --out out --scheduler tcp://127.0.0.1:1",
        "solve {data} --solver cv --out out",
        "solve {data} --solver cv --out out --scheduler tcp://127.0.0.1:1",
        "leaderboard build --out out",
        "challenge bundle {tiny} --out out",
    ],
    "out": [
        "export csv {data} --out out",
        "export mot {data} --out out",
        "export tum {data} --out out",
        "import tum {files} --dataset {data} --solver me --out out",
        "render {data} --sequence 0 --backend raster --out out",
        "demo --out out",
        "reproduce figure-sigma --sequences 1 --out out",
        "leaderboard template out",
        "challenge new out",
    ],
}


@pytest.mark.slow
def test_the_second_command_ends_at_once_in_one_line(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for place, commands in COMMANDS.items():
        with held(tmp_path / place) as holder:
            before = contents(tmp_path)
            for command in commands:
                made = {name: room / name for name in ("data", "files", "tiny")}
                words = command.format(**made).split()
                assert main(words) == 2, command
                said = capsys.readouterr()
                assert said.out == "", command
                *announced, line = said.err.splitlines()
                assert all(other.startswith("vbbench: rendering with raster") for other in announced), said.err
                expected = f"vbbench: out is being written by process {holder.pid} on {socket.gethostname()} since "
                assert line.startswith(expected), said.err
                assert "wait until it is done, or choose another folder" in line
                assert contents(tmp_path) == before, command
        assert names(tmp_path) == [], place


@pytest.mark.slow
def test_many_at_once_make_it_once(room: Path, tmp_path: Path) -> None:
    """One of them makes it, the others are told so; nobody ends in a traceback and nothing is left."""
    command = [sys.executable, "-m", "vbbench", "generate", "demo", "--limit", "2", "--out", "out"]
    start = [*command, "--jobs", "1"]
    runs = [
        subprocess.Popen(start, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    ended = [(run.communicate(), run.returncode) for run in runs]
    winners = [said for said, status in ended if status == 0]
    assert winners
    for (_, errors), status in ended:
        if status:
            assert (status, errors.count("\n")) == (2, 1), errors
            assert "is being written by" in errors or "exists; set --overwrite" in errors
    assert contents(tmp_path / "out") == contents(room / "data")
    assert names(tmp_path) == ["out"]


@pytest.mark.slow
def test_threads_exclude_one_another_too(tmp_path: Path) -> None:
    inside, most, outcomes = [0], [0], []

    def work() -> None:
        done = 0
        while done < 50:
            with suppress(BusyError), locked(tmp_path / "out"):
                inside[0] += 1
                most[0] = max(most[0], inside[0])
                inside[0] -= 1
                done += 1
        outcomes.append(done)

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most[0] == 1
    assert outcomes == [50] * 8
    assert not contents(tmp_path)


def test_a_killed_holder_is_no_holder(tmp_path: Path) -> None:
    with held(tmp_path / "out") as holder:
        with pytest.raises(BusyError), locked(tmp_path / "out"):
            pass
        holder.kill()
        holder.wait()
    assert (tmp_path / "out" / LOCK).is_file()
    with locked(tmp_path / "out"):
        assert json.loads((tmp_path / "out" / LOCK).read_text("utf-8"))["process"] == os.getpid()
    assert names(tmp_path / "out") == []


def test_another_computers_lock_is_never_presumed_stale(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mistake: Callable[..., str]
) -> None:
    out = tmp_path / "out"
    monkeypatch.setattr(socket, "gethostname", lambda: "far-away")
    for step in range(100):
        stopped_at(step, lambda: generate("demo", out, OPTIONS))
        if (tmp_path / "out.partial" / LOCK).is_file() and (tmp_path / "out.partial" / LOCK).stat().st_size:
            break
    monkeypatch.undo()
    said = mistake("generate", "demo", "--limit", "2", "--out", out)
    assert f"{out} may be in use by process " in said
    assert " on far-away since 2" in said
    assert f"if that has ended, remove {tmp_path / 'out.partial' / LOCK} and run this again" in said
    (tmp_path / "out.partial" / LOCK).unlink()
    assert main(["generate", "demo", "--limit", "2", "--out", str(out)]) == 0
    assert contents(out) == contents(room / "data")


HOSTILE = '{"process": "\\u001b[31m\\n", "host": "a\\nb", "command": "\\u0007"}'


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "{}"])
def test_a_lock_that_says_nothing_holds_nobody_up(tmp_path: Path, text: str) -> None:
    (tmp_path / LOCK).write_text(text)
    with locked(tmp_path):
        pass
    assert names(tmp_path) == []


@pytest.mark.parametrize("text", ['{"host": 3}', HOSTILE])
def test_whatever_a_lock_says_is_printable(tmp_path: Path, text: str) -> None:
    (tmp_path / LOCK).write_text(text)
    with pytest.raises(BusyError) as caught, locked(tmp_path):
        pass
    assert str(caught.value).isprintable()


def test_a_disk_without_locks_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", refused)
    with pytest.warns(VbbenchWarning, match="has no locks; let one command at a time"), locked(tmp_path / "out"):
        assert names(tmp_path / "out") == [LOCK]
    assert names(tmp_path) == []


def test_a_lock_that_is_a_link_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "mine").write_text("years of work")
    (tmp_path / "out" / LOCK).symlink_to(tmp_path / "mine")
    with pytest.raises(VbbenchError, match="choose another place"), locked(tmp_path / "out"):
        pass
    assert (tmp_path / "mine").read_text() == "years of work"


def test_work_folders_and_readers(room: Path, tmp_path: Path) -> None:
    """Who reads waits for nobody."""
    generate("demo", tmp_path / "out", OPTIONS)
    with WorkFolder(tmp_path / "out") as work:
        work.begin()
        assert contents(Dataset(tmp_path / "out").folder) == contents(room / "data")
    assert names(tmp_path) == ["out"]
