"""The last frames as a real camera saw them, in arrays that kernels take; columns are stretches of tracks.

A track that jumps begins anew in another column. Columns whose boxes have all left the window are used again, so that
memory and time are those of the window.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.sequence import Given
from vbbench_baselines.common.bearings import Bearings, each
from vbbench_baselines.common.odometry import motions_of, unmeasured
from vbbench_baselines.joint_map.real_camera.cues import FRAME
from vbbench_baselines.joint_map.real_camera.joint import Seen

NOBODY = -1

_NONE = np.zeros((0, 0))
NOTHING = Bearings(_NONE, _NONE, _NONE, _NONE, _NONE, _NONE.astype(np.int64))


class Window:
    """At most ``size`` frames, the newest last; NaN = absent or unknown.

    Attributes
    ----------
    frames : [n, 7] as believed.
    given_poses : [n, 3].
    places, given : [n, C, 2] in m.
    boxes : rows [n, C].
    numbers, variances : [C, 2] and [C] of people, as believed.
    column : [K] where each track is now, or `NOBODY`.
    """

    def __init__(self, size: int, tracks: int, first: FloatArray, variance: float) -> None:
        self.size, self._first, self._variance = size, first, variance
        self.frames, self.given_poses = np.zeros((0, FRAME)), np.zeros((0, 3))
        self.motions, self.covariances = np.zeros((0, 3)), np.zeros((0, 3, 3))
        self.places, self.given = np.zeros((2, 0, 0, 2))
        self.boxes = each(np.copy, NOTHING)
        self.numbers, self.variances = np.zeros((0, 2)), np.zeros(0)
        self.column: IntArray = np.full(tracks, NOBODY)

    def push(self, seen: Bearings, given: Given, start: FloatArray) -> None:
        """Add a frame that begins at ``start`` [7], and what is given of the two before it."""
        kept = slice(max(len(self.frames) + 1 - self.size, 0), None)
        self.frames = np.concatenate((self.frames[kept], start[None]))
        self.given_poses = np.concatenate((self.given_poses[kept], np.full((1, 3), np.nan)))
        odometry = given.odometry
        moved = np.full((1, 3), np.nan) if odometry is None else odometry.motions[-1:]
        spread = np.full((1, 3, 3), np.nan) if odometry is None else odometry.covariances[-1:]
        self.motions = np.concatenate((self.motions[kept], moved))
        self.covariances = np.concatenate((self.covariances[kept], spread))
        self.places, self.given = (_longer(rows[kept]) for rows in (self.places, self.given))
        self.boxes = each(lambda rows: _longer(rows[kept]), self.boxes)
        here = ~np.isnan(seen.azimuth) | ~np.isnan(given.positions[:, :, 0]).all(axis=0)
        self._seat(np.flatnonzero(here & (self.column == NOBODY)))
        tracks = np.flatnonzero(self.column != NOBODY)
        columns = self.column[tracks]
        for rows, values in zip(self.boxes, seen, strict=True):
            rows[-1, columns] = values[tracks]
        for back in range(1, min(3, len(self.frames)) + 1):
            if not np.isnan(given.poses[-back, 0]):
                self.given_poses[-back] = given.poses[-back]
                turns = 0.0 if back == len(self.frames) else self.frames[-back - 1, 2] - given.poses[-back, 2]
                self.frames[-back, :3] = given.poses[-back]
                self.frames[-back, 2] += 2.0 * np.pi * np.round(turns / (2.0 * np.pi))
            known = ~np.isnan(given.positions[-back, tracks, 0])
            self.given[-back, columns[known]] = given.positions[-back, tracks[known]]

    def begin_anew(self, tracks: Sequence[int]) -> None:
        """The newest boxes of these tracks belong to somebody else than those before."""
        for track in tracks:
            old = self.column[track]
            self.column[track] = NOBODY
            self._seat(np.array([track]))
            new = self.column[track]
            for rows in (*self.boxes, self.given):
                rows[-1, new] = rows[-1, old]
            for rows in (*self.boxes[:5], self.given, self.places):
                rows[-1, old] = np.nan

    def forget(self, columns: IntArray) -> None:
        """The tracks [M] stand for new people."""
        self.column[columns] = NOBODY

    def _seat(self, tracks: IntArray) -> None:
        """Give ``tracks`` [M] columns, those first that nobody is in any more."""
        used = np.zeros(self.places.shape[1], np.bool_)
        used[self.present()] = True
        used[self.column[self.column != NOBODY]] = True
        free = np.flatnonzero(~used)[: len(tracks)]
        missing = len(tracks) - len(free)
        if missing > 0:
            free = np.concatenate((free, self.places.shape[1] + np.arange(missing)))
            self.places, self.given = (_wider(rows, missing) for rows in (self.places, self.given))
            self.boxes = each(lambda rows: _wider(rows, missing), self.boxes)
            self.numbers = np.concatenate((self.numbers, np.zeros((missing, 2))))
            self.variances = np.concatenate((self.variances, np.zeros(missing)))
        self.places[:, free] = np.nan
        self.numbers[free], self.variances[free] = self._first, self._variance
        self.column[tracks] = free

    def present(self) -> IntArray:
        """The columns [M] of whom anything is known in these frames; tracks that left give theirs up."""
        known = (~np.isnan(self.boxes.azimuth) | ~np.isnan(self.given[..., 0])).any(axis=0)
        return np.flatnonzero(known)

    def leave(self) -> None:
        """Tracks of which nothing is known in these frames give up their columns."""
        gone = np.ones(self.places.shape[1] + 1, np.bool_)
        gone[self.present()] = False
        self.column[gone[self.column]] = NOBODY

    def seen(self, block: slice = slice(None), held: int = 0) -> tuple[Seen, IntArray]:
        """The frames of a ``block`` as kernels take them, and the columns [M] of whom anything is known in them.

        Besides given poses those of the first ``held`` frames stay.
        """
        known = (~np.isnan(self.boxes.azimuth) | ~np.isnan(self.given[..., 0]))[block]
        columns = np.flatnonzero(known.any(axis=0))
        known = known[:, columns]
        boxes = each(lambda rows: rows[block].take(columns, axis=1), self.boxes)
        first, last = np.argmax(known, axis=0), len(known) - 1 - np.argmax(known[::-1], axis=0)
        fixed = ~np.isnan(self.given_poses[block, 0])
        fixed[:held] = True
        motions = motions_of(self.motions[block], self.covariances[block])
        given = self.given[block].take(columns, axis=1)
        return Seen(boxes, given, fixed, unmeasured(motions), first, last, motions), columns


def _longer(rows: Any) -> Any:
    """One more row, empty."""
    empty = np.full((1, *rows.shape[1:]), np.nan if rows.dtype.kind == "f" else 0, rows.dtype)
    return np.concatenate((rows, empty))


def _wider(rows: Any, columns: int) -> Any:
    """So many more columns, empty."""
    shape = (rows.shape[0], columns, *rows.shape[2:])
    return np.concatenate((rows, np.full(shape, np.nan if rows.dtype.kind == "f" else 0, rows.dtype)), axis=1)
