"""Inner loops of detector and tracker, which run some hundred thousand times where sequences are seen as video.

Boxes are (centre column, centre row, width, height) in px; ``period`` is the width of a picture that closes on itself,
0 for one with borders.
"""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel


@kernel
def shared_area(first: FloatArray, i: int, second: FloatArray, j: int, period: float) -> float:
    """Intersection over union of two boxes, rows i and j of [N, 4] and [M, 4]; 0 where one is NaN or empty."""
    apart = second[j, 0] - first[i, 0]
    if period > 0.0:
        apart -= period * np.round(apart / period)
    along = min(0.5 * (first[i, 2] + second[j, 2]) - abs(apart), first[i, 2], second[j, 2])
    bottom = min(first[i, 1] + 0.5 * first[i, 3], second[j, 1] + 0.5 * second[j, 3])
    top = max(first[i, 1] - 0.5 * first[i, 3], second[j, 1] - 0.5 * second[j, 3])
    if not (along > 0.0 and bottom > top):
        return 0.0
    shared: float = along * (bottom - top)
    union: float = first[i, 2] * first[i, 3] + second[j, 2] * second[j, 3] - shared
    return shared / union


@kernel
def worths(tracks: FloatArray, detections: FloatArray, scores: FloatArray, least: float, period: float) -> FloatArray:
    """[N, M] how much the overlap of boxes [N, 4] and [M, 4], times the score [M] of the latter, is above ``least``."""
    worth = np.empty((len(tracks), len(detections)))
    for i in range(len(tracks)):
        for j in range(len(detections)):
            worth[i, j] = max(shared_area(tracks, i, detections, j, period) * scores[j] - least, 0.0)
    return worth


@kernel
def merge_people(
    boxes: FloatArray,
    scores: FloatArray,
    true: FloatArray,
    chance: FloatArray,
    overlap: float,
    rate: float,
    period: float,
) -> BoolArray:
    """Which of the detections [N, 4] remain, where some pairs of people become one box about both, in place.

    Of two whose true boxes overlap by more than ``overlap`` that is so where the first's ``chance`` is below ``rate``.
    """
    kept = np.ones(len(boxes), np.bool_)
    for i in range(len(boxes)):
        for j in range(i + 1, len(boxes)):
            if not (kept[i] and kept[j] and chance[i] < rate) or shared_area(true, i, true, j, period) <= overlap:
                continue
            shift = period * np.round((boxes[i, 0] - boxes[j, 0]) / period) if period > 0.0 else 0.0
            for axis in range(2):
                a, b, c, d = boxes[i, axis], boxes[j, axis], 0.5 * boxes[i, axis + 2], 0.5 * boxes[j, axis + 2]
                if axis == 0:
                    b += shift
                low, high = min(a - c, b - d), max(a + c, b + d)
                boxes[i, axis], boxes[i, axis + 2] = 0.5 * (low + high), high - low
            scores[i] = max(scores[i], scores[j])
            kept[j] = False
    return kept


@kernel
def remaining(boxes: FloatArray, order: IntArray, overlap: float, period: float) -> BoolArray:
    """Non-maximum suppression: which boxes [N, 4] overlap none by more than ``overlap`` that remains, best first."""
    kept = np.ones(len(order), np.bool_)
    for place in range(len(order)):
        i = order[place]
        if kept[i]:
            for later in range(place + 1, len(order)):
                if kept[order[later]] and shared_area(boxes, i, boxes, order[later], period) > overlap:
                    kept[order[later]] = False
    return kept


@kernel
def move_on(mean: FloatArray, spread: FloatArray, dt: float, wander: float, acceleration: float) -> None:
    """Beliefs [N, 4, 2] and their covariances [N, 4, 3] ``dt`` seconds later, in place."""
    for n in range(len(mean)):
        height = max(mean[n, 3, 0], 1.0)
        place, pace = (wander * height) ** 2 * dt, (acceleration * height) ** 2 * dt
        for c in range(4):
            p, q, s = spread[n, c, 0], spread[n, c, 1], spread[n, c, 2]
            mean[n, c, 0] += dt * mean[n, c, 1]
            spread[n, c, 0] = p + dt * (2.0 * q + dt * s) + place
            spread[n, c, 1], spread[n, c, 2] = q + dt * s, s + pace


@kernel
def take_in(mean: FloatArray, spread: FloatArray, boxes: FloatArray, measurement: float, period: float) -> None:
    """Beliefs [N, 4, 2] and their covariances [N, 4, 3] after boxes [N, 4] were seen, in place."""
    for n in range(len(mean)):
        noise = (measurement * max(mean[n, 3, 0], 1.0)) ** 2
        for c in range(4):
            p, q, s = spread[n, c, 0], spread[n, c, 1], spread[n, c, 2]
            total, surprise = p + noise, boxes[n, c] - mean[n, c, 0]
            if c == 0 and period > 0.0:
                surprise -= period * np.round(surprise / period)
            mean[n, c, 0] += p / total * surprise
            mean[n, c, 1] += q / total * surprise
            spread[n, c, 0], spread[n, c, 1], spread[n, c, 2] = p - p * p / total, q - p * q / total, s - q * q / total
