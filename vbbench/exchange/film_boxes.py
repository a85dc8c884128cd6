"""From a film to boxes: a detector on every picture, a tracker behind it, MOTChallenge text."""

from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.box_rows import BoxRows
from vbbench.exchange.detection import NOBODY, Detector, TrackerFactory, make_detector, rows_of_tracks
from vbbench.exchange.kept_detections import KeptDetections, kept_detections, key_of
from vbbench.exchange.mot import write_mot
from vbbench.folders.swapping import beside
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.reading import Film
from vbbench.registry import load

FEWEST_BOXES = 3
"""Shorter tracks are left out: they are false alarms more often than people."""


@dataclass(frozen=True, kw_only=True)
class FilmBoxes:
    """What was found in a film.

    Parameters
    ----------
    path : the boxes, MOTChallenge text; frame 1 is the film's first.
    dt : seconds per frame of the film.
    frames : number of its pictures.
    first, step : the film's frame, from 0, of the first boxes, and from one with boxes to the next.
    detections, boxes, tracks : numbers of what the detector found, of what the tracker kept of it, and of its tracks.
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
    weights: Path | None = None,
    tracker: str = "byte",
    every: int = 1,
    period: float | None = None,
) -> FilmBoxes:
    """Detect and track people in a film and write their boxes; a search that was stopped goes on where it was.

    Parameters
    ----------
    film : the film.
    out : text file to write.
    fps : frames per second, in place of what the film says of itself.
    detector, weights : see `vbbench.exchange.detection.make_detector`.
    tracker : a registered name, or ``module:attribute`` of a `vbbench.exchange.detection.TrackerFactory`.
    every : write only every so many frames. Detector and tracker see all of them: people must be near where they were.
    period : width in px of pictures that close on themselves, a panorama's.

    Raises
    ------
    VbbenchError
        If nothing says how fast the film is, a name or file is wrong, or nobody is found.
    """
    rate = fps or film.fps
    if rate is None:
        raise FileError(film.path, "does not say how many frames a second it has; write fps in camera.toml")
    if every < 1:
        raise VbbenchError(f"every must be at least 1 frame, not {every}")
    finder = make_detector(detector, weights)
    factory: TrackerFactory = load("tracker", tracker)
    with kept_detections(beside(out, ".detections"), key_of(film, detector, weights, period)) as kept:
        _detect(film, finder, kept, period)
        linking, detections = factory(dt=1.0 / rate, period=period), sum(len(one.scores) for one in kept.found)
        found = [linking.step(one) for one in kept.found]
        rows = _lasting(rows_of_tracks(np.arange(len(found)), found), every)
        if len(rows.frame):
            write_mot(out, rows)
        kept.remove()
    if not len(rows.frame):
        if not detections:
            raise FileError(film.path, f"{weights or detector} finds nobody in {len(found)} pictures; {NOBODY}")
        advice = "a better detector (--detector FILE.onnx) or a film with people nearer may help"
        raise FileError(film.path, f"{detector} finds {detections} boxes, and none of them lasts; {advice}")
    shown = np.unique(rows.frame)
    return FilmBoxes(
        path=out,
        dt=1.0 / rate,
        frames=len(found),
        first=int(shown[0]),
        step=int(np.gcd.reduce(np.diff(shown))) if len(shown) > 1 else 1,
        detections=detections,
        boxes=len(rows.frame),
        tracks=len(np.unique(rows.track)),
    )


def _detect(film: Film, finder: Detector, kept: KeptDetections, period: float | None) -> None:
    """Find people in the pictures of which nothing is kept yet."""
    with progress_bar(film.frames, "detecting", unit="frame") as bar:
        bar.update(len(kept.found))
        for picture in islice(film.pictures(), len(kept.found), None):
            kept.add(finder.detect(picture, period))
            bar.update()


def _lasting(rows: BoxRows, every: int) -> BoxRows:
    """The boxes of every ``every``-th frame, of tracks that last."""
    _, column, count = np.unique(rows.track, return_inverse=True, return_counts=True)
    return rows.select((count[column] >= FEWEST_BOXES) & (rows.frame % every == 0))
