"""What a detector has found in a film so far, picture by picture, so that a search that was stopped goes on there.

A file beside the boxes: its first line says of what film and by what detector, each other line has the number of a
picture, and its boxes and scores, ``[0, [[left, top, width, height, score], …]]``. Lines from the first one on that is
not whole, or not the next, are made again.
"""

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import numpy as np

from vbbench import __version__
from vbbench.errors import FileError, plain_errors
from vbbench.exchange.detection import Detections
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.pictures.reading import Film
from vbbench.solving.provenance import source_digest

_KIND = "vbbench detections"


def key_of(film: Film, detector: str, weights: Path | None, period: float | None) -> str:
    """What must be the same for detections to be: film, detector with its code and network, and vbbench."""
    known = [__version__, detector, str(period), film.path.resolve()]
    for path in film.files or (film.path,):
        facts = path.stat()
        known += [path.name, facts.st_size, facts.st_mtime_ns]
    network = Path(detector) if detector.lower().endswith(".onnx") else weights
    known += [source_digest("yolo" if network is not None else detector, "detector")]
    known += [] if network is None else [file_sha256(network)]
    return hashlib.sha256(repr(known).encode()).hexdigest()


class KeptDetections:
    """The file, open.

    Attributes
    ----------
    found : of each picture so far.
    """

    def __init__(self, path: Path, file: IO[bytes], found: list[Detections]) -> None:
        self.found = found
        self._path, self._file = path, file

    def add(self, seen: Detections) -> None:
        """Keep what was found in the next picture."""
        rows = np.column_stack((seen.boxes, seen.scores)).tolist()
        with plain_errors(self._path):
            self._file.write(f"{json.dumps([len(self.found), rows])}\n".encode())
        self.found.append(seen)

    def remove(self) -> None:
        """Delete the file: all that it is good for is done."""
        self._file.close()
        self._path.unlink(missing_ok=True)


@contextmanager
def kept_detections(path: Path, key: str) -> Iterator[KeptDetections]:
    """The detections of that ``key`` in the file at ``path``, to be continued; none if it has those of another.

    Raises
    ------
    FileError
        If another file is there, or it cannot be written.
    """
    first = json.dumps({_KIND: key})
    with plain_errors(path):
        lines = path.read_text("utf-8", "replace").splitlines(keepends=True) if path.exists() else []
        if lines and not lines[0].startswith(f'{{"{_KIND}"'):
            raise FileError(path, "is in the way of detections that are kept there; move it")
        whole = lines[1:] if lines and lines[0] == first + "\n" else []
        found = list(_read(whole))
        write_text_atomically(path, "".join([first + "\n", *whole[: len(found)]]))
        file = path.open("ab", buffering=0)
    with file:
        yield KeptDetections(path, file, found)


def _read(lines: list[str]) -> Iterator[Detections]:
    """The detections of lines, up to the first one that is damaged."""
    for number, line in enumerate(lines):
        try:
            counted, found = json.loads(line)
            rows = np.array(found, np.float64).reshape(-1, 5)
        except (ValueError, TypeError):
            return
        if counted != number or not line.endswith("\n"):
            return
        yield Detections(boxes=rows[:, :4].copy(), scores=rows[:, 4].copy())
