"""Commands in processes of their own, the processes that they start, and patience with all of them."""

import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from vbbench.cli import all_commands
from vbbench.cli.parsing import parse

ROOT = Path(__file__).parents[2]
PATIENCE = 120.0
"""Seconds after which a test gives up waiting, however busy the machine is."""


def wait_until(condition: Callable[[], object], seconds: float = PATIENCE) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def understood(line: str) -> Callable[[], object]:
    """The call that a command line means, without ``vbbench`` before it; VbbenchError for another."""
    commands, words = all_commands(), shlex.split(line)
    length = 2 if " ".join(words[:2]) in commands else 1
    return parse(commands, [" ".join(words[:length]), *words[length:]])


def start(*arguments: object, **options: Any) -> "subprocess.Popen[str]":
    """Start `vbbench` with the arguments, in a session of its own."""
    command = [sys.executable, "-m", "vbbench", *map(str, arguments)]
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        **{"cwd": ROOT, **options},
    )


def ended(process: "subprocess.Popen[str]") -> tuple[int, str]:
    """Exit status and what was said on stderr, when all that may write there has ended."""
    errors = process.communicate(timeout=PATIENCE)[1]
    return process.returncode, errors


def session(leader: int) -> list[str]:
    """The command lines of all processes of a session (Linux)."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            facts = stat.read_bytes().rpartition(b")")[2].split()
            if int(facts[3]) == leader and facts[0] not in b"ZX":
                found.append(stat.with_name("cmdline").read_bytes().replace(b"\0", b" ").decode())
    return found


def kill_session(leader: int) -> None:
    """Nothing of a command outlives its test, even where the test failed."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            if int(stat.read_bytes().rpartition(b")")[2].split()[3]) == leader:
                os.kill(int(stat.parent.name), signal.SIGKILL)
