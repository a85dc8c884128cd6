"""From a film to boxes: a detector on every picture, then a tracker; the result is MOTChallenge text.

Detections are kept in a file next to the boxes, from which an interrupted run continues. Its first line identifies the
film and the detector. Each other line has the number of a picture, and its boxes and scores,
``[0, [[left, top, width, height, score], …]]``. Lines from the first damaged one on are recomputed.
"""

import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchError, plain_errors
from vbbench.exchange.detection import NOBODY, Detections, TrackerFactory, make_detector, rows_of_tracks
from vbbench.exchange.mot import write_mot
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.work_folder import next_to
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.video import Film
from vbbench.registry import load
from vbbench.solving.provenance import source_digest
from vbbench.version import __version__

_KIND = "vbbench detections"


def key_of(film: Film, detector: str, period: float | None) -> str:
    """A key of everything that determines detections: film, detector with its code and network, and vbbench."""
    known = [__version__, detector, str(period), film.path.resolve()]
    for path in film.files or (film.path,):
        facts = path.stat()
        known += [path.name, facts.st_size, facts.st_mtime_ns]
    network = Path(detector) if detector.lower().endswith(".onnx") else None
    known += [source_digest("yolo" if network is not None else detector, "detector")]
    known += [] if network is None else [file_sha256(network)]
    return hashlib.sha256(repr(known).encode()).hexdigest()


@contextmanager
def kept_detections(path: Path, key: str) -> Iterator[tuple[list[Detections], Callable[[Detections], None]]]:
    """The detections of ``key`` that the file at ``path`` holds so far, by picture, and a function that adds the next.

    There are none if the file has another key. It is deleted at the end, unless there is an error.
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

    def add(seen: Detections) -> None:
        rows = np.column_stack((seen.boxes, seen.scores)).tolist()
        with plain_errors(path):
            file.write(f"{json.dumps([len(found), rows])}\n".encode())
        found.append(seen)

    with file:
        yield found, add
    path.unlink(missing_ok=True)


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


FEWEST_BOXES = 3
"""Shorter tracks are dropped: they are false alarms more often than people."""


@dataclass(frozen=True, kw_only=True)
class FilmBoxes:
    """The result of detection and tracking in a film.

    Parameters
    ----------
    path : the boxes, MOTChallenge text; frame 1 is the film's first.
    dt : seconds per frame of the film.
    frames : number of its pictures.
    first, step : first of the film's frames (from 0) with boxes, and their step.
    detections, boxes, tracks : numbers of detections, of boxes that the tracker kept, and of tracks.
    """

    path: Path
    dt: float
    frames: int
    first: int
    step: int
    detections: int
    boxes: int
    tracks: int

    def __str__(self) -> str:
        found = f"{self.frames} frames, {self.detections} detections"
        return f"{found}: the tracker keeps {self.boxes} boxes of {self.tracks} people"


def find_boxes(
    film: Film,
    out: Path,
    *,
    fps: float | None = None,
    detector: str = "hog",
    tracker: str = "byte",
    every: int = 1,
    period: float | None = None,
) -> FilmBoxes:
    """Detect and track people in a film and write their boxes; an interrupted run continues.

    Parameters
    ----------
    fps : frames per second, in place of the film's own.
    detector : see `vbbench.exchange.detection.make_detector`.
    tracker : a registered name, or ``module:attribute`` of a `vbbench.exchange.detection.TrackerFactory`.
    every : step of the frames that are written. Detector and tracker process all: tracking needs small motions.
    period : width in px of a panorama; ``None``: pictures have borders.
    """
    rate = fps or film.fps
    if rate is None:
        raise FileError(film.path, "does not say how many frames a second it has; write fps in camera.toml")
    if every < 1:
        raise VbbenchError(f"every must be at least 1 frame, not {every}")
    finder = make_detector(detector)
    factory: TrackerFactory = load("tracker", tracker)
    with kept_detections(next_to(out, ".detections"), key_of(film, detector, period)) as (seen, add):
        with progress_bar(film.frames, "detecting", unit="frame") as bar:
            bar.update(len(seen))
            for picture in islice(film.pictures(), len(seen), None):
                add(finder.detect(picture, period))
                bar.update()
        linking, detections = factory(dt=1.0 / rate, period=period), sum(len(one.scores) for one in seen)
        rows = rows_of_tracks(np.arange(len(seen)), [linking.step(one) for one in seen])
        _, column, count = np.unique(rows.track, return_inverse=True, return_counts=True)
        rows = rows.select((count[column] >= FEWEST_BOXES) & (rows.frame % every == 0))
        if len(rows):
            write_mot(out, rows)
    if not detections and not len(rows):
        raise FileError(film.path, f"{detector} finds nobody in {len(seen)} pictures; {NOBODY}")
    if not len(rows):
        advice = "a better detector (--detector FILE.onnx) or a film with people nearer may help"
        raise FileError(film.path, f"{detector} finds {detections} boxes, and none of them lasts; {advice}")
    shown = np.unique(rows.frame)
    return FilmBoxes(
        path=out,
        dt=1.0 / rate,
        frames=len(seen),
        first=int(shown[0]),
        step=int(np.gcd.reduce(np.diff(shown))) if len(shown) > 1 else 1,
        detections=detections,
        boxes=len(rows),
        tracks=len(np.unique(rows.track)),
    )
