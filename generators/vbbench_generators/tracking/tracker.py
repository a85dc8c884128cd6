"""A tracker in two stages, after ByteTrack (Zhang et al. 2022): sure detections first, then doubtful ones.

In each frame tracks are predicted by their Kalman filters. Confirmed tracks, lost ones too, are paired with detections
of high score; those that were seen a frame ago and got none, with detections of low score: somebody half hidden keeps
the track. New tracks are confirmed by a second detection right after the first, or forgotten; whatever sure detections
are left begin tracks. A track without a detection is lost, goes on blindly, and is given up after a while.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators.tracking.association import associate
from vbbench_generators.tracking.kalman import begin, correct, predict
from vbbench_generators.tracking.settings import TrackerSettings

HEIGHT = 3
"""Place of the height among a box's coordinates."""


@dataclass(frozen=True)
class Detections:
    """What a detector finds in one frame: boxes [N, 4] (centre column, centre row, width, height) px, scores [N]."""

    boxes: FloatArray
    scores: FloatArray


@dataclass(frozen=True)
class Found:
    """What a tracker says of one frame: ids [N] of tracks seen in it, boxes [N, 4], scores [N] of the detections."""

    ids: IntArray
    boxes: FloatArray
    scores: FloatArray


class Tracker:
    """Links the detections of frame after frame.

    Parameters
    ----------
    settings : see there.
    dt : seconds a frame.
    period : width in px of a picture that closes on itself.
    """

    def __init__(self, settings: TrackerSettings, dt: float, period: float | None = None) -> None:
        self._settings, self._dt, self._period = settings, dt, period
        self._beliefs = begin(np.empty((0, 4)), settings)
        self._ids = np.empty(0, np.int64)
        self._confirmed = np.empty(0, bool)
        self._unseen = np.empty(0, np.int64)
        self._next, self._frame = 0, 0

    def step(self, detections: Detections) -> Found:
        """Take in the next frame's detections; tell of the confirmed tracks that were seen in it."""
        self._predict()
        partner, used = self._pair(detections)
        rows = np.flatnonzero(partner >= 0)
        boxes = detections.boxes[partner[rows]]
        seen = correct(self._beliefs.take(rows), boxes, self._settings, self._period)
        self._beliefs.mean[rows], self._beliefs.spread[rows] = seen.mean, seen.spread
        self._confirmed[rows] = True
        self._unseen = np.where(partner >= 0, 0, self._unseen + 1)
        found = Found(self._ids[rows], seen.boxes, detections.scores[partner[rows]])
        self._keep(self._confirmed & (self._unseen * self._dt <= self._settings.lost_time + 1e-9))
        first = self._begin(detections, ~used)
        self._frame += 1
        return found if self._frame > 1 else first

    def _predict(self) -> None:
        lost = self._unseen > 0
        self._beliefs.mean[lost, HEIGHT, 1] = 0.0  # a height that grows unseen grows without bounds
        self._beliefs = predict(self._beliefs, self._dt, self._settings)

    def _pair(self, detections: Detections) -> tuple[IntArray, BoolArray]:
        """[N] detection paired with each track, −1 = none, and [M] which detections are used."""
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

    def _begin(self, detections: Detections, free: BoolArray) -> Found:
        """New tracks; those of the very first frame are confirmed at once."""
        new = np.flatnonzero(free & (detections.scores >= self._settings.birth))
        ids = self._next + np.arange(len(new))
        self._next += len(new)
        self._beliefs = self._beliefs.join(begin(detections.boxes[new], self._settings))
        self._ids = np.concatenate([self._ids, ids])
        self._confirmed = np.concatenate([self._confirmed, np.full(len(new), self._frame == 0)])
        self._unseen = np.concatenate([self._unseen, np.zeros(len(new), np.int64)])
        return Found(ids, detections.boxes[new], detections.scores[new])

    def _keep(self, rows: BoolArray) -> None:
        self._beliefs = self._beliefs.take(rows)
        self._ids, self._confirmed, self._unseen = self._ids[rows], self._confirmed[rows], self._unseen[rows]
