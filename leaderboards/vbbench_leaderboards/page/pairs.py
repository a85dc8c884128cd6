"""The differences between every two solvers of a board that compete, folded away below it."""

import math
from collections.abc import Mapping

from vbbench_leaderboards.markup import NONE, decimals, figure_decimals, signed, text
from vbbench_leaderboards.page.naming import board_address
from vbbench_leaderboards.page.words import error_terms
from vbbench_leaderboards.results.ranking import LEVEL, Pair, Ranking
from vbbench_leaderboards.results.result import Board


def pair_tables(board: Board, rankings: Mapping[str, Ranking]) -> str:
    """A table per metric, folded away; empty where there is nobody to compare."""
    if not next(iter(rankings.values())).pairs:
        return ""
    tables = "".join(_pair_table(board, metric, rankings[metric]) for metric in error_terms())
    return (
        '<details class="pairs" id="pairs"><summary>Differences between solvers</summary>'
        "<p>Mean over sequences of A − B, each error capped, with its 95 % interval: below zero, A is better. The "
        "p-values are of a paired bootstrap over blocks of time, corrected after Holm; below "
        f"{LEVEL:g} a difference counts as settled. Who sees the future is compared with its like alone.</p>"
        f"{tables}</details>"
    )


def _pair_table(board: Board, metric: str, ranking: Ranking) -> str:
    term = error_terms()[metric]
    digits = decimals([pair.difference for pair in ranking.pairs])
    rows = "".join(
        _pair_row(pair, digits, board_address(board, "compare", a=pair.a, b=pair.b, by=metric))
        for pair in ranking.pairs
    )
    return (
        f'<div class="scroll" data-metric="{metric}" tabindex="0" role="region" aria-label="Differences in '
        f'{term.name}"><table class="plain"><thead><tr><th scope="col">A</th><th scope="col">B</th>'
        f'<th scope="col" class="num">{term.name} of A − B, {term.unit}</th><th scope="col" class="num">p</th>'
        f'<th scope="col">Better</th><td></td></tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _pair_row(pair: Pair, digits: int, address: str) -> str:
    low, high = pair.ci95
    if math.isnan(pair.difference):
        figures = f'<td class="num">{NONE}</td><td class="num">{NONE}</td>'
    else:
        p = "&lt; 0.01" if pair.p < 0.01 else f"{pair.p:.2f}"
        ends = " to ".join(f"{end:+.{figure_decimals(pair.difference, digits)}f}" for end in (low, high))
        between = "" if math.isnan(low) else f'<span class="ci">{ends.replace("-", "−")}</span>'
        figures = f'<td class="num">{signed(pair.difference, digits)}{between}</td><td class="num">{p}</td>'
    return (
        f'<tr><th scope="row">{text(pair.a)}</th><td>{text(pair.b)}</td>{figures}'
        f"<td>{text(pair.better) if pair.better else 'not settled'}</td>"
        f'<td><a href="{text(address)}" aria-label="Compare {text(pair.a)} and {text(pair.b)}">compare</a></td></tr>'
    )
