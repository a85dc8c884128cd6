"""The table of a board: causal solvers, those that see the future, and the paper's rows below."""

import json
from collections.abc import Iterator

from vbbench.paper import Quoted, the_paper
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.markup import NONE, decimals, link, percent, text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import COLUMNS, SUMMARIES, drift_terms, error_terms
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import failure_rate, headline, summary

_MORE = "more"
"""Class of the columns that are shown on request only."""

QUOTED_PROTOCOL = "one-step"
"""The protocol that the paper's figures agree with; its text says ``sequential`` (docs/reproduce.md)."""


def board_table(site: Site, board: Board) -> str:
    """The table with its scrolling frame: causal solvers, then those that see the future, then the paper's rows."""
    rows = sorted(site.results[board], key=lambda result: (_ranking_figure(result, "dx"), result.solver))
    digits = {name: decimals([_ranking_figure(result, name) for result in rows]) for name in METRICS}
    causal = "".join(_row(site, board, result, digits) for result in rows if not result.about.sees_the_future)
    late = "".join(_row(site, board, result, digits) for result in rows if result.about.sees_the_future)
    name = f"{board.split}, {board.protocol}, {board.tier}"
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="Table of results">'
        f'<table class="board" id="board-table" data-board="{text(board.key)}">'
        f'<caption class="unseen">Results on {text(name)}. Column heads sort.</caption>'
        f'<thead><tr>{"".join(_heads())}</tr></thead><tbody class="rows" id="board-rows">{causal}</tbody>'
        f"{_apart(late)}{_quoted_rows(board)}</table></div>"
    )


def _apart(rows: str) -> str:
    if not rows:
        return ""
    words = "These see frames after the one they answer: ranked among themselves"
    head = (
        f'<tbody class="apart"><tr><th colspan="{_columns()}" scope="rowgroup"><span>{words}</span></th></tr></tbody>'
    )
    return f'{head}<tbody class="rows" id="late-rows">{rows}</tbody>'


def _heads() -> Iterator[str]:
    yield _head("rank", COLUMNS["rank"].name, definition="rank")
    yield _head("solver", "Solver", kind="name")
    for metric, term in error_terms().items():
        yield _head(metric, term.name, term.unit, definition=metric)
        for key, how in SUMMARIES.items():
            name = f"{term.name} {how.name}"
            yield _head(f"{metric}_{key}", name, term.unit, definition=key, kind=f"num {_MORE}")
    for drift, term in drift_terms().items():
        yield _head(drift, term.name, term.unit, definition=drift, kind=f"num {_MORE}")
    for column in ("failures", "coverage", "time"):
        yield _head(column, COLUMNS[column].name, COLUMNS[column].unit, definition=column)
    yield _head("version", "Version", kind=_MORE)
    yield _head("hardware", "Hardware", kind=_MORE)


def _columns() -> int:
    return sum(1 for _ in _heads())


def _head(column: str, name: str, unit: str = "", *, definition: str = "", kind: str = "num") -> str:
    tip = f' data-def="def-{definition}" aria-describedby="def-{definition}"' if definition else ""
    shown = f' <span class="unit">{text(unit)}</span>' if unit else ""
    return (
        f'<th scope="col" class="{kind}" data-column="{column}">'
        f'<button type="button" data-sort="{column}"{tip}>{text(name)}{shown}</button></th>'
    )


def _row(site: Site, board: Board, result: Result, digits: dict[str, int]) -> str:
    score, places, seconds = result.score, site.rankings[board], result.score["seconds_per_frame"]
    own = {metric: places[metric].places[result.solver] for metric in METRICS}
    ranks = {metric: [place.rank, place.best, place.worst] for metric, place in own.items()}
    every = text(json.dumps(ranks, separators=(",", ":")))
    cells = [
        f'<td class="num rank" data-ranks="{every}">{_rank(*ranks["dx"])}</td>',
        _solver(site, result),
        *(cell for metric in error_terms() for cell in _metric_cells(result, metric, digits[metric])),
        *(_cell(drift, headline(result, drift).value, digits[drift], kind=_MORE) for drift in drift_terms()),
        _share("failures", failure_rate(result)),
        _share("coverage", score["coverage"], low=score["coverage"] < 1),
        _cell("time", None if seconds is None else 1e6 * seconds, 0),
        f'<td class="{_MORE}">{text(result.version) or NONE}</td>',
        f'<td class="{_MORE} hardware">{text(result.hardware) or NONE}</td>',
    ]
    about = result.about
    said = [about.timing, about.reference, about.authors, about.trained_on, about.tuned_on]
    words = " ".join([result.solver, result.version, *said, result.hardware]).lower()
    return f'<tr data-solver="{text(result.solver)}" data-words="{text(words)}">{"".join(cells)}</tr>'


def _rank(rank: int, best: int, worst: int) -> str:
    return f"{rank}" if worst == best else f'{rank}<span class="ci">{best}–{worst}</span>'


def _solver(site: Site, result: Result) -> str:
    name = f'<span class="dot c{site.colours[result.solver]}"></span>{link(result.about.code, result.solver)}'
    words = f'<span class="about">{text(result.about.timing)}</span>'
    return f'<th scope="row" class="name" data-value="{text(result.solver)}">{name}{words}</th>'


def _metric_cells(result: Result, metric: str, digits: int) -> Iterator[str]:
    figure, others = headline(result, metric), summary(result, metric)
    between = "" if figure.low is None else f'<span class="ci">{figure.low:.{digits}f}–{figure.high:.{digits}f}</span>'
    yield _cell(metric, figure.value, digits, after=between)
    for name in SUMMARIES:
        yield _cell(f"{metric}_{name}", others[name], digits, kind=_MORE)


def _cell(column: str, value: float | None, digits: int, *, kind: str = "", after: str = "") -> str:
    """A number, with its exact value for sorting; a dash where there is none."""
    classes = f"num {kind}".strip()
    if value is None:
        return f'<td class="{classes}" data-column="{column}" data-value="">{NONE}</td>'
    return f'<td class="{classes}" data-column="{column}" data-value="{value:.9g}">{value:,.{digits}f}{after}</td>'


def _share(column: str, share: float | None, *, low: bool = False) -> str:
    if share is None:
        return _cell(column, None, 0)
    classes = "num low" if low else "num"
    return f'<td class="{classes}" data-column="{column}" data-value="{share:.9g}">{percent(share)}</td>'


def _ranking_figure(result: Result, metric: str) -> float:
    found = headline(result, metric).value
    return float("inf") if found is None else found


def _quoted_rows(board: Board) -> str:
    """The paper's rows: quoted beside the board, unranked, and never part of its statistics."""
    rows = the_paper().select(board.split, board.tier) if board.protocol == QUOTED_PROTOCOL else ()
    if not rows:
        return ""
    title = link(the_paper().link, f"the paper, Table {rows[0].table}")
    words = f"Quoted from {title}: plain means, not measured here, not ranked"
    head = f'<tr><th colspan="{_columns()}" scope="rowgroup"><span>{words}</span></th></tr>'
    return f'<tbody class="quoted">{head}{"".join(map(_quoted_row, rows))}</tbody>'


def _quoted_row(row: Quoted) -> str:
    more = f'<td class="{_MORE}"></td>'
    figures = [row.figures.get(metric) for metric in error_terms()]
    means = [f'<td class="num">{NONE if value is None else f"{value:.3f}"}</td>' for value in figures]
    cells = "".join(mean + more * len(SUMMARIES) for mean in means)
    rest = f"{more * len(drift_terms())}<td></td><td></td><td></td>{more}{more}"
    return f'<tr><td></td><th scope="row" class="name">{text(row.solver)}</th>{cells}{rest}</tr>'
