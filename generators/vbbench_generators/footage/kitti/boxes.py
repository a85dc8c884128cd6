"""Boxes of anybody's detector or tracker on KITTI's pictures, as they are in files.

Three kinds of text are read, told by their first line: detections with 15 columns and commas (frame, type, left, top,
right, bottom, score, …), KITTI's own label text with 17 columns or 18, and MOTChallenge text.
"""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.mot.text import UNLINKED
from vbbench_generators.footage.found_boxes import FoundBoxes, boxes_of_mot, chances, refuse_mixture
from vbbench_generators.footage.kitti.labels import LABELS, MOST_FRAMES, RESULTS, parse_labels
from vbbench_generators.footage.kitti.text import Layout, first_cells, names, parse_rows, read_content

_DETECTED = names("frame type left top right bottom score height width length x y z rotation alpha")
DETECTIONS = Layout(columns=_DETECTED, wanted=_DETECTED[:7], commas=True)
TYPES = {1: "Pedestrian", 2: "Car", 3: "Cyclist"}
"""Classes of these detections."""


def read_boxes(path: Path, frames: int, classes: tuple[str, ...]) -> FoundBoxes:
    """Read boxes of ``classes`` in the pictures of a recording of ``frames`` frames; sure enough ones alone.

    Raises
    ------
    FileError
        At the first row that is not valid.
    """
    content = read_content(path, "boxes on the pictures")
    count = len(first_cells(content, LABELS))
    if count in (len(LABELS.columns), len(RESULTS.columns)):
        found = _from_labels(path, content, classes)
    elif len(first_cells(content, DETECTIONS)) == len(DETECTIONS.columns):
        found = _from_detections(path, content, classes)
    else:
        found = boxes_of_mot(path, frames)
    late = found.frame >= frames
    if late.any():
        row = int(late.argmax())
        problem = f"frame {found.frame[row]} is beyond the recording of {frames} frames, from 0"
        raise FileError(path, problem, int(found.lines[row]))
    return found


def _from_detections(path: Path, content: bytes, classes: tuple[str, ...]) -> FoundBoxes:
    rows = parse_rows(path, content, DETECTIONS)
    frame = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    corners = rows.numbers("left", "top", "right", "bottom")
    sizes = corners[:, 2:] - corners[:, :2]
    rows.refuse((sizes[:, 0] <= 0.0) | (sizes[:, 1] <= 0.0), "the box is {0:g} x {1:g} px; leave it out", *sizes.T)
    wanted = np.isin(rows.columns["type"], [number for number, name in TYPES.items() if name in classes])
    scores, sure = chances(rows.columns["score"])
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
    scores, sure = chances(labels.scores)
    labels, scores = labels.take(sure), scores[sure]
    refuse_mixture(path, labels.track, labels.lines)
    corners = labels.boxes
    return FoundBoxes(
        path=path,
        frame=labels.frame,
        track=np.where(labels.track < 0, UNLINKED, labels.track),
        boxes=np.concatenate([corners[:, :2], corners[:, 2:] - corners[:, :2]], axis=-1),
        scores=scores,
        lines=labels.lines,
    )
