"""Solvers that try to get at truth, or at the process that holds it, and tell what they got."""

import ctypes
import errno
import json
import os
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.estimate import Estimate, FrameEstimate
from vbbench.geometry import FloatArray
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem

TARGETS_FILE = Path(__file__).with_name("targets.json")


class Honest:
    """Answers zeros."""

    def start(self, problem: Problem) -> None:
        self.problem = problem

    def step(self, frame: Frame) -> FrameEstimate:
        return FrameEstimate(pose=np.zeros(3), positions=np.zeros((len(frame.observations), 2)))


class Counting:
    """Answers how many problems there were so far."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def solve(self, problem: Problem, observations: FloatArray, _given: Given) -> Estimate:
        if not any(problem is one for one in self.problems):
            self.problems.append(problem)
        shape = observations.shape[:2]
        return Estimate(poses=np.full((len(observations), 3), len(self.problems)), positions=np.zeros((*shape, 2)))


LIBC = ctypes.CDLL(None, use_errno=True)
PARENT = Path(f"/proc/{os.getppid()}")


def memory() -> Any:
    with (PARENT / "maps").open() as maps, (PARENT / "mem").open("rb") as mem:
        place = next(line for line in maps if " rw-p " in line)
        mem.seek(int(place.split("-")[0], 16))
        return len(mem.read(16))


def vm_read() -> Any:
    """Whether the kernel lets us try: an address that is not there is another error."""
    here = ctypes.create_string_buffer(16)
    local, remote = (ctypes.c_uint64 * 2)(ctypes.addressof(here), 16), (ctypes.c_uint64 * 2)(4096, 16)
    LIBC.process_vm_readv(os.getppid(), local, 1, remote, 1, 0)
    return ctypes.get_errno() not in (errno.EPERM, errno.ESRCH)


def ptrace() -> Any:
    attached = LIBC.ptrace(0x4206, os.getppid(), 0, 0) == 0  # PTRACE_SEIZE, which does not stop it
    return attached and LIBC.ptrace(17, os.getppid(), 0, 0) == 0


def through_fds() -> Any:
    return [str(path.readlink()) for path in PARENT.joinpath("fd").iterdir()]


def names(folder: Path | str) -> list[str]:
    return [path.name for path in Path(folder).iterdir()]


def tcp(port: int) -> str:
    return socket.create_connection(("127.0.0.1", port), timeout=2).recv(5).decode()


def udp(port: int) -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        return sender.sendto(b"x", ("127.0.0.1", port))


def leftovers(dataset: str) -> list[str]:
    """Places known to this process that lead to the dataset."""
    open_files = [str(path.readlink()) for path in Path("/proc/self/fd").iterdir() if path.is_symlink()]
    return [place for place in (*os.environ.values(), str(Path.cwd()), *sys.argv, *open_files) if dataset in place]


def write(folder: str) -> str:
    Path(folder, "escaped.pyc").write_bytes(b"code")
    return folder


def by_another(path: str) -> bytes:
    code = f"print(len(open({path!r}, 'rb').read()))"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout


def attempts(targets: dict[str, Any]) -> dict[str, Callable[[], Any]]:
    """What is tried, by name; each returns something or raises. ``targets`` are what a solver may have guessed."""
    return {
        "command line of the parent": (PARENT / "cmdline").read_text,
        "environment of the parent": (PARENT / "environ").read_text,
        "working folder of the parent": lambda: names(PARENT / "cwd"),
        "open files of the parent": through_fds,
        "memory of the parent": memory,
        "process_vm_readv": vm_read,
        "ptrace": ptrace,
        "signal": lambda: os.kill(os.getppid(), 0) is None,
        "tcp": lambda: tcp(targets["port"]),
        "udp": lambda: udp(targets["port"]),
        "paths left over": lambda: leftovers(targets["dataset"]),
        "another process": lambda: by_another(targets["truth"]),
        "home": lambda: names(targets["home"]),
        **{f"read {name}": Path(path).read_bytes for name, path in targets["files"].items()},
        **{f"write {name}": partial(write, path) for name, path in targets["folders"].items()},
    }


def loot() -> str:
    """What can be had, as JSON: by name of the attempt."""
    got = {}
    for name, attempt in attempts(json.loads(TARGETS_FILE.read_text())).items():
        with suppress(Exception):
            got[name] = str(attempt() or "")[:60]
    return json.dumps({name: found for name, found in got.items() if found})


class Burglar(Honest):
    """Tries everything and raises what it got."""

    def start(self, problem: Problem) -> None:
        raise RuntimeError(loot())


class Pickled(FrameEstimate):
    """Whoever unpickles it makes a file."""

    def __reduce__(self) -> Any:
        return Path.touch, (Path(json.loads(TARGETS_FILE.read_text())["mark"]),)


class Pickler(Honest):
    def step(self, frame: Frame) -> FrameEstimate:
        return Pickled(pose=np.ones(3), positions=np.zeros((len(frame.observations), 2)))


class Array(np.ndarray):
    """An array that would run code where it is used."""

    def __array_finalize__(self, of: Any) -> None:
        self.evil = True


class Subclasser(Honest):
    def step(self, frame: Frame) -> FrameEstimate:
        answer = super().step(frame)
        object.__setattr__(answer, "positions", answer.positions.view(Array))
        object.__setattr__(answer, "pose", np.array([1, 2, 3], dtype=object))
        return answer


def raw(data: bytes) -> None:
    """Write to the pipe behind the back of whoever answers there."""
    for path in Path("/proc/self/fd").iterdir():
        with suppress(OSError):
            if int(path.name) > 2 and str(path.readlink()).startswith("pipe:"):
                os.write(int(path.name), data)


def message(facts: Any, body: bytes = b"") -> bytes:
    header = json.dumps(facts).encode()
    return struct.pack("<I", len(header)) + header + body


class Greedy(Honest):
    """Announces a terabyte."""

    def step(self, frame: Frame) -> FrameEstimate:
        raw(message({"said": "done", "arrays": [["pose", "<f8", [3]], ["positions", "<f8", [1 << 36, 2]]]}))
        time.sleep(60)
        raise AssertionError


class Shapeless(Honest):
    """Has one person too few."""

    def step(self, frame: Frame) -> FrameEstimate:
        return FrameEstimate(pose=np.zeros(3), positions=np.zeros((len(frame.observations) - 1, 2)))


class Poseless(Honest):
    def step(self, frame: Frame) -> FrameEstimate:
        raw(message({"said": "done", "arrays": []}))
        time.sleep(60)
        raise AssertionError


class Chatty(Honest):
    """Prints, which must not disturb what it answers."""

    def step(self, frame: Frame) -> FrameEstimate:
        sys.stdout.write("\x1b[31m" + "word " * 40_000)
        os.write(1, b"more words")
        return super().step(frame)


class Quitter(Honest):
    def step(self, frame: Frame) -> FrameEstimate:
        os.write(1, b"\x1b[2Jgood\nbye\n")
        os._exit(3)


class Disappointed(Honest):
    """Fails at a sequence with fewer people than the one before."""

    most = 0

    def start(self, problem: Problem) -> None:
        if len(problem.tracks) < self.most:
            raise ValueError("fewer people than before")
        self.most = len(problem.tracks)


class Colourful(Honest):
    def step(self, frame: Frame) -> FrameEstimate:
        raise ValueError("\x1b]0;mine\x07" + "x" * 100_000)


class Lister(Honest):
    def step(self, frame: Frame) -> FrameEstimate:
        return [1.0]  # type: ignore[return-value]


class Endless(Honest):
    """Never answers, and has started another process that does not, either."""

    def step(self, frame: Frame) -> FrameEstimate:
        subprocess.Popen(["sleep", "600"])
        while True:
            pass
