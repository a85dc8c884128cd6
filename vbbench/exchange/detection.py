"""Interfaces of detectors and trackers."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import VbbenchError
from vbbench.exchange.box_rows import Boxes, BoxRows, rows_of
from vbbench.geometry import FloatArray, IntArray, freeze
from vbbench.registry import load


@dataclass(frozen=True, kw_only=True)
class Detections:
    """The detections of one picture.

    ``boxes`` [N, 4] are (left, top, width, height) in px, 0 the picture's left and top edge; ``scores`` [N] from 0 to
    1 are approximate probabilities that a box is of a person.
    """

    boxes: FloatArray
    scores: FloatArray

    def __post_init__(self) -> None:
        freeze(self, boxes=(None, 4))
        freeze(self, scores=(len(self.boxes),))


class Detector(Protocol):
    """Finds people in pictures; its class is called without arguments."""

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


def rows_of_tracks(frames: IntArray, found: list[tuple[IntArray, Detections]]) -> BoxRows:
    """The results of a tracker in ``frames`` [T], ascending, one box a row, without visible fractions."""
    boxes, scores = (np.concatenate([getattr(one, name) for _, one in found]) for name in ("boxes", "scores"))
    frame = np.repeat(frames, [len(ids) for ids, _ in found])
    return rows_of(Path(), frame, np.concatenate([ids for ids, _ in found]), boxes, scores)


def link(rows: Boxes, tracker: Tracker, frames: IntArray) -> Boxes:
    """The boxes of detections linked by a tracker, which processes ``frames`` [T], ascending."""
    order = np.argsort(rows.frame, kind="stable")
    edges = (np.searchsorted(rows.frame[order], frames, side) for side in ("left", "right"))
    here = [order[first:last] for first, last in zip(*edges, strict=True)]
    found = [tracker.step(Detections(boxes=rows.boxes[one], scores=rows.scores[one])) for one in here]
    return replace(rows, **{**vars(rows_of_tracks(frames, found)), "path": rows.path})


NOBODY = "do they show people? docs/films.md says which networks are read, and how; another detector may find some"
"""What to look at where a detector finds nothing at all."""


def make_detector(name: str) -> Detector:
    """A new detector.

    Parameters
    ----------
    name : a registered name, ``module:attribute`` of a `Detector`, or an ONNX file, which ``yolo`` then runs.
    """
    network = name.lower().endswith(".onnx")
    if not network and ":" not in name and Path(name).is_file():
        raise VbbenchError(f"{name} is not an ONNX file; with Ultralytics: yolo export model={name} format=onnx")
    kind = load("detector", "yolo" if network else name)
    try:
        made: Detector = kind(Path(name)) if network else kind()
    except TypeError as error:
        raise VbbenchError(f"detector '{name}' is not a class that is called without arguments: {error}") from error
    return made
