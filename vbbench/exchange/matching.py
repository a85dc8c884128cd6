"""Matches detections and tracks to people: boxes to the true ones of the same frame, by their overlap."""

import numpy as np

from vbbench.boxes import cut_to_picture, overlaps, rectangles
from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.sequence import NOBODY

LEAST_OVERLAP = 0.5
"""Boxes that overlap less (intersection over union) are never matched, as in MOTChallenge and the paper."""

LEAST_FRAMES = 3
"""Tracks matched in fewer frames are left out, unless asked otherwise; the paper wants more than three."""


def match_boxes(
    found: FloatArray,
    true: FloatArray,
    camera: Camera,
    *,
    least: float = LEAST_OVERLAP,
    paired: BoolArray | None = None,
) -> tuple[IntArray, IntArray]:
    """Pair the boxes of one frame one to one, with the largest total overlap.

    As many pairs as possible are those that were ``paired`` before; among all ways to do so the overlap decides.

    Both are cut to the picture first: a detector need not guess the part of a person outside it.

    Parameters
    ----------
    found, true : [N, 4] and [M, 4] (left, top, width, height) in px; NaN = absent.
    camera : the camera of the picture; a panorama's closes on itself.
    least : least intersection over union of a pair.
    paired : [N, M] which were a pair before; none if left out.

    Returns
    -------
    Indices [P] into ``found``, ascending, and [P] into ``true``.
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
    """The person behind each track in each frame.

    Parameters
    ----------
    found : [T, K, 4] boxes (left, top, width, height) of tracks in px, NaN where a track has none.
    true : [T, P, 4] boxes of people.
    people : [P] their ids.
    camera : the camera of the pictures.
    least : as of `match_boxes`.
    staying : whether whoever was behind a track the last time stays behind it while their boxes overlap enough, as in
        the CLEAR metrics (Bernardin and Stiefelhagen 2008). Boxes that are far from exact need it: of two people side
        by side the one does not become the other and back again.

    Returns
    -------
    [T, K] person ids, `NOBODY` where a track has no box or its box is a false alarm.
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


def true_rectangles(positions: FloatArray, heights: FloatArray, poses: FloatArray, camera: Camera) -> FloatArray:
    """Boxes [T, P, 4] in px of people at positions [T, P, 2] with heights [P], seen from poses [T, 3]; NaN unseen."""
    relative = world_to_relative(positions, poses)
    return rectangles(camera.project(relative, np.broadcast_to(heights, relative.shape[:-1])))


def lasting_tracks(persons: IntArray, frames: int = LEAST_FRAMES) -> BoolArray:
    """[K] whether a track is matched to a person, [T, K], in at least ``frames`` frames."""
    return np.asarray((persons != NOBODY).sum(axis=0) >= frames)
