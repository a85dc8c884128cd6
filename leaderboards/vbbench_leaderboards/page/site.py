"""All that the pages show, put in order once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from vbbench.protocol import PROTOCOLS
from vbbench_leaderboards.charts.colours import colour_number
from vbbench_leaderboards.page.sources import Source, bundled_sources
from vbbench_leaderboards.page.words import tiers
from vbbench_leaderboards.results.boards import HEADLINE_PROTOCOL, SPLITS, is_diagnostic, is_headline
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.folder import Boards, Records
from vbbench_leaderboards.results.ranking import Ranking
from vbbench_leaderboards.results.result import Board, Result


@dataclass(frozen=True, kw_only=True)
class Site:
    """What the pages show.

    Parameters
    ----------
    results : board → results, by solver.
    datasets : (split, tier) → the record of its dataset.
    rankings : board → metric → ranking.
    playable : board → solvers that the player can show.
    docs : address of the documentation; "" if the pages do not lead to it.
    """

    results: Boards
    datasets: Records
    rankings: Mapping[Board, Mapping[str, Ranking]]
    playable: Mapping[Board, tuple[str, ...]]
    docs: str = ""

    @cached_property
    def boards(self) -> list[Board]:
        """All boards in the order of the page."""
        return sorted(self.results, key=_place)

    @property
    def splits(self) -> list[str]:
        """All splits in the order of the page."""
        return list(dict.fromkeys(board.split for board in self.boards))

    @property
    def headlines(self) -> list[Board]:
        """The boards that the front page leads with: those of the tier that is like a real camera, then real ones."""
        return [board for board in self.boards if is_headline(board)]

    @cached_property
    def solvers(self) -> dict[str, dict[Board, Result]]:
        """Solver → board → its result there, boards in the order of the page."""
        rows = [(result.solver, board, result) for board in self.boards for result in self.results[board]]
        found: dict[str, dict[Board, Result]] = {name: {} for name in sorted({name for name, _, _ in rows})}
        for name, board, result in rows:
            found[name][board] = result
        return found

    @cached_property
    def sources(self) -> dict[str, Source]:
        """Solver → its source file, of those that come with vbbench and name no other code."""
        silent = [name for name, own in self.solvers.items() if not any(row.about.code for row in own.values())]
        return bundled_sources(silent)

    @cached_property
    def colours(self) -> dict[str, int]:
        """Solver → number of its colour, whatever else is shown."""
        return {solver: colour_number(solver) for solver in self.solvers}

    @property
    def first(self) -> Board:
        """The board that is shown where the address names none: the first headline, or else the first that counts."""
        counting = [board for board in self.boards if not is_diagnostic(board)]
        return next(iter([*self.headlines, *counting, *self.boards]))

    def entry(self, split: str) -> Board:
        """The board of a split that its link leads to."""
        own = [board for board in self.boards if board.split == split]
        sequential = [board for board in own if board.protocol == HEADLINE_PROTOCOL and not is_diagnostic(board)]
        return next(iter([*filter(is_headline, own), *sequential, *own]))

    def dataset(self, board: Board) -> BoardDataset:
        """The record of a board's dataset."""
        return self.datasets[board.split, board.tier]

    def title(self, split: str) -> str:
        """A split's title."""
        return next(record.title for (name, _), record in self.datasets.items() if name == split)

    def caution(self, board: Board) -> str | None:
        """What must be known before a board's figures are read."""
        return self.dataset(board).caution


def _place(board: Board) -> list[tuple[int, str]]:
    """Known splits, protocols and tiers in their order, others after them by name."""
    parts = ((board.split, SPLITS), (board.protocol, PROTOCOLS), (board.tier, list(tiers())))
    return [(order.index(name) if name in order else len(order), name) for name, order in parts]
