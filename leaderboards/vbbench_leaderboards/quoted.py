"""The paper's rows at a board: quoted beside it, unranked, and never part of its statistics."""

from vbbench.paper import Quoted, the_paper
from vbbench_leaderboards.result import Board

PROTOCOL = "one-step"
"""The reading of the paper's tables that its figures agree with; it does not name a protocol."""


def quoted(board: Board) -> tuple[Quoted, ...]:
    """The paper's rows that stand at ``board``."""
    return the_paper().select(board.split, board.tier) if board.protocol == PROTOCOL else ()
