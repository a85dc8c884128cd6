"""All that the pages show, put in order once."""

from collections.abc import Mapping
from dataclasses import dataclass

from vbbench.protocol import PROTOCOLS
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.page.words import HEADLINE_TIER, TIERS
from vbbench_leaderboards.results.ranking import Ranking
from vbbench_leaderboards.results.result import Board, Result

SPLITS = ("sim", "hotel", "eth", "eth-15fps", "students", "students-resampled")
"""Splits in the order of the page; others follow by name."""

COLOURS = 8


@dataclass(frozen=True, kw_only=True)
class Site:
    """What the pages show.

    Parameters
    ----------
    results : board → results, by solver.
    datasets : (split, tier) → the record of its dataset.
    rankings : board → metric → ranking.
    playable : board → solvers that the player can show.
    """

    results: Mapping[Board, tuple[Result, ...]]
    datasets: Mapping[tuple[str, str], BoardDataset]
    rankings: Mapping[Board, Mapping[str, Ranking]]
    playable: Mapping[Board, tuple[str, ...]]

    @property
    def boards(self) -> list[Board]:
        """All boards in the order of the page."""
        return sorted(self.results, key=_place)

    @property
    def splits(self) -> list[str]:
        """All splits in the order of the page."""
        return list(dict.fromkeys(board.split for board in self.boards))

    @property
    def solvers(self) -> list[str]:
        """All solvers by name."""
        return sorted({result.solver for results in self.results.values() for result in results})

    @property
    def colours(self) -> dict[str, int]:
        """Solver → number of its colour, the same on every board."""
        return {solver: n % COLOURS + 1 for n, solver in enumerate(self.solvers)}

    @property
    def first(self) -> Board | None:
        """The board that is shown where the address names none: the first headline."""
        headlines = [board for board in self.boards if self.is_headline(board)]
        return next(iter([*headlines, *self.boards]), None)

    def dataset(self, board: Board) -> BoardDataset | None:
        """The record of a board's dataset."""
        return self.datasets.get((board.split, board.tier))

    def title(self, split: str) -> str:
        """What a split is called."""
        return next((record.title for (name, _), record in self.datasets.items() if name == split), split)

    def caution(self, board: Board) -> str | None:
        """What must be known before a board's figures are read."""
        record = self.dataset(board)
        if record is not None:
            return record.caution
        return next((result.score.get("caution") for result in self.results[board]), None)

    def is_headline(self, board: Board) -> bool:
        """Whether headlines may be taken from a board."""
        return board.tier == HEADLINE_TIER and self.caution(board) is None


def key(board: Board) -> str:
    """A board in addresses and file names."""
    return board.folder.as_posix()


def _place(board: Board) -> tuple[object, ...]:
    return (
        *_known(board.split, SPLITS),
        *_known(board.protocol, PROTOCOLS),
        *_known(board.tier, tuple(TIERS)),
    )


def _known(name: str, order: tuple[str, ...]) -> tuple[int, str]:
    return (order.index(name) if name in order else len(order), name)
