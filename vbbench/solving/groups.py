"""Which sequences one process may solve, one after the other, without learning in one what is asked in another."""

import heapq
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.files.sequence_tables import Ranges
from vbbench.geometry import IntArray

SEQUENCES_A_PART = 256
"""Sequences that are put into groups together: more make fewer processes, and an interruption loses more."""


def ranges_of_groups(count: int) -> Ranges:
    """The parts of ``count`` sequences, each to be cut into groups of its own."""
    return [(first, min(first + SEQUENCES_A_PART, count)) for first in range(0, count, SEQUENCES_A_PART)]


def separate_groups(rows: Mapping[str, NDArray[Any]], first: int, last: int) -> list[IntArray]:
    """Sequences first ≤ index < last in as few groups as there can be, none sharing a frame of a scene within a group.

    The order in a group is random and follows from nothing, so that no solver can count which sequence it solves.

    Parameters
    ----------
    rows : the columns of ``sequences.parquet``.
    """
    scene, start, frames = (rows[name][first:last].astype(np.int64) for name in ("scene", "first_frame", "frames"))
    groups: list[list[int]] = []
    free: list[tuple[int, int]] = []  # of the groups, the frame of the present scene from which on they are free
    before = None
    for row in np.lexsort([start, scene]).tolist():
        if scene[row] != before:
            before, free = scene[row], [(0, group) for group in range(len(groups))]
        if free and free[0][0] <= start[row]:
            _, group = heapq.heappop(free)
        else:
            group = len(groups)
            groups.append([])
        groups[group].append(first + row)
        heapq.heappush(free, (int(start[row] + frames[row]), group))
    random = np.random.default_rng()
    return [random.permutation(np.array(group)) for group in groups]
