"""Finds a recording of Head Tracking 21: in its folder, somewhere below a folder, or in the published zip archive."""

import hashlib
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from vbbench.errors import FileError, VbbenchError
from vbbench.generation.archives import open_archive
from vbbench.generation.sources import Source, find_source, locate

SEQINFO, BOXES = "seqinfo.ini", "gt/gt.txt"
_PUBLISHED = re.compile(r"HT21-\d\d")


@dataclass(frozen=True)
class TextFile:
    """A file that has been read, wherever it stood.

    Parameters
    ----------
    path : what messages call it; of a member of an archive, its path within that after the archive's own.
    content : its bytes.
    """

    path: Path
    content: bytes

    @property
    def sha256(self) -> str:
        """SHA-256 of its bytes."""
        return hashlib.sha256(self.content).hexdigest()


@dataclass(frozen=True)
class RecordingFiles:
    """The two files of a recording that count; from the archive and from the folder they are the same bytes."""

    seqinfo: TextFile
    boxes: TextFile

    @property
    def sums(self) -> list[tuple[str, str]]:
        """Name and SHA-256 of each."""
        return [(SEQINFO, self.seqinfo.sha256), (BOXES, self.boxes.sha256)]


def find_recording(name: str, archive: Source, explicit: Path | None, *, split: str) -> RecordingFiles:
    """Read the files of the recording ``name``.

    Parameters
    ----------
    name : the folder that holds it, such as ``HT21-03``.
    archive : the published archive, which is taken where the user names nothing; its checksum must be right.
    explicit : what the user names: the recording's folder, whatever it is called; a folder that holds one called
        ``name`` anywhere below, or the published archive; or an archive, whatever its bytes.
    split : for messages.

    Raises
    ------
    SourceMissingError
        If the user names nothing, and the archive is not on this machine.
    VbbenchError
        If there is no such recording, more than one, or its files cannot be read.
    """
    if explicit is None:
        (path,) = locate([archive], split=split)
        return _from_archive(path, name)
    if explicit.is_file():
        return _from_archive(explicit, name)
    if not explicit.is_dir():
        raise VbbenchError(f"{explicit}: there is no such file or folder")
    if (explicit / SEQINFO).is_file():
        return _from_own_folder(explicit, name, split)
    folders = [folder.relative_to(explicit).as_posix() for folder in _folders_below(explicit, name)]
    if folders:
        return _from_folder(explicit / _the_one(explicit, folders, name))
    packed = find_source(archive, explicit)
    if packed is not None and packed.is_relative_to(explicit):
        (path,) = locate([archive], packed, split=split)
        return _from_archive(path, name)
    raise FileError(explicit, f"holds neither {name} (a folder with {SEQINFO} and {BOXES}) nor {archive.file_name}")


def _from_own_folder(folder: Path, name: str, split: str) -> RecordingFiles:
    called = folder.resolve().name
    if _PUBLISHED.fullmatch(called) and called != name:
        raise FileError(folder, f"is another recording: {split} is made from {name}")
    return _from_folder(folder)


def _folders_below(root: Path, name: str) -> list[Path]:
    """Folders called ``name`` that hold a recording; links are not followed."""
    return [Path(at) for at, _, files in os.walk(root) if Path(at).name == name and SEQINFO in files]


def _from_folder(folder: Path) -> RecordingFiles:
    def read(name: str) -> TextFile:
        path = folder / name
        try:
            return TextFile(path, path.read_bytes())
        except OSError as error:
            raise FileError(path, f"cannot be read: {error.strerror}") from error

    return RecordingFiles(read(SEQINFO), read(BOXES))


def _from_archive(path: Path, name: str) -> RecordingFiles:
    with open_archive(path) as archive:
        members = {member.replace("\\", "/"): member for member in archive.names}
        infos = [PurePosixPath(member) for member in members if PurePosixPath(member).name == SEQINFO]
        folders = [str(info.parent) for info in infos if info.parent.name == name]
        if not folders:
            raise FileError(path, f"holds no {name}: no folder of that name with {SEQINFO} and {BOXES}")
        folder = _the_one(path, folders, name)
        if f"{folder}/{BOXES}" not in members:
            raise FileError(path / folder / BOXES, "is missing in the archive")

        def read(member: str) -> TextFile:
            return TextFile(path / folder / member, archive.read(members[f"{folder}/{member}"]))

        return RecordingFiles(read(SEQINFO), read(BOXES))


def _the_one(place: Path, folders: Iterable[str], name: str) -> str:
    found = sorted(folders)
    if len(found) > 1:
        raise FileError(place, f"holds {name} more than once: {', '.join(found)}; name one of them with --source")
    return found[0]
