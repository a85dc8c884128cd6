"""The table of the front page: what the leaderboard leads with, from the committed results."""

from html import escape
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive

from vbbench_leaderboards.results.boards import HEADLINE_METRIC, SPLITS, is_headline, is_real
from vbbench_leaderboards.results.folder import Boards, read_results
from vbbench_leaderboards.results.ranking import headline, leading_rows
from vbbench_leaderboards.results.result import Board

RESULTS = Path(__file__).parents[2] / "leaderboards" / "results"


class Headline(Directive):
    """``{headline}``: a row per solver and a column per board, each a link to the board."""

    def run(self) -> list[nodes.Node]:
        """One table, as HTML."""
        self.state.document.settings.env.note_dependency(str(RESULTS))
        return [nodes.raw("", headline_table(), format="html")]


def headline_table() -> str:
    """Capped mean of Δx; the best of those that know no future bold, and those that do apart."""
    results = read_results(RESULTS)
    boards = [board for split in SPLITS for board in results if board.split == split and is_headline(board)]
    heads = "".join(f'<th scope="col">{_link(board)}</th>' for board in boards)
    groups = [_rows(late, {board: results[board] for board in boards}) for late in (False, True)]
    bodies = "".join(f"<tbody>{rows}</tbody>" for rows in groups if rows)
    return (
        '<div class="pst-scrollable-table-container headline" tabindex="0" role="region" aria-label="Leaderboard">'
        f'<table class="table"><thead><tr><th scope="col">Solver</th>{heads}</tr></thead>{bodies}</table></div>'
    )


def _link(board: Board) -> str:
    kind = "real footage" if is_real(board) else "made"
    return f'<a href="leaderboard/index.html#/{escape(board.key)}">{escape(board.split)}</a><small>{kind}</small>'


def _rows(late: bool, results: Boards) -> str:
    """Rows of the solvers that see the future, or of the others, in the order of the leaderboard."""
    rows = leading_rows(results, list(results), late=late)
    figures = {
        solver: {board: headline(one, HEADLINE_METRIC).value for board, one in own.items()}
        for solver, own in rows.items()
    }
    known = {board: [own[board] for own in figures.values() if own.get(board) is not None] for board in results}
    note = " <small>sees the future</small>" if late else ""
    return "".join(
        f'<tr><th scope="row"><code>{escape(solver)}</code>{note}</th>'
        f"{''.join(_cell(own.get(board), min(known[board], default=None)) for board in results)}</tr>"
        for solver, own in figures.items()
    )


def _cell(value: float | None, best: float | None) -> str:
    if value is None:
        return "<td>–</td>"
    return f"<td><strong>{value:.2f}</strong></td>" if value == best else f"<td>{value:.2f}</td>"


def setup(app: Any) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("headline", Headline)
    return {"parallel_read_safe": True}
