"""From a film to a map: people are detected and tracked, and their boxes passed to `birdify`.

Detections are kept in a file next to the boxes, from which an interrupted run continues. Its first line identifies the
film and the detector. Each other line has the number of a picture, and its boxes and scores,
``[0, [[left, top, width, height, score], …]]``. Lines from the first damaged one on are recomputed.
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vbbench.birdify.birdify import Birdified, birdify
from vbbench.birdify.report import REPORT
from vbbench.errors import FileError, VbbenchError, plain_errors
from vbbench.exchange.detection import NOBODY, Detections, TrackerFactory, make_detector, rows_of_tracks
from vbbench.exchange.mot import write_mot
from vbbench.exchange.own.camera_file import find_camera, read_camera
from vbbench.exchange.trajectory import Axes
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.work_folder import check_free, next_to
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.rendering import silent
from vbbench.pictures.video import Film, open_film
from vbbench.registry import load
from vbbench.solving.provenance import source_digest
from vbbench.version import __version__

FEWEST_BOXES = 3
"""Shorter tracks are dropped: they are false alarms more often than people."""
OTHER_RATE = 0.02
"""Share by which the frame rates of camera file and film may differ without a word."""
_KIND = "vbbench detections"


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Options of detection and tracking.

    Parameters
    ----------
    detector : see `vbbench.exchange.detection.make_detector`.
    tracker : a registered name, or ``module:attribute`` of a `vbbench.exchange.detection.TrackerFactory`.
    every : step of the frames that are written. Detector and tracker process all: tracking needs small motions.
    """

    detector: str = "hog"
    tracker: str = "byte"
    every: int = 1


def birdify_film(
    path: Path | str,
    camera: Path | str,
    out: Path | str,
    detection: Detection,
    *,
    odometry: Path | str | None = None,
    odometry_axes: Axes | None = None,
    solver: str = "map-causal",
    film: bool = False,
    mount: Mapping[str, float | str] | None = None,
    overwrite: bool = False,
    announce: Callable[[str], object] = silent,
) -> Birdified:
    """Make a map from a film.

    Boxes are first written to ``OUT.boxes.txt``, which is removed once the map is complete (``OUT/recording/gt.txt``
    has the same). After a failure, `vbbench.birdify.birdify.birdify` can be called on this file.

    Raises VbbenchError if the film cannot be read or has another size than the camera, nobody is found, or `birdify`
    raises it.

    Parameters
    ----------
    path : a video, or a folder of pictures.
    camera : camera file; its ``fps`` or ``dt`` takes precedence over the video's.
    detection : options of detection and tracking.
    out, odometry, odometry_axes, solver, film, mount, overwrite, announce : as in `vbbench.birdify.birdify.birdify`.
    """
    out, shot, own = Path(out), open_film(Path(path)), read_camera(find_camera(Path(camera)), mount)
    load("solver", solver)  # nobody waits for boxes to hear that its name is wrong
    facts, fps = own.facts, None if own.facts.seconds is None else 1.0 / own.facts.seconds
    if (facts.width, facts.height or shot.height) != (shot.width, shot.height):
        said = f"{facts.width} x {facts.height or '?'} px"
        advice = "write the size of the film, with the focal length that belongs to it"
        raise FileError(own.path, f"says {said}, {shot.path} is {shot.width} x {shot.height}: {advice}")
    check_free(out, REPORT, "folder that birdify made", overwrite)
    if fps and shot.fps and abs(fps / shot.fps - 1.0) > OTHER_RATE:
        announce(f"{own.path} says {fps:.4g} frames a second, the film {shot.fps:.4g}: those of {own.path.name} count")
    boxes = next_to(out, ".boxes.txt")
    boxes.parent.mkdir(parents=True, exist_ok=True)
    announce(f"finding people with {detection.detector} in {shot.frames} frames")
    found, files = find_boxes(shot, boxes, detection, fps=fps, period=own.camera.period), shot.numbered()
    announce(found.summary)
    made = birdify(
        boxes,
        camera,
        out,
        odometry=odometry,
        odometry_axes=odometry_axes,
        solver=solver,
        film=film,
        mount=mount,
        dt=found.dt,
        name=shot.path.resolve().name if shot.files else shot.path.stem,
        pictures=files and replace(files, first=files.first + found.first, step=found.step),
        overwrite=overwrite,
        announce=announce,
    )
    boxes.unlink()
    return made


class FilmBoxes(NamedTuple):
    """What was found in a film of ``dt`` seconds per frame: its frames with boxes from ``first`` on, every ``step``."""

    dt: float
    first: int
    step: int
    summary: str


def find_boxes(
    film: Film, out: Path, detection: Detection, *, fps: float | None = None, period: float | None = None
) -> FilmBoxes:
    """Detect and track people in a film and write their boxes as MOTChallenge text, frame 1 the film's first.

    An interrupted run continues.

    Parameters
    ----------
    fps : frames per second, in place of the film's own.
    period : width in px of a panorama; ``None``: pictures have borders.
    """
    rate, detector, every = fps or film.fps, detection.detector, detection.every
    if rate is None:
        raise FileError(film.path, "does not say how many frames a second it has; write fps in camera.toml")
    if every < 1:
        raise VbbenchError(f"every must be at least 1 frame, not {every}")
    finder = make_detector(detector)
    factory: TrackerFactory = load("tracker", detection.tracker)
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
    shown, people = np.unique(rows.frame), len(np.unique(rows.track))
    summary = f"{len(seen)} frames, {detections} detections: the tracker keeps {len(rows)} boxes of {people} people"
    step = int(np.gcd.reduce(np.diff(shown))) if len(shown) > 1 else 1
    return FilmBoxes(1.0 / rate, int(shown[0]), step, summary)


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
