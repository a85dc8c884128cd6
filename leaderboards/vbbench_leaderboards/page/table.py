"""The table of a board: each group of solvers that compete, and the paper's rows below."""

import json
from collections.abc import Iterator, Mapping

from vbbench.paper import Quoted, the_paper
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.markup import NONE, decimals, figure_decimals, link, padded, percent, text
from vbbench_leaderboards.page.naming import code_link, dot, solver_link
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import COLUMNS, SUMMARIES, drift_terms, error_terms
from vbbench_leaderboards.results.boards import HEADLINE_METRIC
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import GROUPS, Headline, failure_rate, grouped, headline, summary

_MORE = "more"
"""Class of the columns that are shown on request only."""

QUOTED_PROTOCOL = "one-step"
"""The protocol that the paper's figures agree with; its text says ``sequential`` (docs/reproduce.md)."""


def board_table(site: Site, board: Board) -> str:
    """The table with its scrolling frame: the groups of solvers that compete, then the paper's rows."""
    rows = sorted(site.results[board], key=lambda result: (_ranking_figure(result, "dx"), result.solver))
    digits = {name: decimals([_ranking_figure(result, name) for result in rows]) for name in METRICS}
    groups = {(False, False): ""}
    for group, own in grouped(rows).items():
        groups[group] = "".join(_row(site, board, result, digits) for result in own)
    name = f"{board.split}, {board.protocol}, {board.tier}"
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="Table of results">'
        f'<table class="board" id="board-table" data-board="{text(board.key)}">'
        f'<caption class="unseen">Results on {text(name)}. Column heads sort.</caption>'
        f"<thead><tr>{''.join(_heads())}</tr></thead>"
        f"{''.join(map(_group, groups, groups.values()))}{_quoted_rows(board)}</table></div>"
    )


def _group(group: tuple[bool, bool], rows: str) -> str:
    """The rows of solvers that compete with one another, below the words that say who they are."""
    head = (
        f'<tbody class="apart"><tr><th colspan="{_columns()}" scope="rowgroup"><span>{GROUPS[group]}</span></th></tr>'
        "</tbody>"
        if GROUPS[group]
        else ""
    )
    return f'{head}<tbody class="rows" id="{_IDS[group]}">{rows}</tbody>'


_IDS = {
    (False, False): "board-rows",
    (False, True): "tuned-rows",
    (True, False): "late-rows",
    (True, True): "late-tuned-rows",
}


def _heads() -> Iterator[str]:
    yield _head("rank", COLUMNS["rank"].name, definition="rank", kind="num rank")
    yield _head("solver", "Solver", kind="name")
    for metric, term in error_terms().items():
        yield _head(metric, term.name, term.unit, definition=metric, kind=f"num {_main(metric)}".strip())
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
        f'<td class="num rank" data-column="rank" data-ranks="{every}">{_rank(*ranks["dx"])}</td>',
        _solver(site, result),
        *(cell for metric in error_terms() for cell in _metric_cells(result, metric, digits[metric])),
        *(_cell(drift, headline(result, drift).value, digits[drift], kind=_MORE) for drift in drift_terms()),
        _share("failures", failure_rate(result)),
        _share("coverage", score["coverage"], low=score["coverage"] < 1),
        _cell("time", None if seconds is None else 1e6 * seconds, 0),
        f'<td class="{_MORE}" data-column="version">{text(result.version) or NONE}</td>',
        f'<td class="{_MORE} hardware" data-column="hardware">{text(result.hardware) or NONE}</td>',
    ]
    about = result.about
    said = [about.timing, about.reference, about.authors, about.trained_on, about.tuned_on, result.seen]
    words = " ".join([result.solver, result.version, *said, result.hardware]).lower()
    return f'<tr data-solver="{text(result.solver)}" data-words="{text(words)}">{"".join(cells)}</tr>'


def _rank(rank: int, best: int, worst: int) -> str:
    return f"{rank}" if worst == best else f'{rank}<span class="ci">{best}–{worst}</span>'


def _solver(site: Site, result: Result) -> str:
    code = code_link(site, result)
    seen = f'<strong class="seen">{result.seen} on these recordings</strong>' if result.seen else ""
    words = f'<span class="about">{text(result.about.timing)}{f" · {code}" if code else ""}{seen}</span>'
    name = f"{dot(site, result.solver)}{solver_link(result.solver)}"
    return f'<th scope="row" class="name" data-value="{text(result.solver)}">{name}{words}</th>'


def _metric_cells(result: Result, metric: str, digits: int) -> Iterator[str]:
    figure, others = headline(result, metric), summary(result, metric)
    yield _cell(metric, figure.value, digits, kind=_main(metric), after=interval(figure, digits))
    for name in SUMMARIES:
        yield _cell(f"{metric}_{name}", others[name], digits, kind=_MORE)


def interval(figure: Headline, digits: int) -> str:
    """The interval of a ranking figure in a column of so many decimals, with as many as the figure has; or nothing."""
    if figure.value is None or figure.low is None or figure.high is None:
        return ""
    own = figure_decimals(figure.value, digits)
    return f'<span class="ci">{figure.low:.{own}f}–{figure.high:.{own}f}</span>'


def _main(column: str) -> str:
    """The class of the column by which the table is sorted at first, the one that a phone shows."""
    return "main" if column == HEADLINE_METRIC else ""


def _cell(column: str, value: float | None, digits: int, *, kind: str = "", after: str = "") -> str:
    """A number, with its exact value for sorting; a dash where there is none."""
    classes = f"num {kind}".strip()
    if value is None:
        return f'<td class="{classes}" data-column="{column}" data-value="">{NONE}</td>'
    return f'<td class="{classes}" data-column="{column}" data-value="{value:.9g}">{padded(value, digits)}{after}</td>'


def _share(column: str, share: float | None, *, low: bool = False) -> str:
    if share is None:
        return _cell(column, None, 0)
    classes = "num low" if low else "num"
    return f'<td class="{classes}" data-column="{column}" data-value="{share:.9g}">{percent(share)}</td>'


def _ranking_figure(result: Result, metric: str) -> float:
    found = headline(result, metric).value
    return float("inf") if found is None else found


def _quoted_rows(board: Board) -> str:
    """The paper's rows: quoted beside the board, unranked, with what they are of, and never part of its statistics."""
    rows = the_paper().select(board.split, board.tier) if board.protocol == QUOTED_PROTOCOL else ()
    if not rows:
        return ""
    title = link(the_paper().link, f"the paper, Table {rows[0].table}")
    words = f"Quoted from {title}: not measured here, not ranked. {_READING}"
    head = f'<tr><th colspan="{_columns()}" scope="rowgroup"><span>{words}</span></th></tr>'
    digits = {metric: decimals([row.figures.get(metric, 0.0) for row in rows]) for metric in error_terms()}
    return f'<tbody class="quoted">{head}{"".join(_quoted_row(row, digits) for row in rows)}</tbody>'


_READING = (
    "<b>Which protocol?</b> The paper's text describes sequential. Nothing measured under that text comes near its VB "
    "figures: Δx is 8.5 times as large. They are met under <b>one-step</b>, with heights known from the given "
    "frames, so they stand here. Its CV and SF rows fit no single reading. All are plain means over frames, without a "
    "cap."
)
"""What `vbbench reproduce readings` finds (docs/reproduce.md)."""


def _quoted_row(row: Quoted, digits: Mapping[str, int]) -> str:
    cells = "".join(_quoted_cells(row, metric, digits[metric]) for metric in error_terms())
    rest = f"{_EMPTY_MORE * len(drift_terms())}<td></td><td></td><td></td>{_EMPTY_MORE * 2}"
    fits = f"read as {QUOTED_PROTOCOL}" if len(row.figures) > 1 else "no single reading fits"
    words = f'<span class="about">paper, {fits}</span>'
    return f'<tr><td class="rank"></td><th scope="row" class="name">{text(row.solver)}{words}</th>{cells}{rest}</tr>'


_EMPTY_MORE = f'<td class="{_MORE}"></td>'


def _quoted_cells(row: Quoted, metric: str, digits: int) -> str:
    value = row.figures.get(metric)
    mean = '<span class="ci">plain mean</span>' if value is not None else ""
    shown = NONE if value is None else f"{value:.{digits}f}"
    return f'<td class="{f"num {_main(metric)}".strip()}">{shown}{mean}</td>{_EMPTY_MORE * len(SUMMARIES)}'
