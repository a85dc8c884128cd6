"""The figures that rank a board's solvers, and their places: causal solvers among themselves, the others apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.results.ranking import Ranking, rank
from vbbench_leaderboards.results.result import Result


@dataclass(frozen=True, kw_only=True)
class Headline:
    """A result's figure by which a metric ranks: the capped mean, with its 95 % interval; ``None`` = there is none."""

    value: float | None
    low: float | None
    high: float | None


def headline(result: Result, metric: str) -> Headline:
    """The ranking figure of a metric."""
    figures = summary(result, metric)
    low, high = figures["capped_ci95"]
    return Headline(value=figures["capped"], low=low, high=high)


def failure_rate(result: Result) -> float | None:
    """The share of sequences in which people are lost: a mean Δx beyond the protocol's threshold."""
    rate: float | None = summary(result, "dx")["failure_rate"]
    return rate


def summary(result: Result, metric: str) -> dict[str, Any]:
    """All figures of a metric over the board."""
    found: dict[str, Any] = result.score[METRICS[metric].section][metric]
    return found


def rank_apart(results: Sequence[Result]) -> dict[str, Ranking]:
    """Rankings by metric of a board's results: those that see the future compete with one another alone."""
    groups = [[one for one in results if one.about.sees_the_future is late] for late in (False, True)]
    ranked = [rank(group) for group in groups if group]
    return {
        metric: Ranking(
            places={name: place for one in ranked for name, place in one[metric].places.items()},
            pairs=tuple(pair for one in ranked for pair in one[metric].pairs),
        )
        for metric in METRICS
    }
