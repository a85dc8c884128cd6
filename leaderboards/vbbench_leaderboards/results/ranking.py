"""Ranks with their uncertainty: who is better than whom on a board, beyond what the choice of sequences explains.

Every pair of solvers is compared by a paired bootstrap over sequences, with the same draws for all. The p-values of a
metric are corrected after Holm, so that on the whole board a difference that is none is called one with a chance of
at most `LEVEL`. A solver's rank is one more than the number of solvers that are significantly better; solvers between
which nothing is settled can share a rank.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.statistics import RESAMPLES, bootstrap_means, two_sided_p
from vbbench_leaderboards.results.result import Result

LEVEL = 0.05

_RESAMPLES_A_PAIR = 80
"""Resamples per pair: the smallest p-value, 2/(R + 1), times the number of pairs must stay below `LEVEL`."""


@dataclass(frozen=True, kw_only=True)
class Pair:
    """One metric of two solvers: mean over sequences of (a − b), so that below 0 ``a`` is better.

    Parameters
    ----------
    a, b : names of the solvers.
    difference, ci95 : the mean and its bootstrap interval, in the metric's unit; NaN where they share no sequence.
    p : two-sided, corrected for all pairs of the board.
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
        return {metric: Ranking(places=_places(names, ()), pairs=()) for metric in METRICS}
    figures = _figures(results)
    differences = np.stack([figures[a] - figures[b] for a, b in pairs], axis=1)
    return {
        metric: _ranking(names, pairs, own, means)
        for metric, own, means in zip(METRICS, np.moveaxis(differences, 2, 0), _resampled(differences), strict=True)
    }


def holm(p: FloatArray) -> FloatArray:
    """p-values [P] corrected after Holm (1979) for being P at once: none falls, and their order stays."""
    order = np.argsort(p, kind="stable")
    raised = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(raised, 1.0)
    return corrected


def _figures(results: Sequence[Result]) -> FloatArray:
    """[solvers, sequences, metrics] over the sequences that any of them has, NaN where one has none."""
    sequences = np.unique(np.concatenate([result.per_sequence.sequence for result in results]))
    figures = np.full((len(results), len(sequences), len(METRICS)), np.nan)
    for row, result in zip(figures, results, strict=True):
        own = result.per_sequence
        row[np.searchsorted(sequences, own.sequence)] = np.stack([own.figures[name] for name in METRICS], axis=-1)
    return figures


def _resampled(differences: FloatArray) -> FloatArray:
    """Bootstrap means [metrics, resamples, pairs] of differences [sequences, pairs, metrics]."""
    sequences, pairs, metrics = differences.shape
    resamples = max(RESAMPLES, _RESAMPLES_A_PAIR * pairs)
    means = bootstrap_means(differences.reshape(sequences, -1), resamples)
    return np.moveaxis(means.reshape(resamples, pairs, metrics), 2, 0)


def _ranking(names: list[str], pairs: list[tuple[int, int]], differences: FloatArray, means: FloatArray) -> Ranking:
    """One metric's ranking, from differences [sequences, pairs] and their bootstrap means [resamples, pairs]."""
    there = np.isfinite(differences)
    known = there.any(axis=0)
    total = np.where(there, differences, 0.0).sum(axis=0)
    mean = np.where(known, total / np.maximum(there.sum(axis=0), 1), np.nan)
    low, high = np.quantile(means, [0.025, 0.975], axis=0)
    p = holm(np.where(known, two_sided_p(means), 1.0))
    found = tuple(
        Pair(a=names[a], b=names[b], difference=float(mean[n]), ci95=(float(low[n]), float(high[n])), p=float(p[n]))
        for n, (a, b) in enumerate(pairs)
    )
    return Ranking(places=_places(names, found), pairs=found)


def _places(names: list[str], pairs: Sequence[Pair]) -> dict[str, Place]:
    settled = [(pair.better, pair.a if pair.better == pair.b else pair.b) for pair in pairs if pair.better]
    better = {name: sum(loser == name for _, loser in settled) for name in names}
    worse = {name: sum(winner == name for winner, _ in settled) for name in names}
    return {name: Place(rank=1 + better[name], best=1 + better[name], worst=len(names) - worse[name]) for name in names}
