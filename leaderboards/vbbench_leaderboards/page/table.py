"""The tables of a board: its solvers with the paper's rows below, and the differences between every two solvers."""

import json
import math
from collections.abc import Iterator
from typing import Any

from vbbench.paper import Quoted, the_paper
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.markup import NONE, decimals, link, text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import COLUMNS, SUMMARIES, drift_terms, error_terms
from vbbench_leaderboards.results.ranking import LEVEL, Pair, Ranking
from vbbench_leaderboards.results.result import Board, Result

_MORE = "more"
"""Class of the columns that are shown on request only."""

QUOTED_PROTOCOL = "one-step"
"""The protocol that the paper's figures agree with; its text says ``sequential`` (docs/reproduce.md)."""


def board_table(site: Site, board: Board) -> str:
    """The table with its scrolling frame."""
    rows = sorted(site.results[board], key=lambda result: (_mean(result, "dx"), result.solver))
    digits = {name: decimals([_mean(result, name) for result in rows]) for name in METRICS}
    body = "".join(_row(site, board, result, digits) for result in rows)
    name = f"{board.split}, {board.protocol}, {board.tier}"
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="Table of results">'
        f'<table class="board" id="board-table" data-board="{text(board.key)}">'
        f'<caption class="unseen">Results on {text(name)}. Column heads sort.</caption>'
        f'<thead><tr>{"".join(_heads())}</tr></thead><tbody id="board-rows">{body}</tbody>'
        f"{_quoted_rows(board)}</table></div>"
    )


def _heads() -> Iterator[str]:
    yield _head("rank", COLUMNS["rank"].name, definition="rank")
    yield _head("solver", "Solver", kind="name")
    for metric, term in error_terms().items():
        yield _head(metric, term.name, term.unit, definition=metric)
        for summary, how in SUMMARIES.items():
            name = f"{term.name} {how.name}"
            yield _head(f"{metric}_{summary}", name, term.unit, definition=summary, kind=f"num {_MORE}")
    for drift, term in drift_terms().items():
        yield _head(drift, term.name, term.unit, definition=drift, kind=f"num {_MORE}")
    for column in ("coverage", "time"):
        yield _head(column, COLUMNS[column].name, COLUMNS[column].unit, definition=column)
    yield _head("version", "Version", kind=_MORE)
    yield _head("hardware", "Hardware", kind=_MORE)


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
        *(cell for metric in error_terms() for cell in _metric_cells(metric, score["metrics"][metric], digits[metric])),
        *(_cell(drift, score["drift"][drift]["mean"], digits[drift], kind=_MORE) for drift in drift_terms()),
        _coverage(score["coverage"]),
        _cell("time", None if seconds is None else 1e6 * seconds, 0),
        f'<td class="{_MORE}">{text(result.version) or NONE}</td>',
        f'<td class="{_MORE} hardware">{text(result.hardware) or NONE}</td>',
    ]
    words = " ".join([result.solver, result.version, result.reference, result.hardware]).lower()
    return f'<tr data-solver="{text(result.solver)}" data-words="{text(words)}">{"".join(cells)}</tr>'


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


def _quoted_rows(board: Board) -> str:
    """The paper's rows: quoted beside the board, unranked, and never part of its statistics."""
    rows = the_paper().select(board.split, board.tier) if board.protocol == QUOTED_PROTOCOL else ()
    if not rows:
        return ""
    span = 6 + len(error_terms()) * len(SUMMARIES) + len(drift_terms()) + 4
    title = link(the_paper().link, f"the paper, Table {rows[0].table}")
    head = f'<tr><th colspan="{span}" scope="rowgroup">Quoted from {title}: not measured here, not ranked</th></tr>'
    return f'<tbody class="quoted">{head}{"".join(map(_quoted_row, rows))}</tbody>'


def _quoted_row(row: Quoted) -> str:
    more = f'<td class="{_MORE}"></td>'
    figures = [row.figures.get(metric) for metric in error_terms()]
    means = [f'<td class="num">{NONE if value is None else f"{value:.3f}"}</td>' for value in figures]
    cells = "".join(mean + more * len(SUMMARIES) for mean in means)
    rest = f"{more * len(drift_terms())}<td></td><td></td>{more}{more}"
    return f'<tr><td></td><th scope="row" class="name">{text(row.solver)}</th>{cells}{rest}</tr>'


def pair_tables(rankings: dict[str, Ranking]) -> str:
    """A table per metric, folded away; empty where there is nobody to compare."""
    if not next(iter(rankings.values())).pairs:
        return ""
    tables = "".join(_pair_table(metric, rankings[metric]) for metric in error_terms())
    return (
        '<details class="pairs" id="pairs"><summary>Differences between solvers</summary>'
        "<p>Mean over sequences of A − B with its 95 % interval: below zero, A is better. The p-values are of a "
        f"paired bootstrap over sequences, corrected after Holm; below {LEVEL:g} a difference counts as settled.</p>"
        f"{tables}</details>"
    )


def _pair_table(metric: str, ranking: Ranking) -> str:
    term = error_terms()[metric]
    digits = decimals([pair.difference for pair in ranking.pairs])
    rows = "".join(_pair_row(pair, digits) for pair in ranking.pairs)
    return (
        f'<div class="scroll" data-metric="{metric}" tabindex="0" role="region" aria-label="Differences in '
        f'{term.name}"><table class="plain"><thead><tr><th scope="col">A</th><th scope="col">B</th>'
        f'<th scope="col" class="num">{term.name} of A − B, {term.unit}</th><th scope="col" class="num">p</th>'
        f'<th scope="col">Better</th></tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _pair_row(pair: Pair, digits: int) -> str:
    low, high = pair.ci95
    if math.isnan(pair.difference):
        figures = f'<td class="num">{NONE}</td><td class="num">{NONE}</td>'
    else:
        p = "&lt; 0.01" if pair.p < 0.01 else f"{pair.p:.2f}"
        between = f'<span class="ci">{_signed(low, digits)} to {_signed(high, digits)}</span>'
        figures = f'<td class="num">{_signed(pair.difference, digits)}{between}</td><td class="num">{p}</td>'
    return (
        f'<tr><th scope="row">{text(pair.a)}</th><td>{text(pair.b)}</td>{figures}'
        f"<td>{text(pair.better) if pair.better else 'not settled'}</td></tr>"
    )


def _signed(value: float, digits: int) -> str:
    return f"{value:+.{digits}f}".replace("-", "−")
