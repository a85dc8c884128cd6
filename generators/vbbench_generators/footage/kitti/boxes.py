"""Boxes of anybody's detector or tracker on KITTI's pictures, linked to tracks, and matched to the labelled people.

Three kinds of text are read, told by their first line: detections with 15 columns and commas (frame, type, left, top,
right, bottom, score, …), KITTI's own label text with 17 columns or 18, and MOTChallenge text.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import observations_of, overlaps
from vbbench.camera import Camera
from vbbench.errors import FileError
from vbbench.exchange.detection import Detections
from vbbench.exchange.matching import LEAST_FRAMES, NOBODY, lasting_tracks, match_tracks
from vbbench.exchange.mot.text import UNLINKED, read_mot
from vbbench.geometry import BoolArray, FloatArray, IntArray, frozen_array
from vbbench_generators.footage.kitti.labels import CYCLISTS, LABELS, MOST_FRAMES, RESULTS, WALKERS, parse_labels
from vbbench_generators.footage.kitti.text import Layout, first_cells, parse_rows, read_content
from vbbench_generators.tiers.tracking.tracker import ByteTracker

_DETECTED = tuple("frame type left top right bottom score height width length x y z rotation alpha".split())
DETECTIONS = Layout(columns=_DETECTED, wanted=_DETECTED[:7], commas=True)
PEDESTRIAN, CYCLIST = 1, 3
"""Types of these detections; 2 is a car."""

LEAST_SCORE = 0.0
"""Log-odds that a detection must have more of to count; even odds."""
LEAST_OVERLAP = 0.3
"""Least intersection over union of a box with the person in it. Widths of boxes differ from detector to detector, and
half of a lidar detector's overlap labels by less than two thirds: a limit of one half would leave out its worst boxes,
and call the people in them nobody."""
LEAST_KEPT = 0.4
"""Least share of the boxes that must be of people: with less, the boxes are of other pictures."""
MOST_STRAY = 0.01
"""Largest share of boxes whose middle may lie outside the picture."""


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


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """How boxes agree with the labels of a recording.

    Parameters
    ----------
    labelled, found, matched : boxes of people, boxes of the detector or tracker, and pairs of them.
    overlap : mean intersection over union of the pairs.
    """

    labelled: int
    found: int
    matched: int
    overlap: float

    def values(self) -> dict[str, Any]:
        """As JSON has it."""
        recall, precision = self.matched / max(self.labelled, 1), self.matched / max(self.found, 1)
        figures = {"recall": recall, "precision": precision, "overlap": self.overlap}
        return {"labelled": self.labelled, "found": self.found, **{n: round(v, 3) for n, v in figures.items()}}

    def __str__(self) -> str:
        facts = self.values()
        return f"recall {facts['recall']:.2f}, precision {facts['precision']:.2f}, overlap {facts['overlap']:.2f}"


@dataclass(frozen=True, kw_only=True)
class FoundTracks:
    """Tracks on the pictures of a recording, and who is behind them.

    Parameters
    ----------
    tracks : [K] ids.
    boxes : [T, K, 3] (u, v, l) in px, NaN without a box.
    scores : [T, K] in (0, 1].
    persons : [T, K] ids of people, `NOBODY` for false alarms.
    detected, tracked : how the boxes agree with the labels as they came, and after tracking.
    dropped : boxes of tracks that match people in fewer than `LEAST_FRAMES` frames, which are left out.
    """

    tracks: IntArray
    boxes: FloatArray
    scores: FloatArray
    persons: IntArray
    detected: Agreement
    tracked: Agreement
    dropped: int


def read_boxes(path: Path, frames: int, *, cyclists: bool) -> FoundBoxes:
    """Read boxes of people in the pictures of a recording of ``frames`` frames; sure enough ones alone.

    Raises
    ------
    FileError
        At the first row that cannot be.
    """
    content = read_content(path, "boxes on the pictures")
    count = len(first_cells(content, LABELS))
    if count in (len(LABELS.columns), len(RESULTS.columns)):
        found = _from_labels(path, content, cyclists)
    elif len(first_cells(content, DETECTIONS)) == len(DETECTIONS.columns):
        found = _from_detections(path, content, cyclists)
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


def follow(found: FoundBoxes, labels: FloatArray, people: IntArray, camera: Camera, dt: float) -> FoundTracks:
    """Link boxes by the tracker `ByteTracker` where they are not, and match them to the people labelled.

    Parameters
    ----------
    found : the boxes.
    labels : [T, P, 4] boxes (left, top, width, height) of people in px, NaN where there is none.
    people : [P] their ids.
    camera : of the pictures.
    dt : seconds per frame.

    Raises
    ------
    FileError
        If boxes are of pictures of another size, or most are of nobody.
    """
    _refuse_stray(found, camera)
    frames = len(labels)
    loose, _ = _dense(found, _places_in_frames(found.frame), frames)
    detected = _agreement(loose, _persons(loose, labels, people, camera), labels, people)
    tracks, boxes, scores = _linked(found, frames, dt)
    persons = _persons(boxes, labels, people, camera)
    kept = lasting_tracks(persons)
    seen = ~np.isnan(boxes[..., 2])
    dropped = int(seen[:, ~kept].sum())
    _refuse_strangers(found.path, int(seen.sum()), dropped, detected)
    return FoundTracks(
        tracks=tracks[kept],
        boxes=observations_of(boxes[:, kept], camera),
        scores=scores[:, kept],
        persons=persons[:, kept],
        detected=detected,
        tracked=_agreement(boxes[:, kept], persons[:, kept], labels, people),
        dropped=dropped,
    )


def _from_detections(path: Path, content: bytes, cyclists: bool) -> FoundBoxes:
    rows = parse_rows(path, content, DETECTIONS)
    frame = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    corners = rows.numbers("left", "top", "right", "bottom")
    sizes = corners[:, 2:] - corners[:, :2]
    rows.refuse((sizes <= 0.0).any(axis=1), "the box is {0:g} x {1:g} px; leave it out", *sizes.T)
    wanted = np.isin(rows.columns["type"], [PEDESTRIAN, *([CYCLIST] if cyclists else [])])
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


def _from_labels(path: Path, content: bytes, cyclists: bool) -> FoundBoxes:
    labels = parse_labels(path, content).of((*WALKERS, *(CYCLISTS if cyclists else ())))
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
    if scores.size and 0.0 <= scores.min() and scores.max() <= 1.0:
        return scores, scores > 0.0
    return 1.0 / (1.0 + np.exp(-np.clip(scores, -50.0, 50.0))), scores > LEAST_SCORE


def _refuse_mixture(path: Path, track: IntArray, lines: IntArray) -> None:
    loose = track < 0
    if loose.any() and not loose.all():
        problem = "id is -1, but other rows have ids; write ids in all rows, or in none, to have them linked"
        raise FileError(path, problem, int(lines[loose.argmax()]))


def _refuse_stray(found: FoundBoxes, camera: Camera) -> None:
    width, height = camera.picture_size
    u, v = (found.boxes[:, :2] + 0.5 * found.boxes[:, 2:]).T
    stray = (u < 0.0) | (u > width) | (v < 0.0) | (v > height)
    if stray.mean() > MOST_STRAY:
        row = int(stray.argmax())
        problem = f"the middle of the box is at {u[row]:.0f} {v[row]:.0f}, outside pictures of {width} x {height} px"
        share = f"as are {stray.mean():.0%} of the boxes"
        raise FileError(found.path, f"{problem}, {share}; were pictures of another size used?", int(found.lines[row]))


def _refuse_strangers(path: Path, boxes: int, dropped: int, detected: Agreement) -> None:
    if boxes - dropped < LEAST_KEPT * boxes:
        problem = f"{dropped} of {boxes} boxes are of tracks that match nobody in {LEAST_FRAMES} frames"
        hint = "are they of this sequence, with frames counted as in its format, in px of its pictures?"
        raise FileError(path, f"{problem} ({detected}); {hint}")


def _linked(found: FoundBoxes, frames: int, dt: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Track ids [K], boxes [T, K, 4] and scores [T, K]."""
    if (found.track != UNLINKED).all():
        tracks, column = np.unique(found.track, return_inverse=True)
        return tracks, *_dense(found, column, frames)
    tracker, linked = ByteTracker(dt=dt), []
    for frame in range(frames):
        rows = found.frame == frame
        linked.append(tracker.step(Detections(boxes=found.boxes[rows], scores=found.scores[rows])))
    count = [len(ids) for ids, _ in linked]
    ids = np.concatenate([ids for ids, _ in linked])
    followed = FoundBoxes(
        path=found.path,
        frame=np.repeat(np.arange(frames), count),
        track=ids,
        boxes=np.concatenate([one.boxes for _, one in linked]),
        scores=np.concatenate([one.scores for _, one in linked]),
        lines=np.zeros(len(ids), np.int64),
    )
    tracks, column = np.unique(ids, return_inverse=True)
    return tracks, *_dense(followed, column, frames)


def _dense(found: FoundBoxes, column: IntArray, frames: int) -> tuple[FloatArray, FloatArray]:
    """Boxes [T, K, 4] and scores [T, K], each row's in its ``column``; NaN without a box."""
    count = int(column.max(initial=-1)) + 1
    boxes, scores = np.full((frames, count, 4), np.nan), np.full((frames, count), np.nan)
    boxes[found.frame, column], scores[found.frame, column] = found.boxes, found.scores
    return boxes, scores


def _places_in_frames(frame: IntArray) -> IntArray:
    """[N] how many rows before each are of the same frame."""
    order = np.argsort(frame, kind="stable")
    first = np.searchsorted(frame[order], frame[order])
    place = np.empty(len(frame), np.int64)
    place[order] = np.arange(len(frame)) - first
    return place


def _persons(boxes: FloatArray, labels: FloatArray, people: IntArray, camera: Camera) -> IntArray:
    return match_tracks(boxes, labels, people, camera, least=LEAST_OVERLAP)


def _agreement(boxes: FloatArray, persons: IntArray, labels: FloatArray, people: IntArray) -> Agreement:
    """How boxes [T, K, 4] of persons [T, K] agree with labels [T, P, 4] of people [P]."""
    shared = []
    for box, person, label in zip(boxes, persons, labels, strict=True):
        paired = person != NOBODY
        shared.append(overlaps(box[paired], label[np.searchsorted(people, person[paired])]).diagonal())
    pairs = np.concatenate(shared)
    return Agreement(
        labelled=int((~np.isnan(labels[..., 0])).sum()),
        found=int((~np.isnan(boxes[..., 0])).sum()),
        matched=len(pairs),
        overlap=float(pairs.mean()) if len(pairs) else 0.0,
    )
