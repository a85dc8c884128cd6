"""Who stands in the table that leads a page: every solver on the boards most like a real camera, the best first."""

from collections.abc import Mapping, Sequence

import numpy as np

from vbbench.protocol import get_protocol
from vbbench_leaderboards.results.boards import HEADLINE_METRIC, HEADLINE_PROTOCOL
from vbbench_leaderboards.results.folder import Boards
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.standings import headline


def leading_rows(results: Boards, boards: Sequence[Board], *, late: bool) -> dict[str, Mapping[Board, Result]]:
    """Solver → its results on these boards, the best first: of those that see the future (``late``), or of others."""
    rows: dict[str, dict[Board, Result]] = {}
    for board in boards:
        for result in results[board]:
            if result.about.sees_the_future is late:
                rows.setdefault(result.solver, {})[board] = result
    order = sorted(rows, key=lambda solver: (_standing(rows[solver], boards), solver))
    return {solver: rows[solver] for solver in order}


def _standing(own: Mapping[Board, Result], boards: Sequence[Board]) -> float:
    """Geometric mean of the capped errors over the boards: no board decides the order of rows alone.

    A board on which the solver does not stand counts with the cap.
    """
    cap = get_protocol(HEADLINE_PROTOCOL).caps[HEADLINE_METRIC]
    figures = [headline(own[board], HEADLINE_METRIC).value if board in own else None for board in boards]
    return float(np.mean(np.log([max(cap if value is None else value, 1e-6) for value in figures])))
