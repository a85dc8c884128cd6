"""The view that compares two solvers of a board: every sequence's errors, and every two solvers' differences."""

from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.parsing.json_text import finite_or_none
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import error_terms
from vbbench_leaderboards.results.comparing import Contrast, contrasts
from vbbench_leaderboards.results.result import Board

_DIGITS = 6
"""Significant digits of the figures: what result files are exact to."""


def comparison_key(board: Board) -> str:
    """The name of a board's data for this view."""
    return f"pages/pairs/{board.key}"


def comparison_values(site: Site, board: Board) -> dict[str, Any]:
    """The data: ``pairs`` are [number of A, number of B, metric → [A − B, low, high, p, sequences, won by A]]."""
    results = site.results[board]
    found, caps = contrasts(results), get_protocol(board.protocol).caps
    place = {metric: number for number, metric in enumerate(METRICS)}
    return {
        "solvers": list(found.solvers),
        "sequences": found.sequences.tolist(),
        "metrics": {
            metric: {
                "name": term.name,
                "unit": term.unit,
                "cap": caps.get(metric),
                "capped": [_short(result.score["metrics"][metric]["capped"]) for result in results],
                "errors": [_column(own[:, place[metric]]) for own in found.figures],
            }
            for metric, term in error_terms().items()
        },
        "pairs": [
            [a, b, {metric: _contrast(own[metric]) for metric in error_terms()}] for (a, b), own in found.pairs.items()
        ],
    }


def _contrast(found: Contrast) -> list[float | None]:
    figures = (found.difference, found.low, found.high, found.p)
    return [*(_short(finite_or_none(value)) for value in figures), found.sequences, found.won]


def _column(values: FloatArray) -> list[float | None]:
    return [_short(float(value)) if np.isfinite(value) else None for value in values]


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.{_DIGITS}g}")
