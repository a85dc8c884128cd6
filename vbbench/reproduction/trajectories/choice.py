"""Which sequence of a split is shown: an ordinary one in which the observer walks."""

import numpy as np

from vbbench.generation.generator import Plan
from vbbench.geometry import FloatArray
from vbbench.sequence import SequenceData

CANDIDATES = 60
"""Most sequences of a split that are looked at, evenly spread over it."""


def typical_sequence(plan: Plan) -> int:
    """The number of the sequence nearest to the middle of its split.

    Of the sequences whose observer gets as far from its start as half of them do, or farther, it is the one whose
    frames and people come nearest to the split's medians: |ln(T/median T)| + |ln(K/median K)| is least, T being its
    frames and K the mean number of people seen in a frame. Of equal ones the first is taken.
    """
    numbers = np.unique(np.linspace(0, len(plan) - 1, min(len(plan), CANDIDATES)).round().astype(int))
    frames, people, ways = np.array([_measures(plan.build(int(number))) for number in numbers]).T
    apart = _off_the_median(frames) + _off_the_median(people)
    known = np.isfinite(ways)
    if known.any():
        apart[ways < np.median(ways[known])] = np.inf
    return int(numbers[apart.argmin()])


def _measures(data: SequenceData) -> tuple[float, float, float]:
    """Frames, people seen in a frame, and how far in m the observer ends from where it began; NaN if nobody knows."""
    seen, path = data.sequence.observed.sum(axis=1), data.truth.poses[:, :2]
    return float(len(seen)), float(seen.mean()), float(np.hypot(*(path[-1] - path[0])))


def _off_the_median(values: FloatArray) -> FloatArray:
    return np.asarray(np.abs(np.log(values / np.median(values))))
