"""The folder ``OUT.partial`` in which ``OUT`` is made: locked, marked as ours, resumed, and swapped in whole.

    OUT.partial/.vbbench-lock       the command that is writing
    OUT.partial/vbbench-work.json   the mark: which work this is
    OUT.partial/parts               finished parts of it
    OUT.partial/new, new-truth      the future OUT and OUT.truth
    OUT.partial/swap.json           the journal, while they replace the old ones
    OUT.partial/old, old-truth      the old ones

A folder of that name without the mark is not ours and never touched.
"""

import json
import os
import re
import secrets
import shutil
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack, suppress
from hashlib import sha256
from pathlib import Path
from typing import Self

from vbbench.errors import FileError, VbbenchError, plain_errors
from vbbench.folders.locks import HOLDS_OPEN_FILES, LOCK, BusyError, locked
from vbbench.folders.replacing import is_temporary, is_unused, write_text_atomically
from vbbench.version import __version__

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


def swap(work: Path, out: Path) -> None:
    """Rename ``work/new`` to ``out``, and ``work/new-truth``, if it exists, to the name of its truth.

    The folders that had these names move into the work folder.

    Raises FileError if a folder cannot be renamed; nothing is changed.
    """
    (work / JOURNAL).touch()
    _flush(work)
    staged = [step for step in _steps(work, out) if step[0].exists()]
    try:
        _rename(work, out)
    except OSError as error:
        _undo(work, staged)
        raise FileError(out, f"cannot be replaced ({os.strerror(error.errno or 0)}); choose another place") from error
    (work / JOURNAL).replace(work / DONE)
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
        (work / JOURNAL).replace(work / DONE)


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


def _flush(folder: Path) -> None:
    """Write the names in a folder to disk, where the system can do so."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


PARTS = "parts"
NO_KEY = "0" * 16
_KEY = re.compile("[0-9a-f]{16}")


class WorkFolder:
    """The folder where another is made, in a ``with`` block; at its end all but published files and parts is removed.

    Parameters
    ----------
    out : the folder to make; if it is a link, its target is replaced.
    check : raises VbbenchError if ``out`` may not be replaced; called once the lock is held.

    Attributes
    ----------
    out : the folder itself, links followed.
    parts : folder for finished parts of the work.
    new, new_truth : the future ``out``, and its withheld truth.
    """

    def __init__(self, out: Path | str, check: Callable[[], None] = lambda: None) -> None:
        self.out, self._shown, self._check = real(out), Path(out), check
        self._work = next_to(self.out, WORK)
        self.parts, self.new, self.new_truth = (self._work / name for name in (PARTS, NEW, NEW_TRUTH))
        self._retired: list[Path] = []
        self._done: set[str] = set()
        self._placed = False
        self._lock = ExitStack()

    def __enter__(self) -> Self:
        with plain_errors(self._shown):
            _check_ours(self._work, self._shown)
            self._lock.enter_context(locked(self._work, self._shown))
        try:
            self._take_over()
            if not self._done:
                self._check()
        except BaseException:
            self._leave()
            raise
        return self

    def __exit__(self, *_failure: object) -> None:
        self._leave()

    def begin(self, key: str | None = None) -> bool:
        """Prepare for the work called ``key``; return whether it is still to be done.

        Finished parts of the same work are kept. If it was stopped after it had been published, nothing is left to do.
        Work without a key always starts new.
        """
        digest = secrets.token_hex(8) if key is None else sha256(key.encode()).hexdigest()[:16]
        if digest in self._done and self.out.exists():
            return False
        if self._done:
            self._check()
        resumed = _read_key(self._work) == digest
        kept = {LOCK, MARK, *([PARTS] if resumed else [])}
        _remove(path for path in self._work.iterdir() if path.name not in kept)
        _remove(filter(is_temporary, list(self._work.rglob("*"))))
        write_text_atomically(self._work / MARK, json.dumps({"vbbench": __version__, "key": digest}) + "\n")
        self._placed = False
        self.parts.mkdir(exist_ok=True)
        return True

    def publish(self) -> None:
        """Replace the old folder, and its truth, by the new ones; see `swap`."""
        swap(self._work, self.out)
        self._placed = True

    def _take_over(self) -> None:
        """Complete a stopped command's swap, and note which work had been published when it was stopped."""
        beginning = f".{self.out.name}.vbbench-done-"
        for path in self.out.parent.iterdir():
            if path.name.startswith(beginning) and _KEY.fullmatch(path.name.removeprefix(beginning)):
                self._retired.append(path)
                self._done.add(path.name.removeprefix(beginning))
        if is_decided(self._work):
            go_on(self._work, self.out)
        if (self._work / DONE).is_file():
            self._placed = True
            self._done.add(_read_key(self._work))

    def _leave(self) -> None:
        """Remove what is no longer needed, and release the lock."""
        has_parts = any(self.parts.glob("*.arrows"))
        if HOLDS_OPEN_FILES:  # nor does it rename a folder with one
            self._lock.close()
        if self._placed:
            self._retire()
        elif not (is_decided(self._work) or has_parts):
            _remove(path for path in self._work.iterdir() if path.name not in (LOCK, MARK))
            (self._work / MARK).unlink(missing_ok=True)
        self._lock.close()
        if not self._placed:
            with suppress(OSError):  # it has parts, or another command has begun to write there
                self._work.rmdir()
        for path in self._retired:
            shutil.rmtree(path, ignore_errors=True)

    def _retire(self) -> None:
        """Rename the work folder, in one step, to a name that says which work is done, before its files are removed."""
        retired = self.out.with_name(f".{self.out.name}.vbbench-done-{_read_key(self._work)}")
        shutil.rmtree(retired, ignore_errors=True)
        self._work.replace(retired)
        self._retired.append(retired)


def _check_ours(work: Path, out: Path) -> None:
    """Raise VbbenchError if there is a folder ``work`` that no command of vbbench made."""
    marked = (work / MARK).is_file() or is_unused(work)
    if os.path.lexists(work) and (work.is_symlink() or not marked):
        raise VbbenchError(
            f"{work} exists and was not made by vbbench, which needs that name to make {out}; move it away"
        )


def _read_key(work: Path) -> str:
    """Key of the work that the mark names; zeros if it cannot be read."""
    try:
        key = json.loads((work / MARK).read_text("utf-8"))["key"]
    except (OSError, ValueError, KeyError, TypeError):
        return NO_KEY
    return key if isinstance(key, str) and _KEY.fullmatch(key) else NO_KEY


def _remove(paths: Iterable[Path]) -> None:
    for path in list(paths):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def check_free(folder: Path, marker: str, what: str, overwrite: bool) -> None:
    """Raise VbbenchError if ``folder`` may not be replaced: only one with ``marker`` ever is."""
    if not folder.exists():
        return
    if not (folder / marker).is_file():
        raise VbbenchError(f"{folder} exists and is not a {what}; choose another folder or remove it")
    if not overwrite:
        raise VbbenchError(f"{folder} exists; set `overwrite` to replace it")
