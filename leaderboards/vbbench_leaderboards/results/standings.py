"""The figures that rank a board's solvers, and their places, each group of solvers among themselves."""

from collections.abc import Iterable, Sequence
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
