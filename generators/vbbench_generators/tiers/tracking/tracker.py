"""A tracker with two stages of association, after ByteTrack (Zhang et al. 2022).

In each frame Kalman filters predict the tracks. Confirmed tracks, lost ones too, are associated with detections of high
score; unmatched tracks that were seen a frame ago, with detections of low score, so that a half-hidden person keeps the
track. New tracks are confirmed by a second detection in the next frame, or removed; unmatched detections of high score
begin tracks. A track without a detection is lost; it is predicted for `TrackerSettings.lost_time`, then removed.

The filter has a constant-velocity model of centre, width and height, as in SORT (Bewley et al. 2016): noise is
proportional to the height of the box, and the four coordinates are independent filters on (value, speed):

    x ← F x,  P ← F P Fᵀ + diag(w² dt, a² dt),  F = (1 dt; 0 1);
    K = P Hᵀ/(P_00 + r²),  x ← x + K (z − x_0),  P ← P − K H P,  H = (1 0).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vbbench.exchange.detection import Detections
from vbbench.geometry import BoolArray, FloatArray, IntArray, shorter_way
from vbbench_generators import _core
from vbbench_generators.tiers.tracking import TrackerSettings, get_tracking

Moved = Callable[[FloatArray], FloatArray]
"""Where boxes [N, 4] (centre column, centre row, width, height) px stand after nothing but the camera has moved."""
HEIGHT = 3
"""Place of the height among a box's coordinates."""


@dataclass(frozen=True)
class Beliefs:
    """Filter states of N boxes.

    Parameters
    ----------
    mean : [N, 4, 2] centre column, centre row, width and height in px, and their speeds in px/s.
    spread : [N, 4, 3] the covariances (P_00, P_01, P_11).
    """

    mean: FloatArray
    spread: FloatArray

    @property
    def boxes(self) -> FloatArray:
        """[N, 4] centre column, centre row, width and height in px."""
        return self.mean[..., 0]

    def take(self, rows: IntArray | BoolArray) -> "Beliefs":
        """The states of some ``rows``."""
        return Beliefs(self.mean[rows], self.spread[rows])

    def join(self, others: "Beliefs") -> "Beliefs":
        """These states, followed by the ``others``."""
        return Beliefs(np.concatenate([self.mean, others.mean]), np.concatenate([self.spread, others.spread]))


def begin(boxes: FloatArray, settings: TrackerSettings) -> Beliefs:
    """Initial states of boxes [N, 4] seen for the first time."""
    height = boxes[:, 3:]
    mean = np.stack([boxes, np.zeros_like(boxes)], axis=-1)
    place, speed = (2.0 * settings.measurement * height) ** 2, (settings.start_speed * height) ** 2
    spread = np.stack([place, np.zeros_like(place), speed], axis=-1)
    return Beliefs(mean, np.broadcast_to(spread, (*boxes.shape, 3)).copy())


def predict(beliefs: Beliefs, dt: float, settings: TrackerSettings) -> Beliefs:
    """The states predicted ``dt`` seconds later."""
    height = _heights(beliefs)
    value, speed = np.moveaxis(beliefs.mean, -1, 0)
    p, q, s = np.moveaxis(beliefs.spread, -1, 0)
    place, pace = (settings.wander * height) ** 2 * dt, (settings.acceleration * height) ** 2 * dt
    spread = [p + dt * (2.0 * q + dt * s) + place, q + dt * s, s + pace]
    return Beliefs(np.stack([value + dt * speed, speed], axis=-1), np.stack(spread, axis=-1))


def correct(beliefs: Beliefs, boxes: FloatArray, settings: TrackerSettings, period: float | None) -> Beliefs:
    """The states updated with boxes [N, 4] in px; ``period`` is the width in px of a panorama."""
    off = boxes - beliefs.boxes
    off[:, 0] = shorter_way(off[:, 0], period)
    p, q, s = np.moveaxis(beliefs.spread, -1, 0)
    total = p + (settings.measurement * _heights(beliefs)) ** 2
    mean = beliefs.mean + np.stack([p / total * off, q / total * off], axis=-1)
    return Beliefs(mean, np.stack([p - p * p / total, q - p * q / total, s - q * q / total], axis=-1))


def _heights(beliefs: Beliefs) -> FloatArray:
    """[N, 1] heights in px, at least 1, by which noise is scaled."""
    return np.maximum(beliefs.mean[:, HEIGHT:, 0], 1.0)


def associate(
    tracks: FloatArray,
    detections: FloatArray,
    least: float,
    *,
    scores: FloatArray | None = None,
    period: float | None = None,
) -> tuple[IntArray, IntArray]:
    """One-to-one association that maximises the sum of IoU above ``least``.

    Parameters
    ----------
    tracks, detections : [N, 4] and [M, 4] centre column, centre row, width and height in px.
    scores : [M] factors of the IoU with each detection.
    period : width in px of a panorama; ``None``: the picture has borders.

    Returns
    -------
    Indices [P] into ``tracks`` and [P] into ``detections``.
    """
    from scipy.optimize import linear_sum_assignment  # slow to import, and only trackers need it

    if not len(tracks) or not len(detections):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    worth = _core.worths(
        tracks, detections, np.ones(len(detections)) if scores is None else scores, least, period or 0.0
    )
    rows, columns = linear_sum_assignment(worth, maximize=True)
    paired = worth[rows, columns] > 0.0
    return rows[paired].astype(np.int64), columns[paired].astype(np.int64)


def from_centres(boxes: FloatArray) -> FloatArray:
    """Boxes [..., 4] given by centre, width and height as (left, top, width, height)."""
    return np.concatenate([boxes[..., :2] - 0.5 * boxes[..., 2:], boxes[..., 2:]], axis=-1)


@dataclass(frozen=True)
class CentredDetections:
    """Detections of one frame: boxes [N, 4] (centre column, centre row, width, height) in px, and scores [N]."""

    boxes: FloatArray
    scores: FloatArray


@dataclass(frozen=True)
class Found:
    """Tracks seen in one frame: their ids [N], boxes [N, 4], and scores [N] of the detections."""

    ids: IntArray
    boxes: FloatArray
    scores: FloatArray


class Tracker:
    """Links the detections of frame after frame.

    Parameters
    ----------
    settings : thresholds and noise.
    dt : seconds per frame.
    period : width in px of a panorama; ``None``: the picture has borders.
    """

    def __init__(self, settings: TrackerSettings, dt: float, period: float | None = None) -> None:
        self._settings, self._dt, self._period = settings, dt, period
        self._beliefs = begin(np.empty((0, 4)), settings)
        self._ids = np.empty(0, np.int64)
        self._confirmed = np.empty(0, bool)
        self._unseen = np.empty(0, np.int64)
        self._next, self._frame = 0, 0

    def step(self, detections: CentredDetections, moved: Moved | None = None) -> Found:
        """Process the next frame's detections; return the confirmed tracks seen in it.

        ``moved`` maps boxes of the frame before to this one by the camera's motion, if that is known.
        """
        if moved is not None and len(self._ids):
            self._beliefs.mean[..., 0] = moved(self._beliefs.boxes)
        self._beliefs.mean[self._unseen > 0, HEIGHT, 1] = 0.0  # a height that grows unseen grows without bounds
        self._beliefs = predict(self._beliefs, self._dt, self._settings)
        partner, used = self._pair(detections)
        rows = np.flatnonzero(partner >= 0)
        boxes = detections.boxes[partner[rows]]
        seen = correct(self._beliefs.take(rows), boxes, self._settings, self._period)
        self._beliefs.mean[rows], self._beliefs.spread[rows] = seen.mean, seen.spread
        self._confirmed[rows] = True
        self._unseen = np.where(partner >= 0, 0, self._unseen + 1)
        found = Found(self._ids[rows], seen.boxes, detections.scores[partner[rows]])
        kept = self._confirmed & (self._unseen * self._dt <= self._settings.lost_time + 1e-9)
        self._beliefs = self._beliefs.take(kept)
        self._ids, self._confirmed, self._unseen = self._ids[kept], self._confirmed[kept], self._unseen[kept]
        first = self._begin(detections, ~used)
        self._frame += 1
        return found if self._frame > 1 else first

    def _pair(self, detections: CentredDetections) -> tuple[IntArray, BoolArray]:
        """The detection [N] of each track, −1 = none, and a mask [M] of matched detections."""
        s, scores = self._settings, detections.scores
        partner, used = np.full(len(self._ids), -1), np.zeros(len(scores), bool)
        high = scores >= s.high
        stages = [
            (self._confirmed, high, s.first_overlap, True),
            (self._confirmed & (self._unseen == 0), ~high & (scores >= s.low), s.second_overlap, False),
            (~self._confirmed, high, s.confirm_overlap, True),
        ]
        for who, which, least, weigh in stages:
            tracks = np.flatnonzero(who & (partner < 0))
            free = np.flatnonzero(which & ~used)
            rows, columns = associate(
                self._beliefs.boxes[tracks],
                detections.boxes[free],
                least,
                scores=scores[free] if weigh else None,
                period=self._period,
            )
            partner[tracks[rows]] = free[columns]
            used[free[columns]] = True
        return partner, used

    def _begin(self, detections: CentredDetections, free: BoolArray) -> Found:
        """Begin tracks with ``free`` detections; those of the first frame are confirmed at once, and returned."""
        new = np.flatnonzero(free & (detections.scores >= self._settings.birth))
        ids = self._next + np.arange(len(new))
        if not len(new):
            return Found(ids, detections.boxes[new], detections.scores[new])
        self._next += len(new)
        self._beliefs = self._beliefs.join(begin(detections.boxes[new], self._settings))
        self._ids = np.concatenate([self._ids, ids])
        self._confirmed = np.concatenate([self._confirmed, np.full(len(new), self._frame == 0)])
        self._unseen = np.concatenate([self._unseen, np.zeros(len(new), np.int64)])
        return Found(ids, detections.boxes[new], detections.scores[new])


class ByteTracker:
    """The tracker for any detections, registered as ``byte``; see `vbbench.exchange.detection.TrackerFactory`."""

    def __init__(self, *, dt: float, period: float | None = None) -> None:
        self._tracker = Tracker(get_tracking().tracker, dt, period)

    def step(self, detections: Detections) -> tuple[IntArray, Detections]:
        """See `vbbench.exchange.detection.Tracker`."""
        corners, sizes = detections.boxes[:, :2], detections.boxes[:, 2:]
        centred = np.concatenate([corners + 0.5 * sizes, sizes], axis=-1)
        found = self._tracker.step(CentredDetections(centred, detections.scores))
        return found.ids, Detections(boxes=from_centres(found.boxes), scores=found.scores)
