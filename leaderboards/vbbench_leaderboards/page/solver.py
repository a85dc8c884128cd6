"""A solver's own page: what it is, where it stands on every board, and what its rows said before."""

from collections.abc import Iterator, Mapping
from typing import Any

from vbbench_leaderboards.charts.svg import Series
from vbbench_leaderboards.charts.trend import trend
from vbbench_leaderboards.markup import NONE, decimals, figure, link, padded, percent, text
from vbbench_leaderboards.page.naming import board_address, code_link, dot
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.table import interval
from vbbench_leaderboards.page.words import HEADLINE_METRIC, PROTOCOLS, error_terms, term_of, tiers
from vbbench_leaderboards.results.boards import is_headline
from vbbench_leaderboards.results.history import Past
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import failure_rate, headline

Row = Mapping[Board, Result]


def solver_key(solver: str) -> str:
    """The name of the data of a solver's page."""
    return f"pages/solver/{solver}"


def solver_values(site: Site, solver: str) -> dict[str, Any]:
    """What the scripts need to show the page."""
    return {"name": solver, "html": solver_html(site, solver)}


def solver_html(site: Site, solver: str) -> str:
    """The piece that the page shows for a solver."""
    own = site.solvers[solver]
    return (
        f'<p class="trail"><a href="#/">All solvers</a></p>'
        f'<h2 id="solver-title" tabindex="-1">{dot(site, solver)}{text(solver)}</h2>{_facts(site, own)}'
        f"{_standings(site, own)}{_history(site, own)}"
    )


def _facts(site: Site, own: Row) -> str:
    newest = max(own.values(), key=lambda result: result.about.date)
    source = site.sources.get(newest.solver)
    about = newest.about.reference
    code = code_link(site, newest)
    facts = {
        "Causal or offline": _said(result.about.timing for result in own.values()),
        "By": _said(result.about.authors for result in own.values()),
        "Version": _said(result.version for result in own.values()),
        "Trained on": _said(result.about.trained_on for result in own.values()),
        "Tuned on": _said(result.about.tuned_on for result in own.values()),
        "Code": (code + (f", <code>{text(source.place)}</code>, comes with vbbench" if source else "")) or NONE,
        "Newest result": f"<time>{text(newest.about.date)}</time>",
        "Made again by": _said(result.about.rerun_by or "nobody yet" for result in own.values()),
    }
    rows = "".join(f"<dt>{name}</dt><dd>{value}</dd>" for name, value in facts.items())
    return f'<p class="lead">{link(about, about)}</p><dl class="facts">{rows}</dl>'


def _said(words: Iterator[str]) -> str:
    """What the rows say, each once."""
    return text("; ".join(dict.fromkeys(word for word in words if word))) or NONE


def _standings(site: Site, own: Row) -> str:
    metric = error_terms()[HEADLINE_METRIC]
    groups = (
        ("Where it counts", [board for board in own if is_headline(board)]),
        ("All other boards", [board for board in own if not is_headline(board)]),
    )
    tables = "".join(_table(site, own, name, boards) for name, boards in groups if boards)
    return (
        f'<section aria-labelledby="standings-title"><h3 id="standings-title">Where it stands</h3><p class="lead">'
        f"Ranks by {metric.name} among the solvers that compete; beside each the best and the worst rank that the data "
        f"leave open.</p>{tables}</section>"
    )


def _table(site: Site, own: Row, name: str, boards: list[Board]) -> str:
    term = error_terms()[HEADLINE_METRIC]
    heads = ("Rank", f"{term.name}, {term.unit}", "Lost", "Coverage", "Date")
    digits = decimals(value for board in boards if (value := headline(own[board], HEADLINE_METRIC).value))
    rows = "".join(_row(site, board, own[board], digits) for board in boards)
    head = "".join(f'<th scope="col" class="num">{word}</th>' for word in heads)
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{name}"><table class="plain standings">'
        f'<caption>{name}</caption><thead><tr><th scope="col">Board</th>{head}</tr></thead><tbody>{rows}</tbody>'
        "</table></div>"
    )


def _row(site: Site, board: Board, result: Result, digits: int) -> str:
    found, place = headline(result, HEADLINE_METRIC), site.rankings[board][HEADLINE_METRIC].places[result.solver]
    of = sum(row.about.sees_the_future is result.about.sees_the_future for row in site.results[board])
    open_ranks = "" if place.best == place.worst else f'<span class="ci">{place.best}–{place.worst}</span>'
    lost = failure_rate(result)
    cells = (
        f'<b>{place.rank}</b><span class="of"> of {of}</span>{open_ranks}',
        NONE if found.value is None else f"{padded(found.value, digits)}{interval(found, digits)}",
        NONE if lost is None else percent(lost),
        percent(result.score["coverage"]),
        f"<time>{text(result.about.date)}</time>",
    )
    shown = "".join(f'<td class="num">{cell}</td>' for cell in cells)
    return f"<tr>{_board_cell(board)}{shown}</tr>"


def _board_cell(board: Board) -> str:
    protocol, tier = term_of(PROTOCOLS, board.protocol), term_of(tiers(), board.tier)
    words = f'<span class="which">{text(protocol.name)}, {text(tier.name)}</span>'
    return f'<th scope="row"><a href="{text(board_address(board))}">{text(board.split)}</a> {words}</th>'


def _history(site: Site, own: Row) -> str:
    told = {board: result for board, result in own.items() if result.history}
    if not told:
        words = "Nothing yet: no figure of this solver has taken the place of another."
        return f'<section aria-labelledby="history-title"><h3 id="history-title">History</h3><p>{words}</p></section>'
    counting = {board: result for board, result in told.items() if is_headline(board)} or told
    rest = {board: result for board, result in told.items() if board not in counting}
    name = error_terms()[HEADLINE_METRIC].name
    folded = (
        f'<details id="older"><summary>{len(rest)} more boards</summary>{_past_table(site, rest, "rest")}</details>'
        if rest
        else ""
    )
    return (
        '<section aria-labelledby="history-title"><h3 id="history-title">History</h3><p class="lead">Capped mean '
        f"{name} of each result that stood on the board, the newest last. Where the data were made anew, or the "
        "protocol changed, the task was another: only a change well beyond the intervals says something of the "
        f"solver.</p>{_past_table(site, counting, 'counting')}{folded}</section>"
    )


def _past_table(site: Site, told: Row, name: str) -> str:
    rows = "".join(_past_row(site, n, board, result, name) for n, (board, result) in enumerate(told.items()))
    heads = '<th scope="col">Board</th><th scope="col">Course</th><th scope="col">Results, the newest last</th>'
    return (
        '<div class="scroll" tabindex="0" role="region" aria-label="Table of earlier results">'
        f'<table class="plain past"><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _past_row(site: Site, n: int, board: Board, result: Result, name: str) -> str:
    course = (*result.history, result.present)
    known = [past.capped[HEADLINE_METRIC] for past in course if HEADLINE_METRIC in past.capped]
    points = [(value, low, high) for value, low, high in known if value is not None]
    most = decimals(value for value, _, _ in points)
    says = ", ".join(figure(value, most) for value, _, _ in points)
    series = Series(solver=result.solver, colour=site.colours[result.solver])
    drawn = trend(f"trend-{name}-{n}", series, says, points) if points else NONE
    entries = "".join(_entry(past, course[k - 1] if k else None, most) for k, past in enumerate(course))
    return f'<tr>{_board_cell(board)}<td>{drawn}</td><td><ol class="entries">{entries}</ol></td></tr>'


def _entry(past: Past, before: Past | None, most: int) -> str:
    value, low, high = past.capped.get(HEADLINE_METRIC, (None, None, None))
    between = "" if low is None or high is None else f' <span class="ends">{low:.{most}f}–{high:.{most}f}</span>'
    changed = [
        *(["other data"] if before and before.dataset != past.dataset else []),
        *([past.protocol] if before and before.protocol != past.protocol else []),
    ]
    note = f' <span class="ends">({", ".join(map(text, changed))})</span>' if changed else ""
    shown = NONE if value is None else f"<b>{figure(value, most)}</b>{between}"
    return f"<li>{text(past.version) or 'no version'}, <time>{text(past.date)}</time>: {shown}{note}</li>"
