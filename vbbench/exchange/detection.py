"""Interfaces of detectors and trackers, and detection on a sequence's rendered pictures."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from vbbench.boxes import rectangles
from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.exchange.matching import match_boxes
from vbbench.exchange.mot import write_mot
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray, freeze
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of, silent
from vbbench.registry import load
from vbbench.sequence import Sequence


@dataclass(frozen=True, kw_only=True)
class Detections:
    """The detections of one picture.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px, 0 the picture's left and top edge.
    scores : [N] from 0 to 1: approximate probability that a box is of a person.
    """

    boxes: FloatArray
    scores: FloatArray

    def __post_init__(self) -> None:
        freeze(self, boxes=(None, 4))
        freeze(self, scores=(len(self.boxes),))


class Detector(Protocol):
    """Finds people in pictures; its class is called without arguments, or with ``weights=FILE`` if a user names one."""

    def detect(self, rgb: NDArray[np.uint8], period: float | None = None) -> Detections:
        """People in a picture.

        Parameters
        ----------
        rgb : [H, W, 3] sRGB, row 0 at the top.
        period : width in px of a panorama; ``None`` for a picture with borders. Boxes on the panorama's seam may reach
            beyond it on either side.
        """


class Tracker(Protocol):
    """Links the detections of a sequence, frame after frame."""

    def step(self, detections: Detections) -> tuple[IntArray, Detections]:
        """Take the next frame's detections, and return the tracks seen in it: ids [N] and their boxes."""


class TrackerFactory(Protocol):
    """The type of an entry point of ``vbbench.trackers``."""

    def __call__(self, *, dt: float, period: float | None = None) -> Tracker:
        """A tracker of one sequence of ``dt`` seconds per frame; ``period`` as in `Detector.detect`."""


Rows = TypeVar("Rows", bound=BoxRows)


def rows_of_tracks(frames: IntArray, found: list[tuple[IntArray, Detections]]) -> BoxRows:
    """The results of a tracker in ``frames`` [T], ascending, one box a row, without visible fractions."""
    boxes, scores = (np.concatenate([getattr(one, name) for _, one in found]) for name in ("boxes", "scores"))
    frame = np.repeat(frames, [len(ids) for ids, _ in found])
    return rows_of(Path(), frame, np.concatenate([ids for ids, _ in found]), boxes, scores)


def link(rows: Rows, tracker: Tracker, frames: IntArray) -> Rows:
    """The boxes of detections linked by a tracker, which processes ``frames`` [T], ascending."""
    order = np.argsort(rows.frame, kind="stable")
    edges = (np.searchsorted(rows.frame[order], frames, side) for side in ("left", "right"))
    here = [order[first:last] for first, last in zip(*edges, strict=True)]
    found = [tracker.step(Detections(boxes=rows.boxes[one], scores=rows.scores[one])) for one in here]
    return replace(rows, **{**vars(rows_of_tracks(frames, found)), "path": rows.path})


NOBODY = "do they show people? docs/films.md says which networks are read, and how; another detector may find some"
"""What to look at where a detector finds nothing at all."""
TALL = 100.0
"""Height in px from which boxes are counted separately: what detectors of people are made for."""

SURE = 0.5
"""Score from which detections are counted separately: below it detectors report many false alarms, for trackers."""


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Detection counts: frames, boxes of the detector, boxes of people (and tall ones), and those that it found.

    ``sure`` counts its boxes with a score of `SURE` or more, ``sure_found`` people's boxes that these find.
    """

    frames: int = 0
    boxes: int = 0
    people: int = 0
    found: int = 0
    tall: int = 0
    tall_found: int = 0
    sure: int = 0
    sure_found: int = 0

    def __add__(self, other: "Tally") -> "Tally":
        return Tally(**{name: value + getattr(other, name) for name, value in vars(self).items()})

    def __str__(self) -> str:
        recall, precision = _share(self.found, self.people), _share(self.found, self.boxes)
        tall = f"{_share(self.tall_found, self.tall)} of those {TALL:g} px high and more"
        found = f"found {recall} of {self.people} boxes ({tall})"
        right = f"{self.frames} frames: {found}; {precision} of the {self.boxes} detections are right"
        share, sure_right = _share(self.sure_found, self.people), _share(self.sure_found, self.sure)
        return f"{right}; with scores of {SURE:g} and more: found {share}, {sure_right} of {self.sure} right"


def detect_to_file(
    dataset: Dataset,
    number: int,
    out: Path | str,
    *,
    detector: str = "hog",
    weights: Path | None = None,
    tracker: str | None = None,
    every: int = 1,
    backend: Backend | None = None,
    announce: Callable[[str], object] = silent,
) -> Tally:
    """Detect people in the rendered pictures of a sequence and write them as MOTChallenge text.

    Parameters
    ----------
    tracker : links the detections, a registered name or ``module:attribute`` of a `TrackerFactory`; ``None`` to write
        them unlinked.
    every : use only every so many frames.
    backend : the renderer; by default the best that works.
    announce : called once with a line that names the renderer.

    Returns
    -------
    The comparison with the boxes of the dataset's observations, at an overlap of 0.5 or more.
    """
    if every < 1:
        raise VbbenchError(f"every must be at least 1 frame, not {every}")
    if Path(out).is_dir():
        raise VbbenchError(f"{out} is a folder; give the name of a text file")
    sequence, finder = dataset.sequence(number), make_detector(detector, weights)
    camera, frames = dataset.camera(sequence), range(0, sequence.frames, every)
    period, linking = camera.period, None
    if tracker is not None:
        factory: TrackerFactory = load("tracker", tracker)
        linking = factory(dt=every * dataset.info.dt, period=period)
    found: list[Detections] = []
    with (
        open_renderer(backend or Backend(), scene_of(dataset, sequence.scene), announce) as renderer,
        progress_bar(len(frames), detector, unit="frame") as bar,
    ):
        for picture in pictures(dataset, sequence, renderer, frames):
            found.append(finder.detect(picture.rgb, period))
            bar.update()
    if not any(len(one.scores) for one in found):
        raise VbbenchError(f"{weights or detector} finds nobody in {len(found)} pictures; {NOBODY}")
    linked = [(np.full(len(one.scores), UNLINKED), one) if linking is None else linking.step(one) for one in found]
    write_mot(Path(out), rows_of_tracks(np.array(frames), linked))
    tallies = [_tally(sequence, frame, one, camera) for frame, one in zip(frames, found, strict=True)]
    return sum(tallies, start=Tally())


def make_detector(name: str, weights: Path | None = None) -> Detector:
    """A new detector.

    Parameters
    ----------
    name : a registered name, ``module:attribute`` of a `Detector`, or an ONNX file, which ``yolo`` then runs.
    weights : a file with the detector's network, for detectors that need one.
    """
    if name.lower().endswith(".onnx"):
        if weights is not None:
            raise VbbenchError(f"{name} and {weights} are two networks; name one")
        name, weights = "yolo", Path(name)
    elif ":" not in name and Path(name).is_file():
        raise VbbenchError(f"{name} is not an ONNX file; with Ultralytics: yolo export model={name} format=onnx")
    kind = load("detector", name)
    try:
        made: Detector = kind() if weights is None else kind(weights=weights)
    except TypeError as error:
        how = "without arguments" if weights is None else "with weights=FILE"
        raise VbbenchError(f"detector '{name}' is not a class that is called {how}: {error}") from error
    return made


def _tally(sequence: Sequence, frame: int, found: Detections, camera: Camera) -> Tally:
    there = rectangles(sequence.observations[frame, sequence.observed[frame]])
    _, partners = match_boxes(found.boxes, there, camera)
    tall, sure = there[:, 3] >= TALL, found.boxes[found.scores >= SURE]
    return Tally(
        frames=1,
        boxes=len(found.boxes),
        people=len(there),
        found=len(partners),
        tall=int(tall.sum()),
        tall_found=int(tall[partners].sum()),
        sure=len(sure),
        sure_found=len(match_boxes(sure, there, camera)[0]),
    )


def _share(part: int, whole: int) -> str:
    return f"{part / whole:.0%}" if whole else "none"
