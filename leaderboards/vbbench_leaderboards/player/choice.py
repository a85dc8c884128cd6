"""Which sequences of a split can be played: over all its errors, the best and the worst among them."""

from collections.abc import Mapping

import numpy as np

from vbbench.geometry import IntArray
from vbbench_leaderboards.result import Board, Result

_BOARDS = (("sequential", "noisy"), ("sequential", "ideal"))
"""Protocol and tier by whose errors sequences are chosen: the first of them that has results, or else any board."""

_METRIC = "dx"


def choose_sequences(results: Mapping[Board, tuple[Result, ...]], count: int, available: int) -> IntArray:
    """Numbers of at most ``count`` sequences, ascending, for all boards of a split.

    They lie evenly over the order of the middle solver's Δx; the smallest and the largest are among them.

    Parameters
    ----------
    results : the boards of one split.
    count : how many are wanted.
    available : number of sequences in the dataset.
    """
    result = _middle(results[_reference(results)])
    own = result.per_sequence
    usable = np.isfinite(own.figures[_METRIC]) & (own.sequence < available)
    numbers, errors = own.sequence[usable], own.figures[_METRIC][usable]
    ranked = numbers[np.lexsort((numbers, errors))]
    places = np.unique(np.rint(np.linspace(0, len(ranked) - 1, min(count, len(ranked)))).astype(np.int64))
    return np.sort(ranked[places])


def _reference(results: Mapping[Board, tuple[Result, ...]]) -> Board:
    boards = sorted(results)
    for protocol, tier in _BOARDS:
        found = [board for board in boards if (board.protocol, board.tier) == (protocol, tier) and results[board]]
        if found:
            return found[0]
    return next(board for board in boards if results[board])


def _middle(results: tuple[Result, ...]) -> Result:
    """The result in the middle of the table; of two, the better."""
    ranked = sorted(results, key=lambda result: (result.score["metrics"][_METRIC]["mean"], result.solver))
    return ranked[(len(ranked) - 1) // 2]
