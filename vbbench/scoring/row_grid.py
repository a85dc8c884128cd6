"""Dense numbers for the frames, and for the (frame, track) pairs, of consecutive sequences."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.geometry import IntArray

SPARSEST = 64
"""Ids that span more than so many numbers a track, and a few besides, are searched for instead of indexed by."""


class RowGrid:
    """Numbers every frame (its slot) and every track in every frame (its cell), so that rows are found by indexing.

    Parameters
    ----------
    first : number of the first sequence.
    frames : [N] frames of the sequences first, first + 1, …
    sequence, track : [R] who is seen in which sequence; repeats are fine.
    """

    def __init__(self, first: int, frames: ArrayLike, sequence: IntArray, track: IntArray) -> None:
        self.first = first
        self.frames = np.asarray(frames, dtype=np.int64)
        self._tracks = np.unique(track)
        seen = np.zeros((len(self.frames), len(self._tracks)), dtype=bool)
        seen[sequence - first, np.searchsorted(self._tracks, track)] = True
        column = np.where(seen, np.cumsum(seen, axis=1) - 1, -1)
        self._column = np.pad(column, ((0, 0), (0, 1)), constant_values=-1)  # the last: a track that nobody sees
        self._place_of_id = _places_by_id(self._tracks)
        self._width = seen.sum(axis=1)
        self._first_slot = _starts(self.frames)
        self._first_cell = _starts(self.frames * self._width)
        self._first_group = _starts(self._width)

    @property
    def slots(self) -> int:
        """Number of frames."""
        return int(self.frames.sum())

    @property
    def cells(self) -> int:
        """Number of pairs of a frame and a track of its sequence."""
        return int((self.frames * self._width).sum())

    def slot(self, sequence: IntArray, frame: IntArray) -> IntArray:
        """Slot of each row [R]; −1 where the sequence has no such frame."""
        local = sequence - self.first
        there = (frame >= 0) & (frame < self.frames[local])
        return np.where(there, self._first_slot[local] + frame, -1)

    def column(self, sequence: IntArray, track: IntArray) -> IntArray:
        """Column of each row's track [R] within its sequence; −1 where the sequence never sees that track."""
        return self._column[sequence - self.first, self._place(track)]

    def _place(self, track: IntArray) -> IntArray:
        """Where each id [R] stands among all tracks; −1 for one that no sequence sees."""
        if not len(self._tracks):
            return np.full(len(track), -1)
        if self._place_of_id is not None:
            offset = np.subtract(track, self._tracks[0], dtype=np.int64)
            beyond = len(self._place_of_id) - 1
            return self._place_of_id[np.where((offset < 0) | (offset > beyond), beyond, offset)]
        place = np.searchsorted(self._tracks, track).clip(max=len(self._tracks) - 1)
        return np.where(self._tracks[place] == track, place, -1)

    def cell(self, sequence: IntArray, frame: IntArray, track: IntArray) -> IntArray:
        """Cell of each row [R]; −1 where the sequence has no such frame or never sees that track."""
        local, column = sequence - self.first, self.column(sequence, track)
        there = (column >= 0) & (frame >= 0) & (frame < self.frames[local])
        return np.where(there, self._first_cell[local] + frame * self._width[local] + column, -1)

    def group(self, sequence: IntArray, track: IntArray) -> IntArray:
        """One number for each track of each sequence [R]; only for tracks that are there."""
        return self._first_group[sequence - self.first] + self.column(sequence, track)


def rows_by_number(number: IntArray, size: int) -> NDArray[np.int32]:
    """[size + 1] the row that bears each slot or cell number, of several the last; −1 for none, and at number −1."""
    row = np.full(size + 1, -1, dtype=np.int32)
    row[number] = np.arange(len(number), dtype=np.int32)
    row[-1] = -1
    return row


def _places_by_id(tracks: IntArray) -> IntArray | None:
    """[span + 1] the place of each id from the least to one beyond the greatest, −1 for none; `None`: too sparse."""
    if not len(tracks):
        return None
    span = int(tracks[-1]) - int(tracks[0]) + 1
    if span > SPARSEST * (len(tracks) + SPARSEST):
        return None
    places = np.full(span + 1, -1)
    places[tracks - tracks[0]] = np.arange(len(tracks))
    return places


def _starts(counts: IntArray) -> IntArray:
    return np.cumsum(counts) - counts
