"""The table of headlines: who is best on each split, with noise, by the position error of people."""

from collections.abc import Iterator

from vbbench.protocol import PROTOCOLS
from vbbench_leaderboards.markup import NONE, decimals, text
from vbbench_leaderboards.page.site import Site, key
from vbbench_leaderboards.page.words import HEADLINE_METRIC, HEADLINE_TIER
from vbbench_leaderboards.page.words import PROTOCOLS as WORDS
from vbbench_leaderboards.results.result import Board, Result


def headline_table(site: Site) -> str:
    """The table; a split whose board carries a caution has no row."""
    splits = [split for split in site.splits if any(_board(site, split, protocol) for protocol in PROTOCOLS)]
    if not splits:
        return '<p class="note">No board is fit for a headline yet.</p>'
    heads = "".join(
        f'<th scope="col"><button type="button" class="term" data-def="def-{name}" aria-describedby="def-{name}">'
        f"{text(WORDS[name].full)}</button></th>"
        for name in PROTOCOLS
    )
    rows = "".join(_row(site, split) for split in splits)
    return (
        '<div class="scroll" tabindex="0" role="region" aria-label="Table of best solvers"><table class="headline" '
        f'id="headline"><thead><tr><th scope="col">Split</th>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
        f"{_left_out(site)}"
    )


def _row(site: Site, split: str) -> str:
    cells = "".join(_cell(site, _board(site, split, protocol)) for protocol in PROTOCOLS)
    return f'<tr><th scope="row">{text(split)}</th>{cells}</tr>'


def _cell(site: Site, board: Board | None) -> str:
    if board is None:
        return f"<td>{NONE}</td>"
    best = list(_best(site, board))
    means = [result.score["metrics"][HEADLINE_METRIC]["mean"] for result in best]
    digits = decimals(means)
    names = "".join(
        f'<span class="best"><span class="dot c{site.colours[result.solver]}"></span>{text(result.solver)} '
        f'<b class="figure">{mean:.{digits}f}</b></span>'
        for result, mean in zip(best, means, strict=True)
    )
    return f'<td><a href="#/{text(key(board))}">{names}</a></td>'


def _best(site: Site, board: Board) -> Iterator[Result]:
    """The solvers that nobody is significantly better than, the smallest error first; at most three."""
    places = site.rankings[board][HEADLINE_METRIC].places
    first = [result for result in site.results[board] if places[result.solver].rank == 1]
    there = [result for result in first if result.score["metrics"][HEADLINE_METRIC]["mean"] is not None]
    yield from sorted(there, key=lambda result: (result.score["metrics"][HEADLINE_METRIC]["mean"], result.solver))[:3]


def _board(site: Site, split: str, protocol: str) -> Board | None:
    board = Board(split=split, tier=HEADLINE_TIER, protocol=protocol)
    return board if board in site.results and site.is_headline(board) else None


def _left_out(site: Site) -> str:
    """Why a split is not there."""
    cautioned = {
        board.split for board in site.boards if board.tier == HEADLINE_TIER and site.caution(board) is not None
    }
    if not cautioned:
        return ""
    names = ", ".join(split for split in site.splits if split in cautioned)
    return f'<p class="note">No headline is taken from {text(names)}: see the caution at its boards.</p>'
