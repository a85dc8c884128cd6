"""The command lines that the pages show: each runs as it is, for just the board that it is shown at."""

from vbbench.errors import FileError
from vbbench.registry import registered
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.results.boards import HEADLINE_PROTOCOL
from vbbench_leaderboards.results.folder import published_dataset
from vbbench_leaderboards.results.result import Board

OWN_SOLVER = "mysolver:MySolver"
"""The class of the template."""

TEMPLATE = ["vbbench leaderboard template mine", "cd mine"]


def take_part_lines(site: Site) -> list[str]:
    """From nothing to a solver of one's own on the board that the page opens with."""
    board = site.first
    own = [one for one in site.boards if (one.split, one.tier) == (board.split, board.tier)]
    sequential = next((one for one in own if one.protocol == HEADLINE_PROTOCOL), board)
    return [*TEMPLATE, *_solving(site, sequential, OWN_SOLVER)]


def again_lines(site: Site, board: Board) -> list[str]:
    """From nothing to the figures of a solver that comes with vbbench; where none is on the board, to one's own."""
    known = [result.solver for result in site.results[board] if result.solver in registered("solver")]
    return _solving(site, board, known[0]) if known else [*TEMPLATE, *_solving(site, board, OWN_SOLVER)]


def _solving(site: Site, board: Board, solver: str) -> list[str]:
    record, answer = site.dataset(board), f"{board.split}-{board.tier}-{board.protocol}"
    if is_published(site, board):
        return [f"vbbench leaderboard try {solver} --board {board.key} --out site"]
    withheld = record.seed is None
    folder = f"{'../' * (solver == OWN_SOLVER)}{WITHHELD}" if withheld else f"{board.split}-{board.tier}"
    score = f"vbbench score {answer} --dataset {folder}"
    return [
        *([] if withheld else [record.command]),
        f"vbbench solve {folder} --solver {solver} --protocol {board.protocol} --out {answer}",
        score + f" --truth {folder}.truth" * withheld,
    ]


WITHHELD = "data"
"""The folder of a dataset whose truth was withheld, as its maintainer hands it out; the truth lies beside it."""


def is_published(site: Site, board: Board) -> bool:
    """Whether a board stands on the dataset that vbbench publishes results on, and thus knows how to make."""
    try:
        return published_dataset(board.split, board.tier) == site.dataset(board).id
    except FileError:
        return False
