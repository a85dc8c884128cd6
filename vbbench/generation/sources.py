"""Finds the source files of splits on this machine, checks them, and downloads missing ones.

Search order: what the user names, the folder ``$VBBENCH_DATA``, the user's cache folder. The SHA-256 of every file must
be the recipe's, so that a dataset is made from the same bytes on every machine.
"""

import os
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import replacing
from vbbench.parallel.parts import progress_bar

DATA_VARIABLE = "VBBENCH_DATA"
TIMEOUT = 30
"""Seconds without an answer after which a download is given up."""
_CHUNK = 2**16
"""Bytes received at a time."""

# By name, because requests is slow to import.
_REASONS = {
    "ValueError": "what came is damaged or another file (wrong SHA-256)",
    "ChunkedEncodingError": "the download was cut short",
    "ConnectionError": "no connection to the server",
    "ConnectTimeout": f"the server did not answer in {TIMEOUT} s",
    "ReadTimeout": f"the server did not answer in {TIMEOUT} s",
}


@dataclass(frozen=True)
class Source:
    """One file that a split is made from.

    Parameters
    ----------
    path : where it belongs in the data folder, such as ``eth/biwi_eth.txt``.
    url : public address, pinned to one version.
    sha256 : 64 hex digits of the file's bytes.
    size : number of its bytes, if known; no more is downloaded.
    """

    path: str
    url: str
    sha256: str
    size: int | None = None

    @property
    def file_name(self) -> str:
        """The path without its folders."""
        return PurePosixPath(self.path).name


def data_folder() -> Path:
    """The folder for downloads: ``$VBBENCH_DATA`` if set, else the user's cache folder."""
    return data_folders()[0]


def data_folders() -> list[Path]:
    """The folders searched for source files: ``$VBBENCH_DATA`` if set, and the user's cache folder."""
    from platformdirs import user_cache_path

    chosen = os.environ.get(DATA_VARIABLE)
    return [*([Path(chosen).expanduser()] if chosen else []), user_cache_path("vbbench")]


def find_source(source: Source, explicit: Path | None = None) -> Path | None:
    """The first file found for ``source``, whatever its bytes; ``None`` if there is none.

    ``explicit`` is the file itself, or a folder that is searched first.
    """
    if explicit is not None and explicit.is_file():
        return explicit
    folders = [explicit] if explicit is not None else []
    candidates = (folder / name for folder in [*folders, *data_folders()] for name in (source.path, source.file_name))
    return next((path for path in candidates if path.is_file()), None)


def is_here(source: Source) -> bool:
    """Whether the file is in one of the data folders, with the right checksum."""
    return _find_verified(source) is not None


def locate(sources: Sequence[Source], explicit: Path | None = None, *, split: str = "SPLIT") -> list[Path]:
    """The files of ``sources``, in order, each with its checksum verified.

    Raises SourceMissingError if any is missing; says how ``vbbench fetch`` gets them, and what to do without a network;
    FileError if a file has the wrong checksum; VbbenchError if ``explicit`` does not exist, or is a single file where
    several are needed.
    """
    if explicit is not None and not explicit.exists():
        raise VbbenchError(f"{explicit}: there is no such file or folder")
    if explicit is not None and explicit.is_file() and len(sources) > 1:
        names = ", ".join(source.path for source in sources)
        raise VbbenchError(f"{explicit} is one file, but {names} are needed: name the folder that holds them")
    found = [(source, find_source(source, explicit)) for source in sources]
    missing = [source for source, path in found if path is None]
    if missing:
        places = [*([explicit] if explicit is not None else []), *data_folders()]
        by_hand = ", ".join(f"{source.url} as {data_folder() / source.path}" for source in missing)
        raise SourceMissingError(
            f"source files of {split} are missing (searched {', '.join(map(str, places))}): run 'vbbench fetch "
            f"{split}', set ${DATA_VARIABLE} to the folder that holds them, or download elsewhere and save {by_hand}"
        )
    return [_verified(source, path) for source, path in found if path is not None]


def fetch(sources: Iterable[Source]) -> list[Path]:
    """Download missing files to ``data_folder()``; a file gets its name only when its checksum has been verified.

    Raises VbbenchError at the first file that cannot be downloaded; names file and address, and says what to do without
    a network.
    """
    return [_find_verified(source) or _download(source) for source in sources]


def _verified(source: Source, path: Path) -> Path:
    actual = file_sha256(path)
    if actual != source.sha256:
        raise FileError(
            path,
            f"is not the expected {source.path}: its SHA-256 is {actual}, not {source.sha256}; "
            f"remove it and fetch it again, or download {source.url}",
        )
    return path


def _find_verified(source: Source) -> Path | None:
    path = find_source(source)
    return path if path is not None and file_sha256(path) == source.sha256 else None


def _download(source: Source) -> Path:
    target = data_folder() / source.path
    if target.is_file():
        warnings.warn(f"{target} has the wrong checksum and is downloaded again", VbbenchWarning, stacklevel=3)
    try:
        with replacing(target) as temporary:
            _receive(source, temporary)
    except (OSError, ValueError) as error:
        reason = _REASONS.get(type(error).__name__, str(error))
        raise VbbenchError(
            f"{source.path} could not be fetched from {source.url}: {reason}. Nothing else was changed. Try again, or "
            f"download that address elsewhere and save it as {target} (${DATA_VARIABLE} names the data folder)"
        ) from error
    return target


def _receive(source: Source, path: Path) -> None:
    """Download a file to ``path``.

    Raises OSError if the server cannot be reached or stops, ValueError if it sends too many bytes or other ones.
    """
    import requests

    with requests.get(source.url, stream=True, timeout=TIMEOUT, headers={"Accept-Encoding": "identity"}) as response:
        response.raise_for_status()
        total = response.headers.get("Content-Length")
        with path.open("wb") as file, progress_bar(None if total is None else int(total), None, unit="B") as bar:
            for chunk in response.iter_content(_CHUNK):
                file.write(chunk)
                bar.update(len(chunk))
                if source.size is not None and file.tell() > source.size:
                    raise ValueError(f"more than {source.size} bytes came")
    if file_sha256(path) != source.sha256:
        raise ValueError(f"its SHA-256 is not {source.sha256}")
