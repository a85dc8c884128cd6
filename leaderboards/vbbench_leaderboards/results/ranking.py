"""Ranks with their uncertainty: who is better than whom on a board, beyond what the choice of sequences explains.

Boards rank by capped means. Every pair of solvers is compared by its differences of each sequence's capped figures, in
a block bootstrap over time. The p-values of a metric are corrected after Holm, so that on the whole board a difference
that is none is called one with a chance of at most `LEVEL`. A solver's rank is one more than the number of solvers
that are significantly better, and no lower than that of any solver whose figure is smaller: errors that come in clumps
make a solver's mean so uncertain that nobody is significantly better, and being wrong must not pay. Solvers without
a significant difference can share a rank.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.scoring.block_bootstrap import Timeline, block_means
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import capped_figures
from vbbench_leaderboards.results.boards import HEADLINE_METRIC, HEADLINE_PROTOCOL
from vbbench_leaderboards.results.folder import Boards
from vbbench_leaderboards.results.result import Board, Interval, Result

LEVEL = 0.05

GROUPS = {
    (False, False): "",
    (False, True): "Trained or tuned on recordings of this board, so figures are not of unseen data: ranked among "
    "themselves",
    (True, False): "These see frames after the one they answer: ranked among themselves",
    (True, True): "These see frames after the one they answer, and were trained or tuned on recordings of this board: "
    "ranked among themselves",
}
"""Groups of solvers that compete (`Result.group`) in the order of a table, with the words above their rows."""

SEEN_MARK, SEEN_WORDS = "†", "trained or tuned on recordings of the board"
"""The mark of a figure in a table without room for words, and what it means."""

KINDS = {
    (False, False): "causal solvers",
    (False, True): f"causal solvers {SEEN_WORDS}",
    (True, False): "solvers that see the future",
    (True, True): f"solvers that see the future, {SEEN_WORDS}",
}
"""What the solvers of a group are called in a sentence."""


@dataclass(frozen=True, kw_only=True)
class Pair:
    """One metric of two solvers: mean over sequences of (a − b), both capped, so that below 0 ``a`` is better.

    Parameters
    ----------
    a, b : names of the solvers.
    difference, ci95 : the mean and its interval, in the metric's unit; NaN where they share no sequence, and no
        interval where the board has too few sequences or too little time for one.
    p : two-sided; corrected for all pairs of the board, 1 without an interval.
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


def headline(result: Result, metric: str) -> Interval:
    """The figure by which a metric ranks."""
    figures = summary(result, metric)
    return Interval(figures["capped"], *figures["capped_ci95"])


def ranking_figure(result: Result) -> float:
    """The figure by which the rows of a table are ordered; infinite where there is none."""
    value = headline(result, HEADLINE_METRIC).value
    return math.inf if value is None else value


def failure_rate(result: Result) -> float | None:
    """The share of sequences in which people are lost: a mean Δx beyond the protocol's threshold."""
    rate: float | None = summary(result, "dx")["failure_rate"]
    return rate


def summary(result: Result, metric: str) -> dict[str, Any]:
    """All figures of a metric over the board."""
    found: dict[str, Any] = result.score[METRICS[metric].section][metric]
    return found


def grouped(results: Iterable[Result]) -> dict[tuple[bool, bool], list[Result]]:
    """The results of each group that has any, in the order of `GROUPS`."""
    rows = list(results)
    found = {group: [one for one in rows if one.group == group] for group in GROUPS}
    return {group: own for group, own in found.items() if own}


def rank_apart(results: Sequence[Result]) -> dict[str, Ranking]:
    """Rankings by metric of a board's results: only those of one group compete with one another."""
    ranked = [rank(rows) for rows in grouped(results).values()]
    return {
        metric: Ranking(
            places={name: place for one in ranked for name, place in one[metric].places.items()},
            pairs=tuple(pair for one in ranked for pair in one[metric].pairs),
        )
        for metric in METRICS
    }


def rank(results: Sequence[Result]) -> dict[str, Ranking]:
    """Rankings by metric (keys of `METRICS`) of the results of one board."""
    names = [result.solver for result in results]
    figures, timeline = capped_errors(results)
    counts = np.isfinite(figures).sum(axis=1)
    means = np.where(counts > 0, np.nansum(figures, axis=1) / np.maximum(counts, 1), np.inf)
    one, other = np.triu_indices(len(results), 1)
    differences = np.moveaxis(figures[one] - figures[other], 1, 0)  # [N, pairs, metrics]
    ends = [(names[a], names[b]) for a, b in zip(one, other, strict=True) for _ in METRICS]
    every = _pairs(ends, timeline, differences.reshape(figures.shape[1], -1))
    rankings = {}
    for m, metric in enumerate(METRICS):
        own = every[m :: len(METRICS)]
        corrected = holm(np.nan_to_num(np.array([pair.p for pair in own]), nan=1.0)).tolist()
        pairs = tuple(replace(pair, p=p) for pair, p in zip(own, corrected, strict=True))
        places = _places(dict(zip(names, means[:, m].tolist(), strict=True)), pairs)
        rankings[metric] = Ranking(places=places, pairs=pairs)
    return rankings


def _pairs(names: Sequence[tuple[str, str]], timeline: Timeline, differences: FloatArray) -> list[Pair]:
    """A pair for every column of differences A − B [N, M], whose solvers are (A, B); p of each alone."""
    found = block_means(timeline, differences)
    columns = (column.tolist() for column in (found.mean, found.interval(), found.p_values()))
    return [
        Pair(a=a, b=b, difference=mean, ci95=(low, high), p=p)
        for (a, b), mean, (low, high), p in zip(names, *columns, strict=True)
    ]


def capped_errors(results: Sequence[Result]) -> tuple[FloatArray, Timeline]:
    """[solvers, N, metrics] capped errors of all sequences, NaN where there is none; and when the sequences were."""
    own = [result.per_sequence for result in results]
    columns = ("sequence", "scene", "first_frame", "last_frame")
    every = np.concatenate([np.stack([getattr(one, name) for name in columns], axis=1) for one in own])
    sequences, first = np.unique(every[:, 0], return_index=True)
    caps = get_protocol(results[0].board.protocol).caps
    figures = np.full((len(results), len(sequences), len(METRICS)), np.nan)
    for row, one in zip(figures, own, strict=True):
        row[np.searchsorted(sequences, one.sequence)] = capped_figures(caps, {n: one.figures[n] for n in METRICS})
    return figures, Timeline.of(*every[first, 1:].T)


def holm(p: FloatArray) -> FloatArray:
    """p-values [P] corrected after Holm (1979) for being P at once: none falls, and their order stays."""
    order = np.argsort(p, kind="stable")
    raised = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(raised, 1.0)
    return corrected


def _places(means: dict[str, float], pairs: Sequence[Pair]) -> dict[str, Place]:
    """Places of solvers with these means."""
    decided = [(pair.better, pair.a if pair.better == pair.b else pair.b) for pair in pairs if pair.better]
    better = {name: sum(loser == name for _, loser in decided) for name in means}
    worse = {name: sum(winner == name for winner, _ in decided) for name in means}
    places, last = dict[str, Place](), 1
    for name in sorted(means, key=lambda name: (means[name], better[name])):
        last = max(last, 1 + better[name])
        places[name] = Place(rank=last, best=last, worst=max(last, len(means) - worse[name]))
    return places


def leading_rows(results: Boards, boards: Sequence[Board], *, late: bool) -> dict[str, Mapping[Board, Result]]:
    """Solver → its results on these boards, the best first: of those that see the future (``late``), or of others."""
    rows: dict[str, dict[Board, Result]] = {}
    for board in boards:
        for result in results[board]:
            if result.about.sees_the_future is late:
                rows.setdefault(result.solver, {})[board] = result
    order = sorted(rows, key=lambda solver: (_standing(rows[solver], boards), solver))
    return {solver: rows[solver] for solver in order}


def _standing(own: Mapping[Board, Result], boards: Sequence[Board]) -> float:
    """Geometric mean of the capped errors over the boards: no board decides the order of rows alone.

    A board on which the solver does not stand counts with the cap.
    """
    cap = get_protocol(HEADLINE_PROTOCOL).caps[HEADLINE_METRIC]
    figures = [headline(own[board], HEADLINE_METRIC).value if board in own else None for board in boards]
    return float(np.mean(np.log([max(cap if value is None else value, 1e-6) for value in figures])))
