"""The last frames as a real camera saw them, in arrays that kernels take; columns are stretches of tracks.

A track that shows somebody else goes on in another column. Columns whose boxes have all left the window are used
again, so that memory and time are those of the window.
"""

from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray, IntArray, carried_along, moved_as_one
from vbbench.sequence import Given
from vbbench_baselines.common.bearings import Bearings, each
from vbbench_baselines.common.odometry import motions_of, unmeasured
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.cues import FRAME
from vbbench_baselines.joint_map.real_camera.joint import Seen
from vbbench_baselines.joint_map.real_camera.past import Past, known_before, nothing_past, turn

NOBODY, SOMEBODY = -1, -2
"""No column, and that of somebody of whom nothing is known yet."""

SHOWN_AGAIN = 3
"""Frames whose given places come with a new one: its own, and those of the two before."""

LONG_AGO = -(10**6)

SPARE = 32
"""Frames that there is room for beyond a window's, so that rows are moved only once in so many."""


class Window:
    """At most ``size`` frames, the newest last; NaN = absent or unknown.

    Attributes
    ----------
    frames : [n, 7] as believed.
    given_poses : [n, 3].
    motions, covariances : [n, 3] and [n, 3, 3] of odometry.
    places, given : [n, C, 2] in m.
    boxes : rows [n, C].
    told : [n, C] as of `Seen`; in a new frame as in the one before.
    numbers, variances : [C, 2] and [C] of people, as believed.
    past : of C people.
    column : [K] where each track is now, or `NOBODY`.
    names : [C] numbers of the people, never given twice.
    """

    def __init__(self, size: int, tracks: int, first: FloatArray, variance: float) -> None:
        self.size, self._first, self._variance = size, first, variance
        self._room, self._used = _room(size + min(size, SPARE)), slice(0, 0)
        self._show()
        self.numbers, self.variances = np.zeros((0, 2)), np.zeros(0)
        self.past = nothing_past(0)
        self.column: IntArray = np.full(tracks, NOBODY)
        self.names: IntArray = np.zeros(0, np.int64)
        self._named, self._seats = 0, deque[IntArray](maxlen=SHOWN_AGAIN)

    def _show(self) -> None:
        """The rows in use, as parts of the room that there is for them."""
        used = [rows[self._used] for rows in self._room]
        self.frames, self.given_poses, self.motions, self.covariances, self.places, self.given, self.told, *boxes = used
        self.boxes = Bearings(*boxes)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Of a copy: the rows that it shows are parts of its own room, not copies of what they were."""
        self.__dict__.update(state)
        self._show()

    def _add_row(self) -> None:
        """One more frame, of which nothing is known; the oldest leaves if there are more than ``size``."""
        begin, end = self._used.start, self._used.stop
        if end == len(self._room[0]):
            for rows in self._room:
                rows[: self.size - 1] = rows[end - self.size + 1 :]
            begin, end = 0, self.size - 1
        self._used = slice(max(begin, end + 1 - self.size), end + 1)
        for rows in self._room:
            rows[end] = np.nan if rows.dtype.kind == "f" else 0
        self._show()
        self.told[-1] = self.told[-2] if len(self.told) > 1 else 0.0

    def push(self, seen: Bearings, given: Given, start: FloatArray) -> None:
        """Add a frame that begins at ``start`` [7], and what is given of the two before it."""
        self._add_row()
        self.frames[-1] = start
        if given.odometry is not None:
            self.motions[-1], self.covariances[-1] = given.odometry.motions[-1], given.odometry.covariances[-1]
        here = ~np.isnan(seen.azimuth) | ~np.isnan(given.positions[:, :, 0]).all(axis=0)
        self._seat(np.flatnonzero(here & (self.column == NOBODY)))
        tracks = np.flatnonzero(self.column != NOBODY)
        columns = self.column[tracks]
        for rows, values in zip(self.boxes, seen, strict=True):
            rows[-1, columns] = values[tracks]
        self._seats.append(self.column.copy())
        for back in range(1, min(SHOWN_AGAIN, len(self.frames)) + 1):
            if not np.isnan(given.poses[-back, 0]):
                self.given_poses[-back] = given.poses[-back]
                turns = 0.0 if back == len(self.frames) else self.frames[-back - 1, 2] - given.poses[-back, 2]
                self.frames[-back, :3] = given.poses[-back]
                self.frames[-back, 2] += 2.0 * np.pi * np.round(turns / (2.0 * np.pi))
            known = ~np.isnan(given.positions[-back, :, 0]) & (self._seats[-back] != NOBODY)
            self.given[-back, self._seats[-back][known]] = given.positions[-back, known]

    def reseat(self, changed: Mapping[int, int]) -> None:
        """The newest boxes of these tracks show the people in other columns than before, or `SOMEBODY`."""
        tracks = np.array(list(changed))
        before = self.column[tracks]
        newest: list[Any] = [rows[-1, before].copy() for rows in (*self.boxes, self.given)]
        for rows in (*self.boxes[:5], self.given, self.places):
            rows[-1, before] = np.nan
        now = np.array([changed[track] for track in tracks])
        known = now != SOMEBODY
        self.column[np.isin(self.column, now[known])] = NOBODY
        self.column[tracks] = np.where(known, now, NOBODY)
        self._seat(tracks[~known])
        self._seats[-1] = self.column.copy()
        for target, values in zip((*self.boxes, self.given), newest, strict=True):
            target[-1, self.column[tracks]] = values

    def forget(self, columns: IntArray) -> None:
        """The tracks [M] stand for new people."""
        for seats in (self.column, *self._seats):
            seats[columns] = NOBODY

    def _seat(self, tracks: IntArray) -> None:
        """Give ``tracks`` [M] columns, those first that nobody is in any more."""
        if len(tracks) == 0:
            return
        used = np.zeros(self.places.shape[1], np.bool_)
        used[self.present()] = True
        used[self.column[self.column != NOBODY]] = True
        free = np.flatnonzero(~used)[: len(tracks)]
        missing = len(tracks) - len(free)
        if missing > 0:
            self._widen(max(missing, len(used) // 4))  # a few at once: not every newcomer moves all that is known
            free = np.concatenate((free, len(used) + np.arange(missing)))
        self.places[:, free], self.told[:, free] = np.nan, 0.0
        for rows in self.past:
            rows[free] = 0.0
        self.numbers[free], self.variances[free] = self._first, self._variance
        self.names[free] = self._named + np.arange(len(free))
        self._named += len(free)
        self.column[tracks] = free

    def _widen(self, more: int) -> None:
        """So many ``more`` columns, empty."""
        columns = self.places.shape[1] + more
        wide = _room(len(self._room[0]), columns)
        for rows, before in zip(wide, self._room, strict=True):
            rows[:, : before.shape[1]] = before
        self._room = wide
        self._show()
        self.numbers = np.concatenate((self.numbers, np.zeros((more, 2))))
        self.variances = np.concatenate((self.variances, np.zeros(more)))
        self.names = np.concatenate((self.names, np.zeros(more, np.int64)))
        self.past = Past(*(np.concatenate(rows) for rows in zip(self.past, nothing_past(more), strict=True)))

    def present(self) -> IntArray:
        """The columns [M] of whom anything is known in these frames; tracks that left give theirs up."""
        known = (~np.isnan(self.boxes.azimuth) | ~np.isnan(self.given[..., 0])).any(axis=0)
        return np.flatnonzero(known)

    def leave(self) -> None:
        """Tracks of which nothing is known in these frames give up their columns."""
        gone = np.ones(self.places.shape[1] + 1, np.bool_)
        gone[self.present()] = False
        self.column[gone[self.column]] = NOBODY

    def move(self, moved: FloatArray) -> None:
        """Move each frame [n, 2] with all that is believed of it; what boxes tell of people stays."""
        self.frames[:, :2] += moved
        self.places += moved[:, None]
        reach = min(len(moved), REACH)
        self.past.about[:, : 2 * reach] += moved[:reach].ravel()

    def move_as_one(self, old: FloatArray, new: FloatArray) -> None:
        """Move all that is believed, so that a pose ``old`` [3] becomes ``new``; given places stay."""
        yaw = self.frames[:, 2] + new[2] - old[2]
        self.frames[:, :3] = moved_as_one(self.frames[:, :3], old, new)
        self.frames[:, 2] = yaw
        self.places[:] = np.where(np.isnan(self.given), carried_along(self.places, old, new), self.places)
        turn(self.past, old, new)

    def carry_on(self, seen: Seen, columns: IntArray) -> None:
        """Keep what is told in ``seen`` of the past of people in these ``columns`` [M]."""
        for rows, told in zip(self.past, seen.past, strict=True):
            rows[columns] = told

    def seen(self, block: slice = slice(None), held: int = 0) -> tuple[Seen, IntArray]:
        """The frames of a ``block`` as kernels take them, and the columns [M] of whom anything is known in them.

        Besides given poses those of the first ``held`` frames stay.
        """
        known = ~np.isnan(self.boxes.azimuth[block]) | ~np.isnan(self.given[block, :, 0])
        columns = np.flatnonzero(known.any(axis=0))
        known = known[:, columns]
        boxes = each(lambda rows: rows[block].take(columns, axis=1), self.boxes)
        first, last = np.argmax(known, axis=0), len(known) - 1 - np.argmax(known[::-1], axis=0)
        fixed = ~np.isnan(self.given_poses[block, 0])
        fixed[:held] = True
        motions = motions_of(self.motions[block], self.covariances[block])
        given = self.given[block].take(columns, axis=1)
        blind = np.asarray(np.isnan(boxes.azimuth).all(axis=1))
        sure = np.zeros(len(columns), np.bool_)
        past = Past(*(rows[columns] for rows in self.past))
        first = np.where(known_before(past), 0, first)
        told = self.told[block].take(columns, axis=1)
        return Seen(boxes, given, fixed, unmeasured(motions), blind, first, last, sure, motions, past, told), columns


def last_before(azimuth: FloatArray) -> IntArray:
    """[K] the last frame before the newest with a box, of ``azimuth`` [T, K]; long ago if there is none."""
    seen = ~np.isnan(azimuth[:-1])
    return np.where(seen.any(axis=0), len(seen) - 1 - np.argmax(seen[::-1], axis=0), LONG_AGO)


def _room(size: int, columns: int = 0) -> list[Any]:
    """For so many frames and columns: frames, given poses, odometry and its covariances, places, given, told, boxes."""
    shapes = ((FRAME,), (3,), (3,), (3, 3), (columns, 2), (columns, 2), (columns,), *[(columns,)] * 5)
    return [*(np.full((size, *shape), np.nan) for shape in shapes), np.zeros((size, columns), np.int64)]
