"""Locks: one command at a time writes into a folder. The kernel releases a lock when its process ends in any way."""

import errno
import json
import os
import socket
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import IO, Any

from filelock import lock_descriptor

from vbbench.errors import VbbenchError, VbbenchWarning, one_line, plain_errors

LOCK = ".vbbench-lock"
"""File in a folder that a command writes into: locked by the kernel, and describing that command."""

HOLDS_OPEN_FILES = os.name == "nt"
"""Whether the system neither renames nor removes a file that is open, nor shows others the part that is locked."""

NO_LINKS = getattr(os, "O_NOFOLLOW", 0)
"""Flag of `os.open` that refuses links, where the system has it."""

_NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP}
_LONGEST = 200
"""Characters of a command line that are kept."""


class BusyError(VbbenchError):
    """Another command is writing there."""


@contextmanager
def locked(folder: Path | str, out: Path | str | None = None) -> Iterator[None]:
    """Create ``folder`` if needed, and hold its lock while the block runs; new folders that stay empty are removed.

    Raises BusyError if another command holds the lock, or one on another computer did not release it; FileError if
    nothing can be written there.

    Parameters
    ----------
    out : the folder's name in messages; by default its own path.
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
    """Lock an open file that others may read and write; whether it was free.

    A system that holds open files keeps others from what is locked, so nothing is locked there: it refuses to remove
    the file while it is open. Raises OSError if the file system has no locks.
    """
    return HOLDS_OPEN_FILES or lock_descriptor(handle, blocking=False)


def close_early(file: IO[Any]) -> None:
    """Close a file before it is renamed or removed, where the system asks for it; elsewhere its lock goes on."""
    if HOLDS_OPEN_FILES:
        file.close()


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
            handle = os.open(path, os.O_RDWR | os.O_CREAT | NO_LINKS, 0o666)
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
    """Remove the lock's file before it is unlocked: a process that waited for it sees that, and creates a new one.

    Where open files cannot be removed, another process that has it open keeps it.
    """
    with os.fdopen(handle, "rb+") as file, suppress(OSError):
        if is_file_at(handle, path):
            close_early(file)
            path.unlink()


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
    os.lseek(handle, 0, os.SEEK_SET)
    os.write(handle, b" " + json.dumps(owner).encode())


def _is_free(handle: int, out: Path) -> bool:
    try:
        return lock_descriptor(handle, blocking=False)
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
        message = f"the disk of {out} has no locks; let one command at a time write there"
        warnings.warn(message, VbbenchWarning, stacklevel=2)
    return True


def _read(handle: int) -> dict[str, Any]:
    """What the holder wrote; empty if it was stopped before that."""
    text = b""
    for start in (0, 1):  # where others are kept from what is locked, that is the first byte
        with suppress(PermissionError):
            os.lseek(handle, start, os.SEEK_SET)
            text = os.read(handle, 1 << 16)
            break
    try:
        values = json.loads(text)
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
