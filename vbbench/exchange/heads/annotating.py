"""The boxes that annotators would draw round heads: by hand in key frames, joined by straight lines."""

import numpy as np

from vbbench.exchange.heads.sighting import Heads
from vbbench.geometry import FloatArray, IntArray

ALIKE = 0.5
"""Correlation of the errors of a box's width and height."""
SMALLEST = 0.2
"""No box is drawn smaller than this part of the head."""


def draw_boxes(heads: Heads, noise: float, key_every: int, rng: np.random.Generator) -> FloatArray:
    """Boxes [N, 4] (left, top, width, height) in px from 0, with errors.

    Key frames are every ``key_every``-th, the first and the last of each track. There, each of width and height is
    wrong by a normal factor, and each side of the box moves as much, so that the centre is wrong by half of that.
    Between, the four numbers are interpolated; key boxes are wrong by more than ``noise``, so that all boxes together
    are by as much.

    Parameters
    ----------
    heads : sorted by track and frame.
    noise : root mean square of the relative errors of widths, and of heights.
    key_every : frames from key box to key box.
    rng : draws the errors.
    """
    keys = _keys(heads, key_every)
    spread = noise * _raised(key_every)
    errors = rng.standard_normal((len(keys), 5))
    factor = 1.0 + spread * (np.sqrt(ALIKE) * errors[:, :1] + np.sqrt(1.0 - ALIKE) * errors[:, 1:3])
    sizes = heads.sizes[keys] * np.maximum(factor, SMALLEST)
    corners = heads.places[keys] + 0.5 * spread * errors[:, 3:] * heads.sizes[keys] - sizes / 2.0
    return _joined(heads, keys, np.concatenate([corners, sizes], axis=1))


def _keys(heads: Heads, key_every: int) -> IntArray:
    """Rows that are key boxes."""
    begins = np.diff(heads.track, prepend=-1) != 0
    ends = np.append(begins[1:], True)
    return np.flatnonzero(begins | ends | (heads.frame % key_every == 0))


def _raised(key_every: int) -> float:
    """Root mean square error of key boxes over that of all boxes, of which most are means of two."""
    part = np.arange(key_every) / key_every
    return float(1.0 / np.sqrt(np.mean(part**2 + (1.0 - part) ** 2)))


def _joined(heads: Heads, keys: IntArray, boxes: FloatArray) -> FloatArray:
    """Boxes [N, 4] of all rows from those [M, 4] of the rows ``keys``."""
    rows = np.arange(len(heads))
    before = np.searchsorted(keys, rows, side="right") - 1
    after = np.minimum(before + (keys[before] != rows), len(keys) - 1)
    start, end = heads.frame[keys[before]], heads.frame[keys[after]]
    part = ((heads.frame - start) / np.maximum(end - start, 1))[:, None]
    joined: FloatArray = (1.0 - part) * boxes[before] + part * boxes[after]
    return joined
