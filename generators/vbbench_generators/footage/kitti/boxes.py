"""Boxes of anybody's detector or tracker on KITTI's pictures, as they are in files.

Three kinds of text are read, told by their first line: detections with 15 columns and commas (frame, type, left, top,
right, bottom, score, …), KITTI's own label text with 17 columns or 18, and MOTChallenge text.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.mot.text import UNLINKED, read_mot
from vbbench.geometry import BoolArray, FloatArray, IntArray, frozen_array
from vbbench_generators.footage.kitti.labels import LABELS, MOST_FRAMES, RESULTS, parse_labels
from vbbench_generators.footage.kitti.text import Layout, first_cells, names, parse_rows, read_content

_DETECTED = names("frame type left top right bottom score height width length x y z rotation alpha")
DETECTIONS = Layout(columns=_DETECTED, wanted=_DETECTED[:7], commas=True)
TYPES = {1: "Pedestrian", 2: "Car", 3: "Cyclist"}
"""Classes of these detections."""

LEAST_SCORE = 0.0
"""Log-odds that a detection must have more of to count; even odds."""


@dataclass(frozen=True, kw_only=True)
class FoundBoxes:
    """Boxes of a detector or tracker, one a row.

    Parameters
    ----------
    path : the file, for messages.
    frame : [N] from 0.
    track : [N] ids, `UNLINKED` for detections.
    boxes : [N, 4] (left, top, width, height) in px.
    scores : [N] from 0 to 1.
    lines : [N] line numbers.
    """

    path: Path
    frame: IntArray
    track: IntArray
    boxes: FloatArray
    scores: FloatArray
    lines: IntArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        for name in ("frame", "track", "lines"):
            object.__setattr__(self, name, frozen_array(name, getattr(self, name), (count,), np.int64))
        object.__setattr__(self, "boxes", frozen_array("boxes", self.boxes, (count, 4)))
        object.__setattr__(self, "scores", frozen_array("scores", self.scores, (count,)))

    def __len__(self) -> int:
        return len(self.frame)


def read_boxes(path: Path, frames: int, classes: tuple[str, ...]) -> FoundBoxes:
    """Read boxes of ``classes`` in the pictures of a recording of ``frames`` frames; sure enough ones alone.

    Raises
    ------
    FileError
        At the first row that cannot be.
    """
    content = read_content(path, "boxes on the pictures")
    count = len(first_cells(content, LABELS))
    if count in (len(LABELS.columns), len(RESULTS.columns)):
        found = _from_labels(path, content, classes)
    elif len(first_cells(content, DETECTIONS)) == len(DETECTIONS.columns):
        found = _from_detections(path, content, classes)
    else:
        found = _from_mot(path, frames)
    late = found.frame >= frames
    if late.any():
        row = int(late.argmax())
        problem = f"frame {found.frame[row]} is beyond the recording of {frames} frames, from 0"
        raise FileError(path, problem, int(found.lines[row]))
    if not len(found):
        raise FileError(path, "holds no box of a person that is sure enough")
    return found


def _from_detections(path: Path, content: bytes, classes: tuple[str, ...]) -> FoundBoxes:
    rows = parse_rows(path, content, DETECTIONS)
    frame = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    corners = rows.numbers("left", "top", "right", "bottom")
    sizes = corners[:, 2:] - corners[:, :2]
    rows.refuse((sizes[:, 0] <= 0.0) | (sizes[:, 1] <= 0.0), "the box is {0:g} x {1:g} px; leave it out", *sizes.T)
    wanted = np.isin(rows.columns["type"], [number for number, name in TYPES.items() if name in classes])
    scores, sure = _chances(rows.columns["score"])
    kept = wanted & sure
    return FoundBoxes(
        path=path,
        frame=frame[kept],
        track=np.full(int(kept.sum()), UNLINKED),
        boxes=np.concatenate([corners[:, :2], sizes], axis=-1)[kept],
        scores=scores[kept],
        lines=rows.lines[kept],
    )


def _from_labels(path: Path, content: bytes, classes: tuple[str, ...]) -> FoundBoxes:
    labels = parse_labels(path, content).of(classes)
    scores, sure = _chances(labels.scores)
    labels, scores = labels.take(sure), scores[sure]
    _refuse_mixture(path, labels.track, labels.lines)
    corners = labels.boxes
    return FoundBoxes(
        path=path,
        frame=labels.frame,
        track=np.where(labels.track < 0, UNLINKED, labels.track),
        boxes=np.concatenate([corners[:, :2], corners[:, 2:] - corners[:, :2]], axis=-1),
        scores=scores,
        lines=labels.lines,
    )


def _from_mot(path: Path, frames: int) -> FoundBoxes:
    rows = read_mot(path, frames)
    scores, sure = _chances(rows.confidence)
    _refuse_mixture(path, rows.track[sure], rows.line[sure])
    return FoundBoxes(
        path=path,
        frame=rows.frame[sure],
        track=rows.track[sure],
        boxes=rows.boxes[sure],
        scores=scores[sure],
        lines=rows.line[sure],
    )


def _chances(scores: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Scores [N] from 0 to 1, and which are sure enough [N].

    Scores that leave this range are log-odds, and count above `LEAST_SCORE`; others are left to the tracker.
    """
    if scores.size and scores.min() >= 0.0 and scores.max() <= 1.0:
        return scores, scores > 0.0
    return 1.0 / (1.0 + np.exp(-np.clip(scores, -50.0, 50.0))), scores > LEAST_SCORE


def _refuse_mixture(path: Path, track: IntArray, lines: IntArray) -> None:
    loose = track < 0
    if loose.any() and not loose.all():
        problem = "id is -1, but other rows have ids; write ids in all rows, or in none, to have them linked"
        raise FileError(path, problem, int(lines[loose.argmax()]))
