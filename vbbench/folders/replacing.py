"""Files that are written completely or not at all: under a temporary name, then renamed."""

import os
import re
import secrets
import stat
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from vbbench.errors import FileError, VbbenchError, plain_errors
from vbbench.folders.locks import LOCK, NO_LINKS, close_early, is_file_at, lock_file, loose_files

_NAME = re.compile(r"\..*\.vbbench-[0-9a-f]{8}(\.\w+)?", re.DOTALL)
_LONGEST = 48
"""Characters of a file's name that its temporary name repeats: names may have up to 255 bytes."""


@contextmanager
def replacing(path: Path | str, suffix: str = "") -> Iterator[Path]:
    """A temporary name next to ``path``; the file written there becomes ``path`` when the block ends without error.

    If ``path`` is a link, its target is replaced. A device or pipe is written to directly. Temporary files that stopped
    processes left in the folder are removed.

    Raises FileError if nothing can be written there, or the disk is full; an earlier file is intact.

    Parameters
    ----------
    suffix : ending of the temporary name, for writers that depend on it.
    """
    path = Path(path)
    with plain_errors(path):
        if _is_stream(path):
            yield path
            return
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise FileError(path, "is a folder; give the name of a file")
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_stale(target.parent)
        temporary, handle = _new_file(target, suffix)
    with os.fdopen(handle, "rb+") as file:
        try:
            with plain_errors(path, temporary):
                yield temporary
                os.fsync(handle)
                close_early(file)
                temporary.replace(target)
        finally:
            close_early(file)
            temporary.unlink(missing_ok=True)


def write_to_stream(path: Path, data: bytes) -> bool:
    """Write to ``path`` if it is this process's stdout or stderr, after earlier output; return whether it is."""
    for number, stream in ((1, sys.stdout), (2, sys.stderr)):
        with suppress(OSError):
            if os.path.samestat(path.stat(), os.fstat(number)):
                stream.flush()
                with plain_errors(path), os.fdopen(os.dup(number), "wb") as file:
                    file.write(data)
                return True
    return False


def is_temporary(path: Path) -> bool:
    """Whether this is a temporary name of `replacing`."""
    return _NAME.fullmatch(path.name) is not None


def _is_stream(path: Path) -> bool:
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _new_file(target: Path, suffix: str) -> tuple[Path, int]:
    """A new file next to ``target``, and its handle, locked while this process writes it."""
    while True:
        name = f".{target.name[:_LONGEST]}.vbbench-{secrets.token_hex(4)}{suffix}"
        temporary = target.with_name(name)
        handle = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        ours = True
        with suppress(OSError):  # a disk without locks: files left there are not removed
            ours = lock_file(handle)
        if ours and is_file_at(handle, temporary):
            return temporary, handle
        os.close(handle)


def is_unused(folder: Path) -> bool:
    """Whether a folder does not exist, or holds only what a command left that was stopped at its beginning."""
    if not folder.is_dir():
        return not folder.exists()
    return all(path.name == LOCK or is_temporary(path) for path in folder.iterdir())


@cache
def _remove_stale(folder: Path) -> None:
    """Remove temporary files that stopped processes left in a folder, once per folder."""
    with suppress(OSError):
        for path in filter(is_temporary, list(folder.iterdir())):
            with suppress(OSError):
                _remove_if_stale(path)


def _remove_if_stale(path: Path) -> None:
    with os.fdopen(os.open(path, os.O_RDWR | NO_LINKS), "rb+") as file:
        if lock_file(file.fileno()) and is_file_at(file.fileno(), path):
            close_early(file)
            path.unlink()


def write_text_atomically(path: Path, text: str) -> None:
    """Write a small text file completely or not at all."""
    write_bytes_atomically(path, text.encode())


def copy_templates(folder: Path, templates: Mapping[str, Path]) -> list[Path]:
    """Copy text files, given by their new names, into ``folder``, created if necessary; return the paths of the copies.

    Raises VbbenchError if ``folder`` is a file, a dataset or a submission, or holds a changed copy.
    """
    texts = {folder / name: path.read_text("utf-8") for name, path in sorted(templates.items())}
    with loose_files(folder):
        for path, text in texts.items():
            if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
                raise VbbenchError(f"{path} exists and may be yours; choose another folder")
        for path, text in texts.items():
            write_text_atomically(path, text)
    return [*texts]


def write_bytes_atomically(path: Path, data: bytes) -> None:
    """Write a file completely or not at all; to a device, a pipe or this process's own output directly."""
    if not write_to_stream(path, data):
        with replacing(path) as temporary:
            temporary.write_bytes(data)
