"""Locks: one command at a time writes into a folder. The kernel releases a lock when its process ends in any way."""

import errno
import fcntl
import json
import os
import socket
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from vbbench.errors import VbbenchError, VbbenchWarning, one_line, plain_errors

LOCK = ".vbbench-lock"
"""File in a folder that a command writes into: locked with ``flock``, and describing that command."""

_BUSY = {errno.EWOULDBLOCK, errno.EACCES}
_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP}
_LONGEST = 200
"""Characters of a command line that are kept."""


class BusyError(VbbenchError):
    """Another command is writing there."""


@contextmanager
def locked(folder: Path | str, out: Path | str | None = None) -> Iterator[None]:
    """Create ``folder`` if needed, and hold its lock while the block runs; new folders that stay empty are removed.

    Parameters
    ----------
    out : the folder's name in messages; by default its own path.

    Raises
    ------
    BusyError
        If another command holds the lock, or one on another computer did not release it.
    FileError
        If nothing can be written there.
    """
    path, shown = Path(folder) / LOCK, Path(out or folder)
    made = [place for place in (path.parent, *path.parent.parents) if not os.path.lexists(place)]
    try:
        with plain_errors(shown):
            handle = _acquire(path, shown)
        try:
            yield
        finally:
            _release(handle, path)
    finally:
        with suppress(OSError):  # it is not empty
            for place in made:
                place.rmdir()


def lock_file(handle: int) -> bool:
    """Lock an open file; whether it was free. Raises OSError if its file system has no locks."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _BUSY:
            return False
        raise
    return True


def is_file_at(handle: int, path: Path) -> bool:
    """Whether the open file is still the one at ``path``."""
    try:
        return os.path.samestat(os.fstat(handle), path.lstat())
    except FileNotFoundError:
        return False


def _acquire(path: Path, out: Path) -> int:
    """Create the file ``path`` and its folder, lock it, and return its handle."""
    while True:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except FileExistsError:
            if not path.parent.is_dir() and os.path.lexists(path.parent):
                raise
        try:
            handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        except FileNotFoundError:
            continue  # its holder has just removed the folder
        try:
            _claim(handle, path, out)
        except BusyError:
            os.close(handle)
            raise
        except BaseException:
            _release(handle, path)
            raise
        if is_file_at(handle, path):
            return handle
        os.close(handle)


def _release(handle: int, path: Path) -> None:
    """Remove the lock's file before it is unlocked: a process that waited for it sees that, and creates a new one."""
    with suppress(OSError):
        if is_file_at(handle, path):
            path.unlink()
    os.close(handle)


def _claim(handle: int, path: Path, out: Path) -> None:
    free, holder = _is_free(handle, out), _read(handle)
    if not free:
        raise BusyError(
            f"{out} is being written by {_described(holder)}; wait until it is done, or choose another folder"
        )
    if holder.get("host", socket.gethostname()) != socket.gethostname():
        raise BusyError(
            f"{out} may be in use by {_described(holder)}; if that has ended, remove {path} and run this again"
        )
    command = " ".join([Path(sys.argv[0]).name, *sys.argv[1:]])[:_LONGEST]
    since = datetime.now().astimezone().isoformat(" ", "seconds")
    owner = {"host": socket.gethostname(), "process": os.getpid(), "since": since, "command": command}
    os.ftruncate(handle, 0)
    os.pwrite(handle, json.dumps(owner).encode(), 0)


def _is_free(handle: int, out: Path) -> bool:
    try:
        return lock_file(handle)
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
        message = f"the disk of {out} has no locks; let one command at a time write there"
        warnings.warn(message, VbbenchWarning, stacklevel=2)
    return True


def _read(handle: int) -> dict[str, Any]:
    """What the holder wrote; empty if it was stopped before that."""
    try:
        values = json.loads(os.pread(handle, 1 << 16, 0))
    except ValueError:
        return {}
    return values if isinstance(values, dict) else {}


def _described(holder: dict[str, Any]) -> str:
    if not holder:
        return "another command"
    known = {name: one_line(str(holder.get(name)), _LONGEST) for name in ("process", "host", "since", "command")}
    return "process {process} on {host} since {since} ({command})".format(**known)


@contextmanager
def loose_files(folder: Path) -> Iterator[None]:
    """Lock ``folder`` to write single files into it while the block runs.

    Raises VbbenchError if it is a file, a dataset or a submission, or another command writes there.
    """
    if folder.exists() and not folder.is_dir():
        raise VbbenchError(f"{folder} is not a folder; choose another place to write to")
    for marker in ("dataset.json", "submission.json"):
        if (folder / marker).is_file():
            raise VbbenchError(f"{folder} is a {marker.removesuffix('.json')}; choose another folder to write to")
    with locked(folder):
        yield
