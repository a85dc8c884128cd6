"""Boxes of a detector or tracker as tracks: linked if they have no ids, matched to labelled people, and counted."""

import warnings
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import find_misfit, observations_of, pair_overlaps
from vbbench.camera import Camera
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, read_boxes, rows_in_frames
from vbbench.exchange.box_tables import UNLINKED, scores_as_shares
from vbbench.exchange.detection import link
from vbbench.exchange.matching import FrameOffset, frame_offset, lasting_tracks, match_tracks
from vbbench.exchange.text_tables import NamedColumns
from vbbench.geometry import FloatArray, IntArray
from vbbench.sequence import NOBODY
from vbbench_generators.tiers.tracking.tracker import ByteTracker

LEAST_SCORE = 0.0
"""Log-odds that a detection must have more of to count; even odds."""
UNKNOWN = -1.0
"""A score that says nothing."""
MOST_FRAMES = 10**6
"""Frames that a recording may have."""
FOUND_PIXEL_STD = 5.0
"""Noise in px of a detector's or tracker's boxes, which solvers are given: more than that of labels."""


def read_found(
    path: Path, frames: int, dt: float, picture: tuple[float, float], person_class: str | None = None
) -> BoxRows:
    """Boxes of people with sufficient scores on a recording of ``frames`` frames, in any format of `birdify`.

    Parameters
    ----------
    dt : seconds per frame, which converts time stamps to frames; frame 0 is at 0 s.
    picture : width and height in px, for boxes given as shares of it.
    person_class : class of people, by number or name, where the file does not show it.
    """
    rows = read_boxes(path, dt, picture=picture, person_class=person_class)
    for note in rows.notes:
        warnings.warn(VbbenchWarning(f"{path}: {note}"), stacklevel=2)
    return sure_boxes(rows_in_frames(rows, frames, dt))


def frames_of(rows: NamedColumns) -> IntArray:
    """[N] frames from 0 of the rows of a file; raises FileError at the first that is none."""
    return rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")


def sure_boxes(rows: BoxRows) -> BoxRows:
    """The boxes with scores above `LEAST_SCORE`, which may be log-odds or shares.

    If all scores are −1, MOTChallenge's mark of an unknown score, all boxes count.
    """
    known = np.where((rows.scores == UNKNOWN).all(), np.nan, rows.scores)
    track, shares = np.where(rows.track < 0, UNLINKED, rows.track), scores_as_shares(known)
    found = replace(rows, track=track, scores=shares).select(~(known <= LEAST_SCORE))
    loose = found.track == UNLINKED
    if loose.any() and not loose.all():
        problem = "id is -1, but other rows have ids; write ids in all rows, or in none, to have them linked"
        raise found.fault(int(loose.argmax()), problem)
    return found


def file_for(given: Path, name: str, several: bool) -> Path:
    """The file of a sequence in the folder ``given``, or ``given`` itself if it is a file and there is one sequence.

    A text file of the sequence's name is preferred to others of that name.
    """
    if given.is_file():
        if several:
            raise VbbenchError(
                f"{given} is one file; name a folder with a file for each sequence, {name}.txt and so on"
            )
        return given
    path = given / f"{name}.txt"
    if path.is_file():
        return path
    other = next((one for one in sorted(given.iterdir()) if one.stem == name), None) if given.is_dir() else None
    if other is None:
        raise FileError(path, "is missing; files for a sequence are called like it, in a folder or named alone")
    return other


LEAST_OVERLAP = 0.3
"""Least intersection over union of a box with the person in it. Widths of boxes differ from detector to detector, and
half of a lidar detector's overlap labels by less than two thirds: a limit of one half would remove its worst boxes,
and call the people in them nobody."""
LEAST_SHARE = 1 / 3
"""Where fewer of the boxes are on people, and fewer of the people have boxes, these are of other pictures."""
FEW = 0.5
"""Share of the people's boxes below which a person should look at what was found."""
HEIGHT_MEAN = 1.72
"""Of people in m, by which boxes are checked."""
MOST_STRAY = 0.01
"""Largest share of boxes whose middle may lie outside the picture."""
LONGEST_STEP, FEWEST_LOOKS = 1.0, 10
"""In s from a picture to the next that a detector saw, and how many pictures have boxes: what lies farther apart, or is
less, is of a detector that found few."""


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """Agreement of boxes with the labels of a recording.

    Parameters
    ----------
    labelled, found, matched : numbers of labelled boxes, of boxes of the detector or tracker, and of pairs.
    overlap : mean intersection over union of the pairs.
    """

    labelled: int
    found: int
    matched: int
    overlap: float

    def values(self) -> dict[str, Any]:
        """The figures for ``dataset.json``."""
        recall, precision = self.matched / max(self.labelled, 1), self.matched / max(self.found, 1)
        figures = {"recall": recall, "precision": precision, "overlap": self.overlap}
        return {"labelled": self.labelled, "found": self.found, **{n: round(v, 3) for n, v in figures.items()}}

    def __str__(self) -> str:
        facts = self.values()
        return f"recall {facts['recall']:.2f}, precision {facts['precision']:.2f}, overlap {facts['overlap']:.2f}"


@dataclass(frozen=True, kw_only=True)
class FoundTracks:
    """Tracks of a recording, matched to its people.

    Parameters
    ----------
    tracks : [K] ids.
    boxes : [T, K, 3] (u, v, l) in px, NaN without a box.
    scores : [T, K] in (0, 1].
    persons : [T, K] ids of people, `NOBODY` for false alarms.
    detected, tracked : agreement with the labels before and after tracking.
    dropped : number of boxes removed with tracks that match people in fewer than three frames.
    """

    tracks: IntArray
    boxes: FloatArray
    scores: FloatArray
    persons: IntArray
    detected: Agreement
    tracked: Agreement
    dropped: int

    @property
    def seen(self) -> dict[str, Any]:
        """What a `Footage` has of them."""
        return {"tracks": self.tracks, "boxes": self.boxes, "visible": self.scores, "persons": self.persons}

    @property
    def agreements(self) -> dict[str, Any]:
        """How boxes agree with the labels, as JSON has it."""
        return {"detected": self.detected.values(), "tracked": self.tracked.values()}


def follow(
    found: BoxRows, labels: FloatArray, people: IntArray, camera: Camera, dt: float, *, size: tuple[int, int]
) -> FoundTracks:
    """Link boxes without ids by `ByteTracker`, and match them to the labelled people.

    Parameters
    ----------
    labels : [T, P, 4] boxes (left, top, width, height) of people in px, NaN where there is none.
    people : [P] their ids.
    camera : camera of the pictures.
    size : width and height of the pictures in px.
    """
    if not len(found):
        raise FileError(found.path, "holds no box of a person with a sufficient score in the labelled frames")
    misfit = find_misfit(found.boxes, camera, size, HEIGHT_MEAN)
    if misfit is not None and misfit.certain:
        raise FileError(found.path, misfit.text)
    _refuse_stray(found, camera, size)
    frames, whole = len(labels), labels
    looked, step = _looked_at(found.frame, frames, dt)
    labels = np.where(np.isin(np.arange(frames), looked)[:, None, None], labels, np.nan)
    _, loose = replace(found, track=_places_in_frames(found.frame)).dense(frames, found.boxes)
    detected = _agreement(loose, _persons(loose, labels, people, camera), labels, people, camera)
    offset = frame_offset(loose, lambda frame, later: whole[frame + later], camera.period, least=LEAST_OVERLAP)
    hint = "are they of this sequence, with frames counted as in their format, in px of its pictures?"
    hint = f"{hint} {misfit.text}" if misfit else hint
    _check_matches(found.path, detected, offset, hint)
    if not found.linked:
        found = link(found, ByteTracker(dt=step * dt, period=camera.period), looked)
    tracks, dense = found.dense(frames, found.boxes, found.scores)
    boxes, scores = dense[..., :4], dense[..., 4]
    persons = _persons(boxes, labels, people, camera)
    kept = lasting_tracks(persons)
    seen = ~np.isnan(boxes[..., 2])
    dropped = int(seen[:, ~kept].sum())
    return FoundTracks(
        tracks=tracks[kept],
        boxes=observations_of(boxes[:, kept], camera),
        scores=scores[:, kept],
        persons=persons[:, kept],
        detected=detected,
        tracked=_agreement(boxes[:, kept], persons[:, kept], labels, people, camera),
        dropped=dropped,
    )


def _looked_at(frame: IntArray, frames: int, dt: float) -> tuple[IntArray, int]:
    """The frames that the detector processed, and their step: it may have processed every sixth."""
    filled = np.unique(frame)
    apart = np.diff(filled)
    step = int(np.bincount(apart).argmax()) if len(filled) >= FEWEST_LOOKS else 1
    if step == 1 or step * dt > LONGEST_STEP:
        return np.arange(frames), 1
    between = [np.arange(start, end, step) for start, end in pairwise(filled.tolist())]
    before, after = np.arange(filled[0] % step, filled[0], step), np.arange(filled[-1], frames, step)
    return np.concatenate([before, *between, after]), step


def _refuse_stray(found: BoxRows, camera: Camera, size: tuple[int, int]) -> None:
    """Refuse boxes outside the picture; a box may cross the seam of a panorama."""
    width, height = size
    u, v = (found.boxes[:, :2] + 0.5 * found.boxes[:, 2:]).T
    aside = np.abs(u - 0.5 * width) > (0.5 * width if camera.period is None else camera.period)
    stray = aside | (v < 0.0) | (v > height)
    if stray.mean() > MOST_STRAY:
        row = int(stray.argmax())
        problem = f"the middle of the box is at {u[row]:.0f} {v[row]:.0f}, outside pictures of {width} x {height} px"
        share = f"as are {stray.mean():.0%} of the boxes"
        raise FileError(found.path, f"{problem}, {share}; were pictures of another size used?", int(found.lines[row]))


def _check_matches(path: Path, detected: Agreement, offset: FrameOffset | None, hint: str) -> None:
    """Refuse boxes if hardly any match labelled people; warn if few do, or if another frame offset fits better."""
    matched, found, labelled = detected.matched, detected.found, detected.labelled
    if matched < LEAST_SHARE * labelled and matched < LEAST_SHARE * found:
        problem = f"only {matched} of {found} boxes are on people, of whom there are {labelled} ({detected})"
        raise FileError(path, f"{problem}; {offset or hint}")
    if offset is not None:
        warnings.warn(VbbenchWarning(f"{path}: {offset}"), stacklevel=2)
    if matched < FEW * labelled:
        problem = f"only {matched} of {labelled} labelled boxes of people are matched ({detected})"
        warnings.warn(VbbenchWarning(f"{path}: {problem}"), stacklevel=2)


def _places_in_frames(frame: IntArray) -> IntArray:
    """[N] number of earlier rows of the same frame."""
    order = np.argsort(frame, kind="stable")
    first = np.searchsorted(frame[order], frame[order])
    place = np.empty(len(frame), np.int64)
    place[order] = np.arange(len(frame)) - first
    return place


def _persons(boxes: FloatArray, labels: FloatArray, people: IntArray, camera: Camera) -> IntArray:
    return match_tracks(boxes, labels, people, camera, least=LEAST_OVERLAP)


def _agreement(boxes: FloatArray, persons: IntArray, labels: FloatArray, people: IntArray, camera: Camera) -> Agreement:
    """The agreement of boxes [T, K, 4] of persons [T, K] with labels [T, P, 4] of people [P]."""
    shared = []
    for box, person, label in zip(boxes, persons, labels, strict=True):
        paired = person != NOBODY
        shared.append(pair_overlaps(box[paired], label[np.searchsorted(people, person[paired])], camera.period))
    pairs = np.concatenate(shared)
    return Agreement(
        labelled=int((~np.isnan(labels[..., 0])).sum()),
        found=int((~np.isnan(boxes[..., 0])).sum()),
        matched=len(pairs),
        overlap=float(pairs.mean()) if len(pairs) else 0.0,
    )
