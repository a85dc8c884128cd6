"""Pairs tracks with detections by how much their boxes overlap."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from vbbench.boxes import overlaps
from vbbench.geometry import FloatArray, IntArray


def associate(
    tracks: FloatArray,
    detections: FloatArray,
    least: float,
    *,
    scores: FloatArray | None = None,
    period: float | None = None,
) -> tuple[IntArray, IntArray]:
    """One-to-one pairs that are worth most, a pair being worth what it overlaps above ``least``.

    Parameters
    ----------
    tracks, detections : [N, 4] and [M, 4] centre column, centre row, width and height in px.
    scores : [M] what the overlap with each detection is multiplied by.
    period : width of a picture that closes on itself.

    Returns
    -------
    Indices [P] into ``tracks`` and [P] into ``detections``.
    """
    if not len(tracks) or not len(detections):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    worth = overlaps(from_centres(tracks), from_centres(detections), period)
    if scores is not None:
        worth = worth * scores
    worth = np.clip(worth - least, 0.0, None)
    rows, columns = linear_sum_assignment(worth, maximize=True)
    paired = worth[rows, columns] > 0.0
    return rows[paired].astype(np.int64), columns[paired].astype(np.int64)


def from_centres(boxes: FloatArray) -> FloatArray:
    """Boxes [..., 4] given by centre, width and height as (left, top, width, height)."""
    return np.concatenate([boxes[..., :2] - 0.5 * boxes[..., 2:], boxes[..., 2:]], axis=-1)
