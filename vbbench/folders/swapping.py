"""Replaces a folder, and the withheld truth next to it, by new ones: both or neither.

Two folders cannot be renamed in one step. So a journal is written first, into the work folder that holds the new ones;
from then on the swap is decided. Any command that finds the journal, after a kill at any step, completes the swap.
"""

import json
import os
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from vbbench.errors import FileError, VbbenchError, plain_errors
from vbbench.folders.locks import BusyError, locked
from vbbench.folders.replacing import write_text_atomically

MARK = "vbbench-work.json"
"""File that marks a work folder as made by vbbench."""
JOURNAL, DONE = "swap.json", "swap-done.json"
NEW, OLD = "new", "old"
NEW_TRUTH, OLD_TRUTH = "new-truth", "old-truth"
WORK, TRUTH = ".partial", ".truth"
"""Endings of the names of a folder's work folder and of its withheld truth."""

_PATIENCE = 10.0
"""Seconds that a reader waits for another command's swap."""


def real(folder: Path | str) -> Path:
    """The folder itself, where ``folder`` is a link to it."""
    return Path(os.path.realpath(folder))


def next_to(folder: Path, ending: str) -> Path:
    """The folder of the same name with that ending."""
    return folder.with_name(folder.name + ending)


def swap(work: Path, out: Path, carried: Iterable[str] = ()) -> None:
    """Rename ``work/new`` to ``out``, and ``work/new-truth``, if it exists, to the name of its truth.

    The folders that had these names move into the work folder.

    Parameters
    ----------
    carried : names in the old folder to move to the new one, unless it has them itself.

    Raises
    ------
    FileError
        If a folder cannot be renamed; nothing is changed.
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
    with suppress(PermissionError):  # another user's work folder
        return (work / MARK).is_file() and (work / JOURNAL).is_file()
    return False


def go_on(work: Path, out: Path) -> None:
    """Complete an interrupted swap; raise VbbenchError if another folder has taken a name meanwhile."""
    with plain_errors(out):
        _rename(work, out)
        _complete(work, out)


def is_done(work: Path) -> bool:
    """Whether the swap is complete, so that the rest of the work folder can be removed."""
    return (work / DONE).is_file()


def finish_swaps(folder: Path | str) -> None:
    """Before a folder is read: complete an interrupted swap of it, or of the dataset that its truth belongs to."""
    folder = real(folder)
    is_truth = folder.name.endswith(TRUTH) and folder.name != TRUTH
    for out in [folder, folder.with_name(folder.name.removesuffix(TRUTH))] if is_truth else [folder]:
        work, end = next_to(out, WORK), time.monotonic() + _PATIENCE
        while is_decided(work):
            try:
                with locked(work, out):
                    go_on(work, out)
                break
            except BusyError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.01)


def _steps(work: Path, out: Path) -> tuple[tuple[Path, Path, Path], ...]:
    """New folder, place of the old one, and name of each; truth first: no new dataset is ever next to an old truth."""
    return (work / NEW_TRUTH, work / OLD_TRUTH, real(next_to(out, TRUTH))), (work / NEW, work / OLD, out)


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
    """Move the carried files, and close the journal."""
    path = work / JOURNAL
    try:
        carried = list(map(str, json.loads(path.read_text("utf-8"))["carried"]))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise FileError(path, f"is damaged ({error!r}); look at what is in {work}, and remove that") from error
    for name in carried:
        old, new = work / OLD / Path(name).name, out / Path(name).name
        if os.path.lexists(old) and not os.path.lexists(new):
            old.replace(new)
    path.replace(work / DONE)


def _flush(folder: Path) -> None:
    """Write the names in a folder to disk, where the system can do so."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
