"""Assignment of tracks to the columns of a solver's arrays; columns of people who are gone are reused."""

from collections.abc import Hashable, Sequence

import numpy as np

from vbbench.geometry import IntArray

MOST = 4
"""Columns are added up to so many times the people seen at once; then whoever was out of sight longest has to go."""

NOBODY = -1


class Columns:
    """The assignment of remembered tracks to columns.

    Parameters
    ----------
    count : initial number of columns.
    patience : frames out of sight after which a track is forgotten.
    """

    def __init__(self, count: int, patience: int) -> None:
        self.count, self._patience = count, patience
        self._of: dict[Hashable, int] = {}
        self._tracks: list[Hashable] = [None] * count
        self._seen = np.full(count, NOBODY)
        self._free = list(range(count - 1, -1, -1))
        self._left: list[int] = []

    def expire(self, frame: int) -> None:
        """Forget tracks last seen ``patience`` or more frames before this one; if they return, they are new."""
        for column in np.flatnonzero((self._seen != NOBODY) & (frame - self._seen >= self._patience)).tolist():
            self._forget(column)

    def clear_for(self, tracks: Sequence[Hashable]) -> IntArray:
        """Free columns of expired tracks for the new ones among these tracks, if they are needed.

        Returns
        -------
        [M] columns whose people the solver must forget; none while enough columns were never used.
        """
        if self._lacking(tracks) <= 0:
            return np.empty(0, np.int64)
        if self.count >= MOST * len(tracks):
            seen = {self._of[track] for track in tracks if track in self._of}
            away = [column for column in self._of.values() if column not in seen]
            away.sort(key=lambda column: int(self._seen[column]))
            for column in away[: max(self._lacking(tracks) - len(self._left), 0)]:
                self._forget(column)
        cleared, self._left = self._left, []
        self._free += cleared
        return np.array(cleared, np.int64)

    def lack(self, tracks: Sequence[Hashable]) -> bool:
        """Whether the tracks need more columns than exist."""
        return self._lacking(tracks) > 0

    def widen(self, tracks: Sequence[Hashable]) -> None:
        """Double the columns, or more where these tracks need it."""
        count = max(2 * self.count, self.count + self._lacking(tracks))
        self._free = [*range(count - 1, self.count - 1, -1), *self._free]
        self._tracks += [None] * (count - self.count)
        self._seen = np.concatenate([self._seen, np.full(count - self.count, NOBODY)])
        self.count = count

    def place(self, tracks: Sequence[Hashable], frame: int) -> IntArray:
        """The columns [N] of tracks seen in this frame; assigns free columns to new tracks."""
        of, columns = self._of, np.empty(len(tracks), np.int64)
        for row, track in enumerate(tracks):
            column = of.get(track)
            if column is None:
                column = of[track] = self._free.pop()
                self._tracks[column] = track
            columns[row] = column
        self._seen[columns] = frame
        return columns

    def _lacking(self, tracks: Sequence[Hashable]) -> int:
        of = self._of
        return sum(track not in of for track in tracks) - len(self._free)

    def _forget(self, column: int) -> None:
        del self._of[self._tracks[column]]
        self._tracks[column] = None
        self._seen[column] = NOBODY
        self._left.append(column)
