"""One board as a piece of HTML: what is known of its data, its table, its charts, and how to make it again."""

from collections.abc import Iterator

import numpy as np

from vbbench.files.dataset_info import truth_sha256
from vbbench.scoring.scorecard import known
from vbbench_leaderboards.charts.distribution import Spread, distribution
from vbbench_leaderboards.charts.scatter import Point, scatter
from vbbench_leaderboards.charts.svg import Series
from vbbench_leaderboards.markup import code, text
from vbbench_leaderboards.page.downloads import download_links
from vbbench_leaderboards.page.lines import again_lines
from vbbench_leaderboards.page.naming import board_address
from vbbench_leaderboards.page.pairs import pair_tables
from vbbench_leaderboards.page.people import people_table
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.table import board_table
from vbbench_leaderboards.page.words import PROTOCOLS, error_terms, term_of, tiers
from vbbench_leaderboards.results.boards import is_diagnostic
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import headline


def board_html(site: Site, board: Board) -> str:
    """The piece that the page shows for a board."""
    return "".join(
        [
            _heading(site, board),
            _caution(site, board),
            _tools(site, board),
            '<p class="note" id="board-note" role="status" hidden></p>',
            '<p class="unseen" id="board-says" role="status"></p>',
            board_table(site, board),
            '<p id="nothing-found" class="note" hidden>No solver fits what is chosen above.</p>',
            download_links(board),
            _charts(site, board),
            people_table(site, board),
            pair_tables(board, site.rankings[board]),
            _again(site, board),
            "" if board in site.playable else _NO_FILMS,
        ]
    )


_NO_FILMS = (
    '<p class="note" id="no-films">The sequences of this board cannot be watched: the page was built without them.</p>'
)


def _heading(site: Site, board: Board) -> str:
    protocol, tier = term_of(PROTOCOLS, board.protocol), term_of(tiers(), board.tier)
    watch = compare = ""
    if board in site.playable:
        watch = f'<a class="watch" id="watch" href="{text(board_address(board, "play"))}">Watch the sequences</a>'
    if len(site.results[board]) > 1:
        compare = (
            f'<a class="second" id="compare" href="{text(board_address(board, "compare"))}">Compare two solvers</a>'
        )
    return (
        f'<div class="board-head"><h3 id="board-title" tabindex="-1">{text(board.split)} '
        f'<span class="which">{text(protocol.name)}, {text(tier.name)}</span></h3>'
        f'<span class="ways">{compare}{watch}</span></div>'
        f'<p class="lead">{text(site.title(board.split))}. {text(protocol.meaning)} {text(tier.meaning)}</p>'
    )


def _caution(site: Site, board: Board) -> str:
    caution = site.caution(board)
    said = f'<div class="caution" role="note" id="caution"><strong>Caution</strong><p>{text(caution)}.</p></div>'
    kept = f'<p class="note" id="diagnostic">{_DIAGNOSTIC}</p>' if is_diagnostic(board) else ""
    return (said if caution else "") + kept


_DIAGNOSTIC = (
    "A diagnostic: kept to compare with the paper and to find faults. It does not say how a solver does on a camera."
)


def _tools(site: Site, board: Board) -> str:
    solvers = [result.solver for result in site.results[board]]
    chips = "".join(
        f'<label class="chip c{site.colours[solver]}"><input type="checkbox" name="solver" value="{text(solver)}" '
        f"checked>{text(solver)}</label>"
        for solver in solvers
    )
    return (
        '<div class="tools" role="group" aria-label="What the table shows"><label class="find">'
        '<span class="unseen">Filter solvers</span><input type="search" id="filter" placeholder="Filter solvers" '
        f'autocomplete="off"></label><fieldset class="chips" id="chips"><legend class="unseen">Solvers shown</legend>'
        f'{chips}</fieldset><button type="button" id="more-columns" aria-pressed="false" aria-controls="board-table">'
        '<span class="wide">More columns</span><span class="narrow">All columns</span></button></div>'
    )


def _charts(site: Site, board: Board) -> str:
    choices = "".join(
        f'<button type="button" data-choose="{metric}" aria-pressed="false" data-def="def-{metric}" '
        f'aria-describedby="def-{metric}">{term.name}</button>'
        for metric, term in error_terms().items()
    )
    return (
        '<section class="charts" aria-labelledby="charts-title"><div class="charts-head"><h4 id="charts-title">'
        'Accuracy, time and spread</h4><div class="choices" role="group" aria-label="Metric of the charts">'
        f"{choices}</div></div>{''.join(_chart_pair(site, board, metric) for metric in error_terms())}</section>"
    )


def _chart_pair(site: Site, board: Board, metric: str) -> str:
    name, unit = error_terms()[metric].name, error_terms()[metric].unit
    points, spreads = list(_points(site, board, metric)), _spreads(site, board, metric)
    left = scatter(f"time-{metric}", name, unit, points) if points else '<p class="note">No time was reported.</p>'
    return (
        f'<div class="pair" data-metric="{metric}"><figure>{left}<figcaption>Capped error against time. Bars are '
        "95 % intervals; lower left is better.</figcaption></figure><figure>"
        f"{distribution(f'spread-{metric}', name, unit, spreads)}<figcaption>Every sequence. A dot is one percent of "
        "the sequences, the line their median.</figcaption></figure></div>"
    )


def _points(site: Site, board: Board, metric: str) -> Iterator[Point]:
    for result in site.results[board]:
        figure, seconds = headline(result, metric), result.score["seconds_per_frame"]
        if seconds and figure.value is not None:
            ends = None if figure.low is None or figure.high is None else (figure.low, figure.high)
            yield Point(series=_series(site, result), error=figure.value, ci95=ends, micros=1e6 * seconds)


def _series(site: Site, result: Result) -> Series:
    return Series(solver=result.solver, colour=site.colours[result.solver])


def _spreads(site: Site, board: Board, metric: str) -> list[Spread]:
    """The solvers' figures, the smallest median first."""
    spreads = [
        Spread(series=_series(site, result), values=known(result.per_sequence.figures[metric]))
        for result in site.results[board]
    ]
    return sorted(spreads, key=lambda spread: np.median(spread.values) if len(spread.values) else np.inf)


def _again(site: Site, board: Board) -> str:
    lines = code(again_lines(site, board), "Lines that make these figures")
    return (
        '<details class="again" id="again"><summary>Make these figures again</summary>'
        f"{lines}{_facts(site, board)}</details>"
    )


def _facts(site: Site, board: Board) -> str:
    record, results = site.dataset(board), site.results[board]
    score = results[0].score
    facts = {
        "Dataset": results[0].dataset,
        "Made by": "" if record.seed is None else record.command,
        "Protocol": f"{board.protocol}/{score['protocol_version']}",
        "Scored": f"{score['sequences']} of {score['sequences_in_dataset']} sequences, {score['frames']} frames, "
        f"{score['positions']} positions",
        "Scored by": "vbbench " + ", ".join(sorted({result.package_version for result in results})),
        "Truth": "" if record.seed is not None else f"withheld, SHA-256 {truth_sha256(record.tables)}",
        "Licence": record.licence,
        "Cite": record.citation,
    }
    rows = "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>" for name, value in facts.items() if value)
    return f'<dl class="facts">{rows}</dl>'
