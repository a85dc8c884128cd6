"""Finds the source files of splits on this machine, checks them, and downloads what is missing.

Searched in this order: what the user names, the folder ``$VBBENCH_DATA``, the user's cache folder. Wherever a file is
found, its SHA-256 must be the recipe's, so that a dataset follows from the same bytes on every machine.
"""

import os
import sys
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.files.tables import file_sha256
from vbbench.generation.download import ResumingDownload

DATA_VARIABLE = "VBBENCH_DATA"
TIMEOUT = 30
"""Seconds without an answer after which a download is given up."""

# By name, because requests is slow to import.
_REASONS = {
    "ValueError": "what came is damaged or another file (wrong SHA-256)",
    "ChunkedEncodingError": "the download was cut short; what came is kept, and fetching again goes on from there",
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
    size : number of its bytes, where it is known; no more is downloaded.
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
    """Where downloads go: ``$VBBENCH_DATA`` where that is set, else the user's cache folder."""
    return data_folders()[0]


def data_folders() -> list[Path]:
    """Where source files are looked for: ``$VBBENCH_DATA`` where that is set, and the user's cache folder."""
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
    """Whether the right bytes are on this machine, in one of the usual places."""
    return _find_verified(source) is not None


def locate(sources: Sequence[Source], explicit: Path | None = None, *, split: str = "SPLIT") -> list[Path]:
    """The files of ``sources``, in order, each with its checksum verified.

    Raises
    ------
    SourceMissingError
        If any is missing; says how ``vbbench fetch`` gets them, and what to do without a network.
    FileError
        If a file has the wrong checksum.
    VbbenchError
        If ``explicit`` does not exist, or is a single file where several are needed.
    """
    _check_explicit(sources, explicit)
    found = [(source, find_source(source, explicit)) for source in sources]
    missing = [source for source, path in found if path is None]
    if missing:
        raise _missing(missing, explicit, split)
    return [_verified(source, path) for source, path in found if path is not None]


def fetch(sources: Iterable[Source], folder: Path | None = None, *, progress: bool | None = None) -> list[Path]:
    """Download what is not here yet; a file gets its name only when it is whole and its checksum is right.

    Parameters
    ----------
    sources : the files wanted.
    folder : where they go; by default ``data_folder()``, and files found in any of the usual places are kept there.
    progress : whether to draw a bar on stderr; by default only on a terminal.

    Raises
    ------
    VbbenchError
        At the first file that cannot be had; names file and address, and says what to do without a network.
    """
    show = sys.stderr.isatty() if progress is None else progress
    return [_fetch_one(source, folder, show) for source in sources]


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


def _check_explicit(sources: Sequence[Source], explicit: Path | None) -> None:
    if explicit is None:
        return
    if not explicit.exists():
        raise VbbenchError(f"{explicit}: there is no such file or folder")
    if explicit.is_file() and len(sources) > 1:
        names = ", ".join(source.path for source in sources)
        raise VbbenchError(f"{explicit} is one file, but {names} are needed: name the folder that holds them")


def _missing(missing: Sequence[Source], explicit: Path | None, split: str) -> SourceMissingError:
    places = [*([explicit] if explicit is not None else []), *data_folders()]
    by_hand = ", ".join(f"{source.url} as {data_folder() / source.path}" for source in missing)
    return SourceMissingError(
        f"source files of {split} are missing (searched {', '.join(map(str, places))}): run 'vbbench fetch {split}', "
        f"set ${DATA_VARIABLE} to the folder that holds them, or download elsewhere and save {by_hand}"
    )


def _fetch_one(source: Source, folder: Path | None, show: bool) -> Path:
    present = _find_verified(source) if folder is None else None
    if present is not None:
        return present
    target = (data_folder() if folder is None else folder) / source.path
    if target.is_file():
        if file_sha256(target) == source.sha256:
            return target
        warnings.warn(f"{target} has the wrong checksum and is downloaded again", VbbenchWarning, stacklevel=3)
    download = ResumingDownload(target, source.sha256, most=source.size, timeout=TIMEOUT, progress=show)
    try:
        download.fetch(source.url)
    except (OSError, ValueError) as error:
        raise _failed(source, target, error) from error
    return target


def _failed(source: Source, target: Path, error: Exception) -> VbbenchError:
    reason = _REASONS.get(type(error).__name__, str(error))
    return VbbenchError(
        f"{source.path} could not be fetched from {source.url}: {reason}. Nothing else was changed. Try again, or "
        f"download that address elsewhere and save it as {target} (${DATA_VARIABLE} names the data folder)"
    )
