"""Puts a new folder, and the truth that is kept beside it, in the place of the old ones: both or neither.

Two folders cannot be renamed in one step. So a journal is written first, into the work folder where the new ones stand
ready; from then on the swap is decided. Any command that finds the journal, after a kill at any step, completes it.
"""

import json
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from vbbench.errors import FileError, VbbenchError, plain_errors
from vbbench.folders.locks import BusyError, locked
from vbbench.folders.replacing import write_text_atomically

MARK = "vbbench-work.json"
"""File that tells a work folder from anybody else's."""
JOURNAL, DONE = "swap.json", "swap-done.json"
NEW, OLD = "new", "old"
NEW_TRUTH, OLD_TRUTH = "new-truth", "old-truth"
WORK, TRUTH = ".partial", ".truth"
"""What is added to a folder's name for its work folder, and for that of its withheld truth."""

_PATIENCE = 10.0
"""Seconds that a reader waits for a swap that is under way."""


def real(folder: Path | str) -> Path:
    """The folder itself, where ``folder`` is a link to it."""
    return Path(os.path.realpath(folder))


def beside(folder: Path, ending: str) -> Path:
    """The folder of the same name with that ending."""
    return folder.with_name(folder.name + ending)


def swap(work: Path, out: Path, carried: Iterable[str] = ()) -> None:
    """Give ``work/new`` the name ``out`` and ``work/new-truth``, if it is there, that of its truth.

    What had these names is afterwards in the work folder.

    Parameters
    ----------
    carried : names in the old folder that are to be in the new one, too, unless it has them itself.

    Raises
    ------
    FileError
        If a folder cannot be renamed; nothing is changed then.
    """
    write_text_atomically(work / JOURNAL, json.dumps({"carried": sorted(carried)}) + "\n")
    _flush(work)
    staged = [step for step in _steps(work, out) if step[0].exists()]
    try:
        _rename(work, out)
    except OSError as error:
        _undo(work, staged)
        raise FileError(out, f"cannot be replaced ({os.strerror(error.errno or 0)}); choose another place") from error
    _complete(work, out)
    _flush(out.parent)


def is_decided(work: Path) -> bool:
    """Whether a swap was begun and may have been interrupted."""
    with suppress(PermissionError):  # a work folder of somebody else
        return (work / MARK).is_file() and (work / JOURNAL).is_file()
    return False


def go_on(work: Path, out: Path) -> None:
    """Complete a swap that was interrupted.

    Raises
    ------
    VbbenchError
        If something is in its way by now.
    """
    with plain_errors(out):
        _rename(work, out)
        _complete(work, out)


def is_done(work: Path) -> bool:
    """Whether all is in its place, and what is left in the work folder is of no more use."""
    return (work / DONE).is_file()


def finish_swaps(folder: Path | str) -> None:
    """Before a folder is read: complete an interrupted swap of it, or of the dataset that its truth belongs to."""
    for out in _whose(real(folder)):
        work, end = beside(out, WORK), time.monotonic() + _PATIENCE
        while is_decided(work):
            try:
                with locked(work, out):
                    go_on(work, out)
                break
            except BusyError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.01)


def _whose(folder: Path) -> Iterator[Path]:
    yield folder
    if folder.name.endswith(TRUTH) and folder.name != TRUTH:
        yield folder.with_name(folder.name.removesuffix(TRUTH))


def _steps(work: Path, out: Path) -> tuple[tuple[Path, Path, Path], ...]:
    """Truth first, so that no new dataset ever stands beside an old truth: where the new is, the old goes, its name."""
    return (work / NEW_TRUTH, work / OLD_TRUTH, real(beside(out, TRUTH))), (work / NEW, work / OLD, out)


def _rename(work: Path, out: Path) -> None:
    for new, old, name in _steps(work, out):
        if not new.exists():
            continue
        if name.exists():
            if old.exists():
                raise VbbenchError(f"{name} appeared while it was being replaced; move it away and run this again")
            name.replace(old)
        new.replace(name)


def _undo(work: Path, staged: list[tuple[Path, Path, Path]]) -> None:
    for new, old, name in reversed(staged):
        if not new.exists():
            name.replace(new)
        if old.exists():
            old.replace(name)
    (work / JOURNAL).unlink()


def _complete(work: Path, out: Path) -> None:
    """Carry over what is to be, and close the journal."""
    for name in _carried(work):
        old, new = work / OLD / Path(name).name, out / Path(name).name
        if os.path.lexists(old) and not os.path.lexists(new):
            old.replace(new)
    (work / JOURNAL).replace(work / DONE)


def _carried(work: Path) -> list[str]:
    path = work / JOURNAL
    try:
        names: list[str] = list(map(str, json.loads(path.read_text("utf-8"))["carried"]))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise FileError(path, f"is damaged ({error!r}); look at what is in {work}, and remove that") from error
    return names


def _flush(folder: Path) -> None:
    """Have the names in a folder on disk, where it can be."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
