"""Boxes of any detector or tracker on KITTI's pictures, as they are in files.

Besides what `birdify` reads, two kinds of text are, known by their first line: detections with 15 columns and commas
(frame, type, left, top, right, bottom, score, …), and KITTI's own label text with 17 columns, or 18 with a score.
"""

from pathlib import Path

import numpy as np

from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.geometry import FloatArray
from vbbench_generators.footage.found_boxes import read_found, sure_boxes
from vbbench_generators.footage.kitti.labels import LABELS, MOST_FRAMES, RESULTS, parse_labels
from vbbench_generators.footage.kitti.text import Layout, first_cells, names, parse_rows, read_content

_DETECTED = names("frame type left top right bottom score height width length x y z rotation alpha")
DETECTIONS = Layout(columns=_DETECTED, wanted=_DETECTED[:7], commas=True)
TYPES = {1: "Pedestrian", 2: "Car", 3: "Cyclist"}
"""Classes of these detections."""
LARGEST_LOG_ODDS = 20.0
"""Largest score that is log-odds, as lidar detectors write them; one in 500 million would be wrong."""


def read_boxes(
    path: Path,
    frames: int,
    classes: tuple[str, ...],
    *,
    dt: float,
    picture: tuple[float, float],
    person_class: str | None = None,
) -> BoxRows:
    """Read boxes of ``classes`` in the pictures of a recording of ``frames`` frames; sure enough ones alone.

    Parameters
    ----------
    dt, picture, person_class : as of `read_found`.

    Raises
    ------
    FileError
        At the first row that is not valid.
    """
    content = read_content(path, "boxes on the pictures") if path.is_file() else b""
    if len(first_cells(content, LABELS)) in (len(LABELS.columns), len(RESULTS.columns)):
        return _from_labels(path, content, classes).within(frames)
    if len(first_cells(content, DETECTIONS)) == len(DETECTIONS.columns):
        return _from_detections(path, content, classes).within(frames)
    return read_found(path, frames, dt, picture, person_class)


def _from_detections(path: Path, content: bytes, classes: tuple[str, ...]) -> BoxRows:
    rows = parse_rows(path, content, DETECTIONS)
    frame = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    corners = rows.numbers("left", "top", "right", "bottom")
    sizes = corners[:, 2:] - corners[:, :2]
    rows.refuse((sizes[:, 0] <= 0.0) | (sizes[:, 1] <= 0.0), "the box is {0:g} x {1:g} px; remove it", *sizes.T)
    wanted = np.isin(rows.columns["type"], [number for number, name in TYPES.items() if name in classes])
    boxes, track = np.concatenate([corners[:, :2], sizes], axis=-1), np.full(len(rows), UNLINKED)
    scores = _log_odds(rows.columns["score"][wanted])
    return sure_boxes(rows_of(path, frame[wanted], track[wanted], boxes[wanted], scores, rows.lines[wanted]))


def _from_labels(path: Path, content: bytes, classes: tuple[str, ...]) -> BoxRows:
    labels = parse_labels(path, content).of(classes)
    boxes = np.concatenate([labels.boxes[:, :2], labels.boxes[:, 2:] - labels.boxes[:, :2]], axis=-1)
    return sure_boxes(rows_of(path, labels.frame, labels.track, boxes, _log_odds(labels.scores), labels.lines))


def _log_odds(scores: FloatArray) -> FloatArray:
    """The same scores [N], as shares where they are log-odds above 0: above 1, and too small for per cent."""
    small = (scores > 0.0).all() and 1.0 < scores.max(initial=0.0) <= LARGEST_LOG_ODDS
    return 1.0 / (1.0 + np.exp(-scores)) if small else scores
