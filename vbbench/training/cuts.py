"""Where a recording is cut in time so that its parts share neither a moment nor a person."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, IntArray

SHARES = (0.7, 0.15, 0.15)
"""The people of a recording who are wanted for training, validation and test."""
GAP = 4.0
"""Least time in s between two parts: who leaves still decides how those walk who come."""
LEAST_KEPT = 0.5
"""The people of a recording who must lie in a part, or it is not cut: in a dense one somebody always stays."""
FINEST = 1000
"""Most places in a recording where a cut is tried."""


class Cuts(NamedTuple):
    """Frames of a recording: training before ``train_end``, validation in between, test from ``test_begin`` on."""

    train_end: int
    validation_begin: int
    validation_end: int
    test_begin: int

    def part_of(self, first: IntArray, last: IntArray) -> IntArray:
        """[N] 0, 1 or 2 for runs of frames first ≤ t < last [N] that lie whole in a part, −1 for the others."""
        within = (last <= self.train_end, (first >= self.validation_begin) & (last <= self.validation_end))
        return np.select([*within, first >= self.test_begin], [0, 1, 2], -1)


def find_cuts(present: BoolArray, dt: float) -> Cuts | None:
    """The cuts that leave each part as many people as can be, at `SHARES`.

    A person counts for a part who is there from the first to the last frame of the person's presence. Between two parts
    lies a gap: nobody who is there before it is there after it, and it lasts `GAP` or longer. Of all such cuts, those
    are taken whose smallest part, by its share, is largest; of equal ones those that keep most people, the earliest.

    Parameters
    ----------
    present : [T, P] who is there.
    dt : seconds per frame.

    Returns
    -------
    The cuts; ``None`` if a part would have nobody, or all together less than `LEAST_KEPT` of the people.
    """
    frames, present = len(present), present[:, present.any(axis=0)]
    enter, leave = present.argmax(axis=0), frames - present[::-1].argmax(axis=0)
    places = np.unique([*range(0, frames, max(1, -(-frames // FINEST))), frames])
    resume = _resume(enter, leave, places, frames, max(1, round(GAP / dt)))
    inside = _people_inside(enter, leave, places)
    train, following = inside[0], np.minimum(np.searchsorted(places, resume), len(places) - 1)
    validation = inside[following]  # [train's end, validation's end]
    test = inside[following, -1]
    smallest = np.minimum(np.minimum(train[:, None] / SHARES[0], validation / SHARES[1]), test[None] / SHARES[2])
    best = np.argwhere(smallest == smallest.max())
    kept = [train[i] + validation[i, j] + test[j] for i, j in best]
    i, j = best[int(np.argmax(kept))]
    if smallest[i, j] <= 0.0 or max(kept) < LEAST_KEPT * present.shape[1]:
        return None
    return Cuts(*(int(places[n]) for n in (i, following[i], j, following[j])))


def _resume(enter: IntArray, leave: IntArray, places: IntArray, frames: int, gap: int) -> IntArray:
    """[C] the first frame after a gap that begins at each of the ``places`` [C]: everybody from before it has left."""
    stays = np.zeros(frames + 1, np.int64)
    np.maximum.at(stays, enter + 1, leave)
    return np.maximum(np.maximum.accumulate(stays)[places], places + gap)


def _people_inside(enter: IntArray, leave: IntArray, places: IntArray) -> IntArray:
    """[C, C] people who are only there from one of the ``places`` [C] until another one."""
    counts = np.zeros((len(places), len(places)), np.int64)
    begins = np.searchsorted(places, enter, side="right") - 1
    ends = np.searchsorted(places, leave)
    np.add.at(counts, (begins, ends), 1)
    inside: IntArray = counts[::-1].cumsum(axis=0)[::-1].cumsum(axis=1)
    return inside
