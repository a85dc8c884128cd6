"""Tracks that change hands: from the newest frame on they show somebody else than before."""

import numpy as np
from scipy.special import bdtrc

from vbbench.geometry import FloatArray, IntArray
from vbbench_baselines.joint_map.real_camera.gaps import fill
from vbbench_baselines.joint_map.real_camera.identity import expect, is_doubtful, likelihoods, tell_apart
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen
from vbbench_baselines.joint_map.real_camera.window import SOMEBODY, Window, last_before

TOO_MANY = 1e-6
"""So many changes at once are less probable than this, at the rate of changes so far: it is the pose that is wrong."""

CHANGING, CHANGING_WEIGHT = 0.03, 50.0
"""The share of boxes at which a track is expected to change hands, and of how many boxes that is worth the weight."""

RECENT = 10
"""In frames: people who were seen no longer ago may be seen again."""


class Hands:
    """Whose the newest boxes are, and how often that changed.

    Attributes
    ----------
    doubts : [K] how probable it is that a track's newest box shows somebody else than it is taken for.
    """

    def __init__(self, tracks: int) -> None:
        self.doubts: FloatArray = np.zeros(tracks)
        self._changes, self._boxes = 0, 0

    def changes(
        self, rows: Window, model: Model, before: Point, point: Point, seen: Seen, columns: IntArray
    ) -> dict[int, int]:
        """Tracks whose newest boxes show somebody else than those before: which column, or `SOMEBODY`.

        ``before`` is what was believed before the newest boxes came, about the frames as they are known now.
        """
        newest, boxes = len(point.frames) - 1, seen.boxes
        self.doubts[:] = 0.0
        shown = ~np.isnan(boxes.azimuth[-1])
        asked = is_doubtful(point, seen, model)
        self._boxes += int(np.count_nonzero(shown))
        if newest == 0 or not asked.any():
            return {}
        last = np.where(shown, last_before(boxes.azimuth), seen.last)
        candidate = (asked | ~shown) & (newest - last <= RECENT) & np.isnan(seen.given[-1, :, 0])
        hidden = boxes._replace(azimuth=np.concatenate((boxes.azimuth[:-1], np.full((1, len(columns)), np.nan))))
        past = seen._replace(boxes=hidden, last=np.where(candidate, newest, -1))
        places = before.places.take(columns, axis=1)
        believed = Point(before.frames, places, before.people[columns], before.variances[columns])
        fill(places, believed.frames, past, believed.people)
        expected = expect(believed, past, model)
        likely, anew = likelihoods(point, seen, model, expected, asked)
        asking = np.flatnonzero(asked)
        whom, doubts = tell_apart(likely, anew, asking, self._changing)
        tracks = np.array([np.flatnonzero(rows.column == column)[0] for column in columns[asking]])
        self.doubts[tracks] = doubts
        moved = (whom != asking) & ((whom != SOMEBODY) | (expected.known[asking] == 1))
        changes = int(np.count_nonzero(moved))
        if bdtrc(changes - 1, np.count_nonzero(shown), self._changing) < TOO_MANY:
            self.doubts[tracks[moved]] = 1.0
            return {}
        self._changes += changes
        found = np.where(whom == SOMEBODY, SOMEBODY, columns[np.maximum(whom, 0)])
        return dict(zip(tracks[moved].tolist(), found[moved].tolist(), strict=True))

    @property
    def _changing(self) -> float:
        """The share of boxes at which tracks change hands, by what was seen so far."""
        return float((CHANGING * CHANGING_WEIGHT + self._changes) / (CHANGING_WEIGHT + self._boxes))
