"""Stops work before its n-th step on files, as a kill would: no block of it is left in an orderly way."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

STEPS = ("mkdir", "open", "replace", "rename", "unlink", "rmdir", "ftruncate")
STOPPED = 77


def stopped_at_every_step(work: Callable[[], object], prepare: Callable[[], object]) -> Iterator[int]:
    """Prepare and stop the work before each of its steps in turn; yields how many steps were done, then goes on."""
    for step in range(10_000):
        prepare()
        if not stopped_at(step, work):
            return
        yield step


def stopped_at(step: int, work: Callable[[], object]) -> bool:
    """Do the work in a process of its own; whether that was stopped, or had fewer steps."""
    child = os.fork()
    if child == 0:
        _count_down(step)
        try:
            work()
        except BaseException:
            os._exit(1)
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert status in (0, STOPPED)
    return status == STOPPED


def _count_down(left: int) -> None:
    def counted(function: Callable[..., Any], name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            nonlocal left
            if name != "open" or arguments[1] & (os.O_CREAT | os.O_RDWR):
                if left == 0:
                    os._exit(STOPPED)
                left -= 1
            return function(*arguments, **options)

        return call

    for name in STEPS:
        setattr(os, name, counted(getattr(os, name), name))


def names(folder: Path) -> list[str]:
    """What lies in a folder, hidden files too."""
    return sorted(path.name for path in folder.iterdir())


def contents(folder: Path) -> dict[str, bytes]:
    """Every file in a folder, hidden files too."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
