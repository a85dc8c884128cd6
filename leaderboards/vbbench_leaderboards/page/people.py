"""Who stands on a board: what every row must say of its solver beside the figures."""

from collections.abc import Iterator

from vbbench_leaderboards.markup import NONE, link, text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.results.result import Board, Result

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
        f'<table class="plain" id="who"><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div></section>'
    )


def _row(site: Site, result: Result) -> str:
    dot = f'<span class="dot c{site.colours[result.solver]}"></span>'
    about = result.about.reference
    words = f'<span class="about">{link(about, about)}</span>' if about else ""
    cells = "".join(f"<td>{cell}</td>" for cell in _cells(result))
    return f'<tr><th scope="row">{dot}{text(result.solver)}{words}</th>{cells}</tr>'


def _cells(result: Result) -> Iterator[str]:
    about = result.about
    yield text(about.timing)
    yield text(about.trained_on)
    yield text(about.tuned_on)
    yield text(about.authors)
    yield f"<time>{text(about.date)}</time>"
    yield link(about.code, "code") if about.code else NONE
    yield text(about.rerun_by) or "nobody yet"
