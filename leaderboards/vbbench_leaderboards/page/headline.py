"""The table that the front page leads with: every solver on the boards most like a real camera, and on real footage."""

from collections.abc import Mapping, Sequence

from vbbench_leaderboards.markup import NONE, decimals, padded, percent, text
from vbbench_leaderboards.page.naming import dot, solver_link
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.table import interval
from vbbench_leaderboards.page.words import term_of, tiers
from vbbench_leaderboards.results.boards import HEADLINE_METRIC, HEADLINE_TIER, is_real
from vbbench_leaderboards.results.leading import leading_rows
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import SEEN_MARK, SEEN_WORDS, failure_rate, headline


def headline_table(site: Site) -> str:
    """A row per solver, a column per board; those that see the future stand apart below."""
    boards = site.headlines
    if not boards:
        return f'<p class="note">No board of tier {HEADLINE_TIER} and no footage is here yet.</p>'
    groups = [_group(site, boards, late) for late in (False, True)]
    apart = (
        f'<tbody class="apart"><tr><th colspan="{len(boards) + 1}" scope="rowgroup"><span>These see frames after the '
        "one they answer: ranked among themselves</span></th></tr></tbody>"
    )
    bodies = [f"<tbody>{rows}</tbody>" for rows in groups]
    return (
        '<div class="scroll" tabindex="0" role="region" aria-label="Table of solvers"><table class="headline stacked" '
        f'id="headline"><thead><tr><th scope="col">Solver</th>{"".join(_head(board) for board in boards)}</tr></thead>'
        f"{bodies[0]}{apart + bodies[1] if groups[1] else ''}</table></div>"
        f"{_marks(site, boards)}{_cautions(site, boards)}"
    )


def _head(board: Board) -> str:
    tier = term_of(tiers(), board.tier)
    kind = "real" if is_real(board) else "made"
    return (
        f'<th scope="col" class="num {kind}"><a href="#/{text(board.key)}">{text(board.split)}</a>'
        f'<span class="about">{text("real footage" if is_real(board) else tier.name)}</span></th>'
    )


def _group(site: Site, boards: Sequence[Board], late: bool) -> str:
    """Rows of the solvers that are all causal on these boards, or of the others, the best first."""
    rows = leading_rows(site.results, boards, late=late)
    return "".join(_row(site, solver, own, boards) for solver, own in rows.items())


def _row(site: Site, solver: str, own: Mapping[Board, Result], boards: Sequence[Board]) -> str:
    cells = "".join(_cell(site, board, own.get(board)) for board in boards)
    return f'<tr><th scope="row">{dot(site, solver)}{solver_link(solver)}</th>{cells}</tr>'


def _cell(site: Site, board: Board, result: Result | None) -> str:
    figure = None if result is None else headline(result, HEADLINE_METRIC)
    classes = ["num", *(["real"] if is_real(board) else [])]
    if result is None or figure is None or figure.value is None:
        return f'<td class="{" ".join(classes)}" data-label="{text(board.split)}">{NONE}</td>'
    if site.rankings[board][HEADLINE_METRIC].places[result.solver].rank == 1:
        classes.append("first")
    digits = decimals(value for row in site.results[board] if (value := headline(row, HEADLINE_METRIC).value))
    lost = failure_rate(result)
    failures = "" if lost is None else f'<span class="lost">{percent(lost)} lost</span>'
    mark = f'<sup class="seen" title="{result.seen} on these recordings">{SEEN_MARK}</sup>' if result.seen else ""
    return (
        f'<td class="{" ".join(classes)}" data-label="{text(board.split)}"><b class="figure">'
        f"{padded(figure.value, digits)}</b>{mark}{interval(figure, digits)}{failures}</td>"
    )


def _marks(site: Site, boards: Sequence[Board]) -> str:
    """What the mark of a figure means, where there is one."""
    found = any(result.seen for board in boards for result in site.results[board])
    words = f"{SEEN_MARK} {SEEN_WORDS.capitalize()}, and ranked there apart from solvers that were not."
    return f'<p class="note">{words}</p>' if found else ""


def _cautions(site: Site, boards: Sequence[Board]) -> str:
    found = {board.split: site.caution(board) for board in boards}
    return "".join(
        f'<p class="note"><strong>{text(split)}</strong>: {text(caution)}.</p>'
        for split, caution in found.items()
        if caution
    )
