"""Who stands on a board: what every row must say of its solver beside the figures."""

from collections.abc import Iterator

from vbbench_leaderboards.markup import NONE, link, text
from vbbench_leaderboards.page.naming import code_link, dot, solver_link
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import SEEN_MARK

_HEADS = (
    "Solver",
    "Causal or offline",
    "Trained on",
    "Tuned on",
    "By",
    "Date",
    "Code",
    "Made again by",
)


def people_table(site: Site, board: Board) -> str:
    """The table of a board's solvers: who made them, what they have seen, and who made their figures again."""
    heads = "".join(f'<th scope="col">{name}</th>' for name in _HEADS)
    rows = "".join(_row(site, result) for result in site.results[board])
    return (
        '<section class="who" aria-labelledby="who-title"><h4 id="who-title">The solvers</h4>'
        '<div class="scroll" tabindex="0" role="region" aria-label="Table of the solvers">'
        f'<table class="plain stacked" id="who"><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody>'
        f"</table></div>{_SEEN if any(result.seen for result in site.results[board]) else ''}</section>"
    )


_SEEN = f'<p class="note">{SEEN_MARK} Names recordings of this board: the row is ranked apart.</p>'


def _row(site: Site, result: Result) -> str:
    about = result.about.reference
    words = f'<span class="about">{link(about, about)}</span>' if about else ""
    pairs = zip(_HEADS[1:], _cells(site, result), strict=True)
    cells = "".join(f'<td data-label="{name}">{cell}</td>' for name, cell in pairs)
    return f'<tr><th scope="row">{dot(site, result.solver)}{solver_link(result.solver)}{words}</th>{cells}</tr>'


def _cells(site: Site, result: Result) -> Iterator[str]:
    about = result.about
    yield text(about.timing)
    yield text(about.trained_on) + (f" {SEEN_MARK}" if "trained" in result.seen else "")
    yield text(about.tuned_on) + (f" {SEEN_MARK}" if "tuned" in result.seen else "")
    yield text(about.authors)
    yield f"<time>{text(about.date)}</time>"
    yield code_link(site, result) or NONE
    yield text(about.rerun_by) or "nobody yet"
