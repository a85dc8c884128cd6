"""Untrusted zip archives, read in memory and never unpacked to disk.

An archive is refused if any member has an unsafe path, is a link, occurs twice or is encrypted; sizes are limited
before and after reading.
"""

import posixpath
import re
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BufferedReader, FileIO
from pathlib import Path

from vbbench.errors import FileError

_MB = 2**20


@dataclass(frozen=True, kw_only=True)
class Limits:
    """The largest archive that is accepted.

    Parameters
    ----------
    members : most members.
    directory_bytes : most bytes of its list of members.
    member_bytes : most unpacked bytes of a member that is read.
    ratio : most unpacked bytes per packed byte of such a member; text has 3 to 15.
    """

    members: int = 100_000
    directory_bytes: int = 32 * _MB
    member_bytes: int = 256 * _MB
    ratio: float = 200.0


@dataclass(frozen=True)
class Archive:
    """An open archive whose list of members has been checked."""

    path: Path
    limits: Limits
    _zip: zipfile.ZipFile

    @property
    def names(self) -> list[str]:
        """Paths of the members that are files, with ``/``, in the archive's order."""
        return [info.filename for info in self._zip.infolist() if not info.is_dir()]

    def read(self, name: str) -> bytes:
        """The content of a member.

        Raises FileError if it is larger, or packed tighter, than `limits` allow, packed by an unusual method, or
        damaged.
        """
        info = self._zip.getinfo(name)
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise self._refused(info, f"is packed by method {info.compress_type}; pack it by deflate, as zip does")
        if info.file_size > self.limits.member_bytes:
            raise self._refused(info, f"unpacks to {info.file_size} bytes, more than {self.limits.member_bytes}")
        if info.file_size > self.limits.ratio * max(info.compress_size, 1):
            ratio = info.file_size / max(info.compress_size, 1)
            raise self._refused(info, f"grows {ratio:.0f} times by unpacking, more than {self.limits.ratio:g} times")
        try:
            with self._zip.open(info) as member:
                content = member.read(info.file_size + 1)
        except _DAMAGE as error:
            raise self._refused(info, f"cannot be unpacked: {_first_line(error)}; get the archive again") from error
        if len(content) != info.file_size:
            raise self._refused(info, f"does not unpack to the {info.file_size} bytes it says; get the archive again")
        return content

    def _refused(self, info: zipfile.ZipInfo, problem: str) -> FileError:
        return FileError(self.path, f"its member {info.filename!r} {problem}")


@contextmanager
def open_archive(path: Path, limits: Limits | None = None) -> Iterator[Archive]:
    """Open a zip archive, and check all its members before any is read.

    Raises FileError if it cannot be read, is not a complete zip archive, or has too many members or a suspicious one.
    """
    limits = limits or Limits()
    try:
        raw = _Cautious(FileIO(path), limits.directory_bytes)
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    with raw:
        try:
            archive = zipfile.ZipFile(raw)
        except _DAMAGE as error:
            problem = f"is not a complete zip archive ({_first_line(error)}): damaged or cut short; get it again"
            raise FileError(path, problem) from error
        with archive:
            _check_members(path, archive.infolist(), limits)
            yield Archive(path, limits, archive)


_DAMAGE = (zipfile.BadZipFile, zlib.error, OSError, EOFError, ValueError, RuntimeError, MemoryError)
"""Exceptions of the library for damaged archives."""
_KINDS = (0, stat.S_IFREG, stat.S_IFDIR)
"""Accepted file types of a member; archives from Windows state none (0)."""


class _Cautious(BufferedReader):
    """A file that refuses to read more than ``most`` bytes at once, as for a huge list of members."""

    def __init__(self, raw: FileIO, most: int) -> None:
        super().__init__(raw)
        self._most = most

    def read(self, size: int | None = -1, /) -> bytes:
        """Read at most the allowed bytes."""
        if size is not None and size > self._most:
            raise zipfile.BadZipFile(f"its list of members is said to have {size} bytes")
        return super().read(size)


def _check_members(path: Path, members: list[zipfile.ZipInfo], limits: Limits) -> None:
    if len(members) > limits.members:
        raise FileError(path, f"has {len(members)} members, more than {limits.members}")
    known: set[str] = set()
    for info in members:
        name = posixpath.normpath(info.filename.replace("\\", "/"))
        problem = _problem(info, name)
        if name in known:
            problem = "is there twice"
        if problem is not None:
            raise FileError(path, f"its member {info.filename!r} {problem}; nothing of the archive is used")
        known.add(name)


def _problem(info: zipfile.ZipInfo, name: str) -> str | None:
    """Why a member is suspicious; ``None`` if it is not."""
    if not info.filename:
        return "has no name"
    if name.startswith("/") or re.match("[A-Za-z]:", name):
        return "has an absolute path"
    if ".." in name.split("/"):
        return "has a path that climbs out of the archive"
    if stat.S_IFMT(info.external_attr >> 16) not in _KINDS:
        return "is a link or another special file"
    if info.flag_bits & 0x1:
        return "is encrypted"
    return None


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0] or type(error).__name__
