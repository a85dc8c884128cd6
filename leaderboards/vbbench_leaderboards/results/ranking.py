"""Ranks with their uncertainty: who is better than whom on a board, beyond what the choice of sequences explains.

Boards rank by capped means. Every pair of solvers is compared by its differences of each sequence's capped figures, in
a block bootstrap over time. The p-values of a metric are corrected after Holm, so that on the whole board a difference
that is none is called one with a chance of at most `LEVEL`. A solver's rank is one more than the number of solvers
that are significantly better, and no lower than that of anybody whose figure is smaller: errors that come in clumps
make a solver's mean so uncertain that nobody is significantly better, and being wrong must not pay. Solvers between
which nothing is settled can share a rank.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import get_protocol
from vbbench.scoring.block_bootstrap import Timeline, block_means
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import capped_figures
from vbbench_leaderboards.results.result import Result

LEVEL = 0.05


@dataclass(frozen=True, kw_only=True)
class Pair:
    """One metric of two solvers: mean over sequences of (a − b), both capped, so that below 0 ``a`` is better.

    Parameters
    ----------
    a, b : names of the solvers.
    difference, ci95 : the mean and its interval, in the metric's unit; NaN where they share no sequence, and no
        interval where the board has too few sequences or too little time for one.
    p : two-sided, corrected for all pairs of the board; 1 without an interval.
    """

    a: str
    b: str
    difference: float
    ci95: tuple[float, float]
    p: float

    @property
    def better(self) -> str | None:
        """The solver that is significantly better; ``None`` where neither is."""
        if not self.p < LEVEL:
            return None
        return self.a if self.difference < 0 else self.b


@dataclass(frozen=True, kw_only=True)
class Place:
    """A solver's rank, and the best and the worst rank that the figures leave open."""

    rank: int
    best: int
    worst: int


@dataclass(frozen=True, kw_only=True)
class Ranking:
    """Places of a board's solvers by one metric, and the pairs that they rest upon."""

    places: dict[str, Place]
    pairs: tuple[Pair, ...]


def rank(results: Sequence[Result]) -> dict[str, Ranking]:
    """Rankings by metric (keys of `METRICS`) of the results of one board."""
    names = [result.solver for result in results]
    pairs = list(combinations(range(len(results)), 2))
    if not pairs:
        return {metric: Ranking(places=_places(dict.fromkeys(names, 0.0), ()), pairs=()) for metric in METRICS}
    timeline, _, figures = capped_table(results)
    differences = np.stack([figures[a] - figures[b] for a, b in pairs], axis=1)
    found = block_means(timeline, differences.reshape(len(differences), -1))
    shape = (len(pairs), len(METRICS))
    mean, p = found.mean.reshape(shape), np.nan_to_num(found.p_values(), nan=1.0).reshape(shape)
    interval = found.interval().reshape(*shape, 2)
    return {
        metric: _ranking(_means(names, figures[:, :, m]), pairs, mean[:, m], interval[:, m], holm(p[:, m]))
        for m, metric in enumerate(METRICS)
    }


def _means(names: list[str], figures: FloatArray) -> dict[str, float]:
    """The means of capped errors [solvers, N] of a metric; infinite without any."""
    counts = np.isfinite(figures).sum(axis=1)
    means = np.where(counts > 0, np.nansum(figures, axis=1) / np.maximum(counts, 1), np.inf)
    return dict(zip(names, means.tolist(), strict=True))


def holm(p: FloatArray) -> FloatArray:
    """p-values [P] corrected after Holm (1979) for being P at once: none falls, and their order stays."""
    order = np.argsort(p, kind="stable")
    raised = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(raised, 1.0)
    return corrected


def capped_table(results: Sequence[Result]) -> tuple[Timeline, IntArray, FloatArray]:
    """The sequences that any result of a board has, and all their capped errors.

    Returns
    -------
    When the sequences were, their numbers [N], and figures [solvers, N, metrics], NaN where there is none.
    """
    own = [result.per_sequence for result in results]
    columns = ("sequence", "scene", "first_frame", "last_frame")
    every = np.concatenate([np.stack([getattr(one, name) for name in columns], axis=1) for one in own])
    sequences, first = np.unique(every[:, 0], return_index=True)
    caps = get_protocol(results[0].board.protocol).caps
    figures = np.full((len(results), len(sequences), len(METRICS)), np.nan)
    for row, one in zip(figures, own, strict=True):
        row[np.searchsorted(sequences, one.sequence)] = capped_figures(caps, {n: one.figures[n] for n in METRICS})
    return Timeline.of(*every[first, 1:].T), sequences, figures


def _ranking(
    means: dict[str, float], pairs: list[tuple[int, int]], mean: FloatArray, interval: FloatArray, p: FloatArray
) -> Ranking:
    """One metric's ranking, from the pairs' mean differences [P], their intervals [P, 2] and p-values [P]."""
    names = list(means)
    found = tuple(
        Pair(a=names[a], b=names[b], difference=difference, ci95=(low, high), p=value)
        for (a, b), difference, (low, high), value in zip(
            pairs, mean.tolist(), interval.tolist(), p.tolist(), strict=True
        )
    )
    return Ranking(places=_places(means, found), pairs=found)


def _places(means: dict[str, float], pairs: Sequence[Pair]) -> dict[str, Place]:
    """Places of solvers with these means."""
    settled = [(pair.better, pair.a if pair.better == pair.b else pair.b) for pair in pairs if pair.better]
    better = {name: sum(loser == name for _, loser in settled) for name in means}
    worse = {name: sum(winner == name for winner, _ in settled) for name in means}
    places, last = dict[str, Place](), 1
    for name in sorted(means, key=lambda name: (means[name], better[name])):
        last = max(last, 1 + better[name])
        places[name] = Place(rank=last, best=last, worst=max(last, len(means) - worse[name]))
    return places
