"""Scores as columns: of tables for people, with the best marked, and of tables for programs, with every digit.

A score here is what a result of the leaderboard holds, `vbbench.scoring.scorecard.Score.values`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from vbbench.protocol import Protocol
from vbbench.scoring.metrics import METRICS, section
from vbbench.table import best, decimals

Values = Mapping[str, Any]

NONE = "–"
_SUMMARIES = ("median", "mean", "p95", "std", "frame_mean", "failure_rate")

SHOWN_HEAD = (*(metric.label for metric in section("metrics").values()), "failed", "coverage", "µs/frame")
"""Heads of the columns for people."""

VALUES_HEAD = (
    *("sequences", "coverage", "seconds_per_frame"),
    *(f"{name}{part}" for name in METRICS for part in ("", "_low", "_high", *(f"_{one}" for one in _SUMMARIES))),
)
"""Names of the columns for programs: a metric's capped mean goes by the metric's name."""


def shown_cells(scores: Sequence[Values], groups: Sequence[object] = ()) -> list[list[str]]:
    """Cells [score][column] of `SHOWN_HEAD`: capped means with their intervals; each group's best in bold."""
    columns = [_errors([score["metrics"][name] for score in scores], groups) for name in section("metrics")]
    failed = [score["metrics"]["dx"]["failure_rate"] for score in scores]
    columns.append(best([NONE if rate is None else f"{rate:.1%}" for rate in failed], failed, groups))
    columns.append([f"{score['coverage']:.2%}".replace("100.00%", "100%") for score in scores])
    seconds = [score["seconds_per_frame"] for score in scores]
    columns.append([NONE if one is None else f"{1e6 * one:.0f}" for one in seconds])
    return [list(row) for row in zip(*columns, strict=True)]


def value_cells(score: Values) -> list[object]:
    """Cells of `VALUES_HEAD`: numbers in the unit of the metric, ``None`` where there is none."""
    cells: list[object] = [score["sequences"], score["coverage"], score["seconds_per_frame"]]
    for name, metric in METRICS.items():
        figures = score[metric.section][name]
        cells += [figures["capped"], *figures["capped_ci95"], *(figures[one] for one in _SUMMARIES)]
    return cells


def ranking_fact(protocol: Protocol) -> str:
    """What the columns for people hold."""
    cap, turn, lost = protocol.caps["dx"], protocol.caps["dr"], protocol.failures["dx"]
    return (
        f"Capped means, by which boards rank: over sequences, of min(error, {cap:g} m or {turn:g} rad), with 95 % "
        f"intervals. Failed: sequences with a mean Δx above {lost:g} m. The best of a column is marked; 'vbbench "
        "compare' tells whether a difference is settled."
    )


def _errors(figures: Sequence[Values], groups: Sequence[object]) -> list[str]:
    """A metric's column."""
    values = [one["capped"] for one in figures]
    digits = decimals([value for value in values if value is not None])
    return best([_with_interval(one, digits) for one in figures], values, groups)


def _with_interval(figures: Values, digits: int) -> str:
    low, high = figures["capped_ci95"]
    if figures["capped"] is None:
        return NONE
    value = f"{figures['capped']:.{digits}f}"
    return value if low is None else f"{value} ({low:.{digits}f}–{high:.{digits}f})"
