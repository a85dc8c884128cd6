"""Boxes as rectangles (left, top, width, height) in px, and how much two of them overlap."""

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray, IntArray, shorter_way

BOX_ASPECT = 0.36
"""Width of a person's box as a fraction of its height; an observation has no width."""


def rectangles(observations: FloatArray, aspect: float = BOX_ASPECT) -> FloatArray:
    """Boxes [..., 3] (u, v, l) in px as [..., 4] (left, top, width, height); a box is ``aspect`` times as wide as high.

    In a panorama a box on the seam begins left of column 0, or ends right of the last one.
    """
    u, v, length = np.moveaxis(observations, -1, 0)
    width = aspect * length
    return np.stack([u - 0.5 * width, v - 0.5 * length, width, length], axis=-1)


def observations_of(boxes: FloatArray, camera: Camera) -> FloatArray:
    """The way back: [..., 4] (left, top, width, height) to [..., 3] (u, v, l) in px; columns wrapped in a panorama."""
    left, top, width, height = np.moveaxis(boxes, -1, 0)
    return np.stack([camera.wrap_column(left + 0.5 * width), top + 0.5 * height, height], axis=-1)


def cut_to_picture(boxes: FloatArray, camera: Camera) -> FloatArray:
    """The part of the boxes [..., 4] inside the camera's picture; a panorama has no left and right border."""
    columns, rows = camera.picture_size
    left, top, width, height = np.moveaxis(boxes, -1, 0)
    right = left + width
    if camera.period is None:
        left, right = np.clip(left, 0.0, columns), np.clip(right, 0.0, columns)
    top, bottom = np.clip(top, 0.0, rows), np.clip(top + height, 0.0, rows)
    return np.stack([left, top, right - left, bottom - top], axis=-1)


def with_seam_copies(boxes: FloatArray, period: float | None) -> tuple[FloatArray, IntArray]:
    """Boxes [N, 4], each that crosses the seam followed by its copy one turn away; and the index of each one's box.

    ``period`` is that of the camera, `vbbench.camera.Camera.period`.
    """
    rows = np.arange(len(boxes))
    if period is None:
        return boxes, rows
    left, right = np.flatnonzero(boxes[:, 0] < 0.0), np.flatnonzero(boxes[:, 0] + boxes[:, 2] > period)
    shift = np.repeat([0.0, period, -period], [len(rows), len(left), len(right)])
    rows = np.concatenate([rows, left, right])
    order = np.argsort(rows, kind="stable")
    return (boxes[rows] + shift[:, None] * np.array([1.0, 0.0, 0.0, 0.0]))[order], rows[order]


def overlaps(first: FloatArray, second: FloatArray, period: float | None = None) -> FloatArray:
    """Intersection over union [N, M] of boxes [N, 4] with boxes [M, 4]; 0 where a box is NaN or empty.

    ``period`` is that of the camera, `vbbench.camera.Camera.period`.
    """
    return pair_overlaps(first[:, None], second[None], period)


def pair_overlaps(first: FloatArray, second: FloatArray, period: float | None = None) -> FloatArray:
    """As `overlaps`, [...] of each box of [..., 4] with the one in its place."""
    a, b = first, second
    apart = shorter_way(b[..., 0] + 0.5 * b[..., 2] - a[..., 0] - 0.5 * a[..., 2], period)
    along = np.minimum(0.5 * (a[..., 2] + b[..., 2]) - np.abs(apart), np.minimum(a[..., 2], b[..., 2]))
    down = np.minimum(a[..., 1] + a[..., 3], b[..., 1] + b[..., 3]) - np.maximum(a[..., 1], b[..., 1])
    shared = np.clip(along, 0.0, None) * np.clip(down, 0.0, None)
    union = a[..., 2] * a[..., 3] + b[..., 2] * b[..., 3] - shared
    found = np.zeros(shared.shape)
    np.divide(shared, union, out=found, where=union > 0.0)
    return found


def suppress(boxes: FloatArray, scores: FloatArray, overlap: float, period: float | None = None) -> IntArray:
    """Non-maximum suppression: indices of the boxes that remain, best first.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px.
    scores : [N], the higher the better.
    overlap : intersection over union above which the box with the lower score is removed.
    period : that of the camera, `vbbench.camera.Camera.period`.
    """
    order = np.argsort(-scores, kind="stable")
    shared = overlaps(boxes[order], boxes[order], period) > overlap
    kept = np.ones(len(order), bool)
    for row in np.flatnonzero(np.triu(shared, k=1).any(axis=1)):
        if kept[row]:
            kept[row + 1 :] &= ~shared[row, row + 1 :]
    return np.asarray(order[kept], np.int64)
