"""Matches detections and tracks to people by the IoU of boxes in each frame."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vbbench.boxes import cut_to_picture, overlaps, pair_overlaps, rectangles
from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.sequence import NOBODY

LEAST_OVERLAP = 0.5
"""Boxes that overlap less (intersection over union) are never matched, as in MOTChallenge and the paper."""

LEAST_FRAMES = 3
"""Tracks matched in fewer frames are dropped, unless asked otherwise; the paper wants more than three."""

MOST_LATER = 30
"""Frames by which boxes and people are shifted against each other, to see whether they fit better."""
_LOOKS, _BOXES, _BLOCKS, _FEWEST = 200, 1000, 20, 10
"""Frames and boxes that are looked at, blocks of frames for the error of a gain, and fewest boxes of a shift."""
_LEAST_GAIN, _SURE = 0.015, 4.0
"""Least gain of overlap that counts, and how many of its standard errors it must be."""


def match_boxes(
    found: FloatArray,
    true: FloatArray,
    camera: Camera,
    *,
    least: float = LEAST_OVERLAP,
    paired: BoolArray | None = None,
) -> tuple[IntArray, IntArray]:
    """One-to-one assignment of the boxes of one frame with the largest total IoU.

    It first maximises the number of pairs that were ``paired`` before, then the IoU. Boxes are first cut to the
    picture, since a detector need not find the part of a person outside it. The result is indices [P] into ``found``,
    ascending, and [P] into ``true``.

    Parameters
    ----------
    found, true : [N, 4] and [M, 4] (left, top, width, height) in px; NaN = absent.
    camera : the camera of the picture.
    least : least IoU of a pair.
    paired : [N, M] mask of pairs in the frame before; none by default.
    """
    from scipy.optimize import linear_sum_assignment

    shared = overlaps(cut_to_picture(found, camera), cut_to_picture(true, camera), camera.period)
    shared[shared < least] = 0.0
    if paired is not None:
        shared[paired & (shared > 0.0)] += len(shared)  # more than all overlaps together
    rows, columns = linear_sum_assignment(shared, maximize=True)
    pairs = shared[rows, columns] > 0.0
    return rows[pairs].astype(np.int64), columns[pairs].astype(np.int64)


def match_tracks(
    found: FloatArray,
    true: FloatArray,
    people: IntArray,
    camera: Camera,
    *,
    least: float = LEAST_OVERLAP,
    staying: bool = False,
) -> IntArray:
    """The person behind each track in each frame: ids [T, K], `NOBODY` where a track has no box or a false alarm.

    Parameters
    ----------
    found : [T, K, 4] boxes (left, top, width, height) of tracks in px, NaN where a track has none.
    true : [T, P, 4] boxes of people.
    people : [P] their ids.
    least : as in `match_boxes`.
    staying : whether a track keeps its last person while their IoU is at least ``least``, as in the CLEAR metrics
        (Bernardin and Stiefelhagen 2008). With inexact boxes this avoids identity switches between neighbours.
    """
    persons = np.full(found.shape[:2], NOBODY, dtype=np.int64)
    last = np.full(found.shape[1], -1)
    for frame, (boxes, real) in enumerate(zip(found, true, strict=True)):
        tracks, columns = (np.flatnonzero(~np.isnan(b[:, 3])) for b in (boxes, real))
        paired = last[tracks][:, None] == columns if staying else None
        rows, partners = match_boxes(boxes[tracks], real[columns], camera, least=least, paired=paired)
        persons[frame, tracks[rows]] = people[columns[partners]]
        last[tracks[rows]] = columns[partners]
    return persons


class FrameOffset(NamedTuple):
    """A better shift of people by ``later`` frames: mean IoU ``then`` with it, and ``now`` without."""

    later: int
    then: float
    now: float

    def __str__(self) -> str:
        count = "one frame" if abs(self.later) == 1 else f"{abs(self.later)} frames"
        when = f"{count} {'later' if self.later > 0 else 'earlier'}"
        doubt = "do frames count from 0 or from 1" if abs(self.later) == 1 else "are both of the same frames"
        return f"boxes overlap people {when} by {self.then:.2f}, now by {self.now:.2f}: {doubt}?"


def frame_offset(
    found: FloatArray,
    expected: Callable[[IntArray, int], FloatArray],
    period: float | None,
    columns: IntArray | None = None,
    *,
    least: float = 0.0,
) -> FrameOffset | None:
    """The shift of people in frames that fits boxes better; ``None`` if no shift is significantly better.

    The IoU of a box is that with its own person, or else the largest. The mean gain of a shift must be several of its
    standard errors, by blocks of frames, so that standing people give no shift.

    Parameters
    ----------
    found : [T, K, 4] boxes (left, top, width, height) in px, NaN where there is none.
    expected : function of frames [F] and a shift; returns boxes [F, P, 4] of people with this shift.
    columns : [T, K] index of each box's own person among the P, −1 = none; ``None`` if unknown.
    least : mean IoU that a shift must reach, which it does not with a wrong camera.
    """
    seen = ~np.isnan(found[..., 3]) if columns is None else ~np.isnan(found[..., 3]) & (columns >= 0)
    filled = np.flatnonzero(seen.any(axis=1))
    looked = filled[np.linspace(0, len(filled) - 1, min(len(filled), _LOOKS)).astype(np.int64)]
    row, track = np.nonzero(seen[looked])
    some = np.linspace(0, len(row) - 1, min(len(row), _BOXES)).astype(np.int64)
    row, track = row[some], track[some]
    boxes, own = found[looked[row], track], None if columns is None else columns[looked[row], track]

    def shared(later: int) -> FloatArray:
        there = (looked + later >= 0) & (looked + later < len(found))
        people, fit = expected(looked[there], later), np.full(len(row), np.nan)
        kept, place = there[row], (np.cumsum(there) - 1)[row]
        if own is not None:
            fit[kept] = pair_overlaps(boxes[kept], people[place[kept], own[kept]], period)
            return fit
        nobody = np.isnan(people[..., 3])  # those who are there, first
        first = np.argsort(nobody, axis=1)[:, : int((~nobody).sum(axis=1).max(initial=0))]
        people = np.take_along_axis(people, first[..., None], axis=1)
        fit[kept] = pair_overlaps(boxes[kept, None], people[place[kept]], period).max(axis=1, initial=0.0)
        return fit

    now, block = shared(0), row * _BLOCKS // max(len(looked), 1)
    best: tuple[float, FrameOffset] | None = None
    for later in (one for one in range(-MOST_LATER, MOST_LATER + 1) if one):
        then = shared(later)
        kept = ~np.isnan(then)
        if kept.sum() < max(_FEWEST, 0.25 * len(row)):
            continue
        values, counts = (then - now)[kept], np.bincount(block[kept])
        gain, used = float(values.mean()), max(int((counts > 0).sum()), 2)
        sums = np.bincount(block[kept], values) - counts * gain
        error = float(np.sqrt((sums**2).sum() * used / (used - 1.0)) / len(values))
        fit = float(then[kept].mean())
        if fit >= least and gain > max(_LEAST_GAIN, _SURE * error, best[0] if best else 0.0):
            best = gain, FrameOffset(later, fit, float(now[kept].mean()))
    return best[1] if best else None


def in_columns(boxes: FloatArray) -> FloatArray:
    """Boxes [..., 4] with equal rows, so that only their columns affect the IoU."""
    return np.stack([boxes[..., 0], 0.0 * boxes[..., 1], boxes[..., 2], 0.0 * boxes[..., 3] + 1.0], axis=-1)


def true_rectangles(positions: FloatArray, heights: FloatArray, poses: FloatArray, camera: Camera) -> FloatArray:
    """Boxes [T, P, 4] in px of people at positions [T, P, 2] with heights [P], seen from poses [T, 3]; NaN unseen."""
    relative = world_to_relative(positions, poses)
    return rectangles(camera.project(relative, np.broadcast_to(heights, relative.shape[:-1])))


def lasting_tracks(persons: IntArray, frames: int = LEAST_FRAMES) -> BoolArray:
    """[K] whether a track is matched to a person, [T, K], in at least ``frames`` frames."""
    return np.asarray((persons != NOBODY).sum(axis=0) >= frames)
