"""The table of a board: every solver with its figures, and the paper's rows below."""

import json
from collections.abc import Iterator
from typing import Any
from vbbench.reproduction.paper import Quoted, the_paper
from vbbench_leaderboards.markup import NONE, decimals, link, text
from vbbench_leaderboards.page.site import Site, key
from vbbench_leaderboards.page.words import COLUMNS, DRIFTS, METRICS, SUMMARIES, Term
from vbbench_leaderboards.results.ranking import RANKED
from vbbench_leaderboards.results.result import Board, Result
from vbbench.reproduction.paper import Quoted, the_paper
from vbbench_leaderboards.results.result import Board

# DOC """The paper's rows at a board: quoted beside it, unranked, and never part of its statistics."""
_MORE = "more"
"""Class of the columns that are shown on request only."""

_MICROS = 1e6


def board_table(site: Site, board: Board) -> str:
    """The table with its scrolling frame."""
    rows = sorted(site.results[board], key=lambda result: (_mean(result, "dx"), result.solver))
    digits = {name: decimals([_mean(result, name) for result in rows]) for name in RANKED}
    body = "".join(_row(site, board, result, digits) for result in rows)
    name = f"{board.split}, {board.protocol}, {board.tier}"
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="Table of results">'
        f'<table class="board" id="board-table" data-board="{text(key(board))}">'
        f'<caption class="unseen">Results on {text(name)}. Column heads sort.</caption>'
        f'<thead><tr>{"".join(_heads())}</tr></thead><tbody id="board-rows">{body}</tbody>'
        f"{_quoted_rows(quoted(board))}</table></div>"
    )


def _heads() -> Iterator[str]:
    yield _head("rank", COLUMNS["rank"], "rank", kind="num")
    yield _head("solver", Term(name="Solver", full="solver", meaning=""), "", kind="name")
    for metric, term in METRICS.items():
        yield _head(metric, term, metric, kind="num")
        for summary, how in SUMMARIES.items():
            own = Term(name=f"{term.name} {how.name}", full=how.full, unit=term.unit, meaning="")
            yield _head(f"{metric}_{summary}", own, summary, kind=f"num {_MORE}")
    for drift, term in DRIFTS.items():
        yield _head(drift, term, drift, kind=f"num {_MORE}")
    yield _head("coverage", COLUMNS["coverage"], "coverage", kind="num")
    yield _head("time", COLUMNS["time"], "time", kind="num")
    yield _head("version", Term(name="Version", full="version", meaning=""), "", kind=_MORE)
    yield _head("hardware", Term(name="Hardware", full="hardware", meaning=""), "", kind=_MORE)


def _head(column: str, term: Term, definition: str, kind: str) -> str:
    tip = f' data-def="def-{definition}" aria-describedby="def-{definition}"' if definition else ""
    unit = f' <span class="unit">{text(term.unit)}</span>' if term.unit else ""
    return (
        f'<th scope="col" class="{kind}" data-column="{column}">'
        f'<button type="button" data-sort="{column}"{tip}>{text(term.name)}{unit}</button></th>'
    )


def _row(site: Site, board: Board, result: Result, digits: dict[str, int]) -> str:
    score, places, seconds = result.score, site.rankings[board], result.score["seconds_per_frame"]
    ranks = {metric: [getattr(places[metric].places[result.solver], end) for end in _ENDS] for metric in RANKED}
    every = text(json.dumps(ranks, separators=(",", ":")))
    cells = [
        f'<td class="num rank" data-ranks="{every}">{_rank(*ranks["dx"])}</td>',
        _solver(site, result),
        *(cell for metric in METRICS for cell in _metric_cells(metric, score["metrics"][metric], digits[metric])),
        *(_cell(drift, score["drift"][drift]["mean"], digits[drift], kind=_MORE) for drift in DRIFTS),
        _coverage(score["coverage"]),
        _cell("time", None if seconds is None else _MICROS * seconds, 0),
        f'<td class="{_MORE}">{text(result.version) or NONE}</td>',
        f'<td class="{_MORE} hardware">{text(result.hardware) or NONE}</td>',
    ]
    words = " ".join([result.solver, result.version, result.reference, result.hardware]).lower()
    return f'<tr data-solver="{text(result.solver)}" data-words="{text(words)}">{"".join(cells)}</tr>'


_ENDS = ("rank", "best", "worst")


def _rank(rank: int, best: int, worst: int) -> str:
    return f"{rank}" if worst == best else f'{rank}<span class="ci">{best}–{worst}</span>'


def _solver(site: Site, result: Result) -> str:
    name = f'<span class="dot c{site.colours[result.solver]}"></span>{link(result.link, result.solver)}'
    reference = result.reference
    about = f'<span class="about">{link(reference, reference)}</span>' if reference else ""
    return f'<th scope="row" class="name" data-value="{text(result.solver)}">{name}{about}</th>'


def _metric_cells(metric: str, figures: dict[str, Any], digits: int) -> Iterator[str]:
    low, high = figures["ci95"]
    between = "" if low is None else f'<span class="ci">{low:.{digits}f}–{high:.{digits}f}</span>'
    yield _cell(metric, figures["mean"], digits, after=between)
    for summary in SUMMARIES:
        yield _cell(f"{metric}_{summary}", figures[summary], digits, kind=_MORE)


def _cell(column: str, value: float | None, digits: int, *, kind: str = "", after: str = "") -> str:
    """A number, with its exact value for sorting; a dash where there is none."""
    classes = f"num {kind}".strip()
    if value is None:
        return f'<td class="{classes}" data-column="{column}" data-value="">{NONE}</td>'
    return f'<td class="{classes}" data-column="{column}" data-value="{value:.9g}">{value:,.{digits}f}{after}</td>'


def _coverage(share: float) -> str:
    low = "" if share == 1 else " low"
    return f'<td class="num{low}" data-column="coverage" data-value="{share:.9g}">{100 * share:.4g} %</td>'


def _mean(result: Result, metric: str) -> float:
    found = {**result.score["metrics"], **result.score["drift"]}[metric]["mean"]
    return float("inf") if found is None else float(found)


def _quoted_rows(rows: tuple[Quoted, ...]) -> str:
    if not rows:
        return ""
    span = 6 + len(METRICS) * len(SUMMARIES) + len(DRIFTS) + 4
    title = link(the_paper().link, f"the paper, Table {rows[0].table}")
    head = f'<tr><th colspan="{span}" scope="rowgroup">Quoted from {title}: not measured here, not ranked</th></tr>'
    return f'<tbody class="quoted">{head}{"".join(map(_quoted_row, rows))}</tbody>'


def _quoted_row(row: Quoted) -> str:
    more = f'<td class="{_MORE}"></td>'
    figures = [row.figures.get(metric) for metric in METRICS]
    means = [f'<td class="num">{NONE if value is None else f"{value:.3f}"}</td>' for value in figures]
    cells = "".join(mean + more * len(SUMMARIES) for mean in means)
    rest = f"{more * len(DRIFTS)}<td></td><td></td>{more}{more}"
    return f'<tr><td></td><th scope="row" class="name">{text(row.solver)}</th>{cells}{rest}</tr>'


PROTOCOL = "one-step"
"""The reading of the paper's tables that its figures agree with; it does not name a protocol."""


def quoted(board: Board) -> tuple[Quoted, ...]:
    """The paper's rows that stand at ``board``."""
    return the_paper().select(board.split, board.tier) if board.protocol == PROTOCOL else ()
