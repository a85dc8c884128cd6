"""A solver's own page: what it is, where it stands on every board, and what its rows said before."""

from collections.abc import Iterator, Mapping
from typing import Any

from vbbench_leaderboards.charts.svg import Series
from vbbench_leaderboards.charts.trend import trend
from vbbench_leaderboards.markup import NONE, decimals, figure, link, padded, percent, text
from vbbench_leaderboards.page.naming import board_address, code_link, dot
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.table import interval
from vbbench_leaderboards.page.words import PROTOCOLS, error_terms, term_of, tiers
from vbbench_leaderboards.results.boards import HEADLINE_METRIC, is_headline
from vbbench_leaderboards.results.history import Past
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import SEEN_MARK, SEEN_WORDS, failure_rate, headline

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
        f'<h1 id="solver-title" tabindex="-1">{dot(site, solver)}{text(solver)}</h1>{_facts(site, own)}'
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
    leading = [board for board in own if is_headline(board)]
    tables = (_leading_table(site, own, leading) if leading else "") + _every_table(site, own)
    return (
        f'<section aria-labelledby="standings-title"><h2 id="standings-title">Where it stands</h2><p class="lead">'
        f"Capped mean {metric.name} in {metric.unit} with its 95 % interval, and the rank among the solvers that "
        f"compete; beside it the best and the worst rank that the data leave open.{_seen(own)}</p>{tables}</section>"
    )


def _seen(own: Row) -> str:
    """What the mark means, where a row has one."""
    return f" {SEEN_MARK}: {SEEN_WORDS}." if any(result.seen for result in own.values()) else ""


def _leading_table(site: Site, own: Row, boards: list[Board]) -> str:
    """The boards that lead the front page, a row each."""
    term = error_terms()[HEADLINE_METRIC]
    heads = ("Rank", f"{term.name}, {term.unit}", "Lost", "Coverage", "Date")
    digits = _digits(own, boards)
    rows = "".join(_leading_row(site, board, own[board], digits) for board in boards)
    head = "".join(f'<th scope="col" class="num">{word}</th>' for word in heads)
    return (
        '<div class="scroll" tabindex="0" role="region" aria-label="Boards like a real camera, and real ones">'
        f'<table class="plain standings stacked"><thead><tr><th scope="col">Board</th>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _leading_row(site: Site, board: Board, result: Result, digits: int) -> str:
    lost = failure_rate(result)
    cells = {
        "Rank": _rank(site, board, result),
        "Error": _error(result, digits),
        "Lost": NONE if lost is None else percent(lost),
        "Coverage": percent(result.score["coverage"]),
        "Date": f"<time>{text(result.about.date)}</time>",
    }
    shown = "".join(f'<td class="num" data-label="{name}">{cell}</td>' for name, cell in cells.items())
    return f"<tr>{_board_cell(board)}{shown}</tr>"


def _every_table(site: Site, own: Row) -> str:
    """Every board: a row for each split and tier, a column for each protocol."""
    datasets = list(dict.fromkeys((board.split, board.tier) for board in own))
    columns = [name for name in PROTOCOLS if any(board.protocol == name for board in own)]
    heads = "".join(f'<th scope="col" class="num">{text(term_of(PROTOCOLS, name).full)}</th>' for name in columns)
    digits = _digits(own, list(own))
    rows = "".join(_dataset_row(site, own, split, tier, columns, digits) for split, tier in datasets)
    return (
        '<h3 id="every-title">All boards</h3><div class="scroll" tabindex="0" role="region" '
        f'aria-labelledby="every-title"><table class="plain standings stacked four" id="every"><thead><tr>'
        f'<th scope="col">Data</th>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _dataset_row(site: Site, own: Row, split: str, tier: str, columns: list[str], digits: int) -> str:
    cells = []
    for name in columns:
        board = Board(split=split, tier=tier, protocol=name)
        shown = NONE
        if board in own:
            link_to = f'<a href="{text(board_address(board))}">{_error(own[board], digits, between=False)}</a>'
            shown = f'{link_to}<span class="ci">rank {_rank(site, board, own[board], among=False)}</span>'
        cells.append(f'<td class="num" data-label="{text(term_of(PROTOCOLS, name).full)}">{shown}</td>')
    words = f'{text(split)} <span class="which">{text(term_of(tiers(), tier).name)}</span>'
    return f'<tr><th scope="row">{words}</th>{"".join(cells)}</tr>'


def _rank(site: Site, board: Board, result: Result, *, among: bool = True) -> str:
    place = site.rankings[board][HEADLINE_METRIC].places[result.solver]
    of, mark = sum(row.group == result.group for row in site.results[board]), SEEN_MARK if result.seen else ""
    if not among:
        return f"{place.rank} of {of}{mark}"
    open_ranks = "" if place.best == place.worst else f'<span class="ci">{place.best}–{place.worst}</span>'
    return f'<b>{place.rank}</b><span class="of"> of {of}{mark}</span>{open_ranks}'


def _error(result: Result, digits: int, *, between: bool = True) -> str:
    found = headline(result, HEADLINE_METRIC)
    if found.value is None:
        return NONE
    return padded(found.value, digits) + (interval(found, digits) if between else "")


def _digits(own: Row, boards: list[Board]) -> int:
    return decimals(value for board in boards if (value := headline(own[board], HEADLINE_METRIC).value))


def _board_cell(board: Board) -> str:
    protocol, tier = term_of(PROTOCOLS, board.protocol), term_of(tiers(), board.tier)
    words = f'<span class="which">{text(protocol.name)}, {text(tier.name)}</span>'
    return f'<th scope="row"><a href="{text(board_address(board))}">{text(board.split)}</a> {words}</th>'


def _history(site: Site, own: Row) -> str:
    told = {board: result for board, result in own.items() if result.history}
    if not told:
        words = "Nothing yet: no figure of this solver has taken the place of another."
        return f'<section aria-labelledby="history-title"><h2 id="history-title">History</h2><p>{words}</p></section>'
    counting = {board: result for board, result in told.items() if is_headline(board)} or told
    rest = {board: result for board, result in told.items() if board not in counting}
    name = error_terms()[HEADLINE_METRIC].name
    folded = (
        f'<details id="older"><summary>{len(rest)} more boards</summary>{_past_table(site, rest, "rest")}</details>'
        if rest
        else ""
    )
    return (
        '<section aria-labelledby="history-title"><h2 id="history-title">History</h2><p class="lead">Capped mean '
        f"{name} of each result that stood on the board, the newest last. Where the data were made anew, or the "
        "protocol changed, the task was another: only a change well beyond the intervals says something of the "
        f"solver.</p>{_past_table(site, counting, 'counting')}{folded}</section>"
    )


def _past_table(site: Site, told: Row, name: str) -> str:
    rows = "".join(_past_row(site, n, board, result, name) for n, (board, result) in enumerate(told.items()))
    heads = '<th scope="col">Board</th><th scope="col">Course</th><th scope="col">Results, the newest last</th>'
    return (
        '<div class="scroll" tabindex="0" role="region" aria-label="Table of earlier results">'
        f'<table class="plain past stacked"><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
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
    told = f'<td class="wide-cell">{drawn}</td><td class="wide-cell"><ol class="entries">{entries}</ol></td>'
    return f"<tr>{_board_cell(board)}{told}</tr>"


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
