"""Writes README's leaderboard from the committed results: ``python docs/write_board.py``."""

import re
from collections.abc import Sequence
from pathlib import Path

from vbbench_leaderboards.results.boards import (
    HEADLINE_METRIC,
    HEADLINE_PROTOCOL,
    HEADLINE_TIER,
    LEADING_SPLITS,
    REAL_SPLITS,
)
from vbbench_leaderboards.results.folder import Boards, published_results, read_results
from vbbench_leaderboards.results.result import Board, Result

README = Path(__file__).parents[1] / "README.md"
CAUSAL = ("cv", "vb-sf", "vb-former", "map-causal")
SOLVERS = (*CAUSAL, "map-batch")
FOOTAGE = "footage"


def table(results: Boards) -> str:
    """Markdown: a row a split, a column a solver; the smallest value of the causal solvers is bold.

    Returns
    -------
    The rows, each with its line end; values are capped means of Δx in m.
    """
    boards = [
        *(Board(split=split, tier=HEADLINE_TIER, protocol=HEADLINE_PROTOCOL) for split in LEADING_SPLITS),
        *(Board(split=split, tier=FOOTAGE, protocol=HEADLINE_PROTOCOL) for split in REAL_SPLITS),
    ]
    head = f"| | {' | '.join(f'`{solver}`' for solver in SOLVERS)} |\n|---|{'---:|' * len(SOLVERS)}\n"
    return head + "".join(f"| {board.split} | {' | '.join(_cells(results[board]))} |\n" for board in boards)


def _cells(board: Sequence[Result]) -> list[str]:
    """A board's values in the order of `SOLVERS`."""
    rows = {result.solver: result for result in board}
    values = {solver: rows[solver].score["metrics"][HEADLINE_METRIC]["capped"] for solver in SOLVERS}
    best = min(CAUSAL, key=values.__getitem__)
    cells = []
    for solver, value in values.items():
        bold = "**" if solver == best else ""
        cells.append(f"{bold}{value:.2f}{bold}{'†' if rows[solver].seen else ''}")
    return cells


def written(page: str, rows: str) -> str:
    """The page with these rows in place of its leaderboard."""
    return re.sub(r"(?m)^\| \| `cv` .*\n(?:\|.*\n)+", rows, page)


if __name__ == "__main__":
    README.write_text(written(README.read_text("utf-8"), table(read_results(published_results()))), encoding="utf-8")
