"""Boards as files for papers and programs: CSV, Markdown and LaTeX."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from vbbench.errors import UnknownNameError
from vbbench.protocol import get_protocol
from vbbench.scoring.scorecard import SHOWN_HEAD, VALUES_HEAD, ranking_fact, shown_cells, value_cells
from vbbench.table import Table, csv_text, unmarked
from vbbench_leaderboards.results.boards import HEADLINE_METRIC
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.folder import Boards, Records
from vbbench_leaderboards.results.ranking import Place, Ranking, headline, rank_apart
from vbbench_leaderboards.results.result import Board, Result

Format = Literal["csv", "latex", "markdown"]
DOWNLOADS: dict[Format, tuple[str, str]] = {
    "csv": ("CSV", "csv"),
    "latex": ("LaTeX", "tex"),
    "markdown": ("Markdown", "md"),
}
"""The formats, with the words of the links to their files, and how their names end."""

_ABOUT = ("authors", "date", "reference", "code", "trained_on", "tuned_on", "rerun_by")
_PLACES = ("rank", "best_rank", "worst_rank")
_HEAD = ("split", "tier", "protocol", "dataset", *_PLACES, "solver", "version", "timing", "seen", *VALUES_HEAD, *_ABOUT)


@dataclass(frozen=True, kw_only=True)
class ExportedBoard:
    """A board, the record of its dataset, its rows in the order of its table, and solver → its rank in its group."""

    board: Board
    record: BoardDataset
    results: tuple[Result, ...]
    places: dict[str, Place]

    @staticmethod
    def of(
        board: Board, record: BoardDataset, results: Sequence[Result], ranking: Ranking | None = None
    ) -> "ExportedBoard":
        """A board's results in the order of its table; they are ranked here unless their ranking is known."""
        return ExportedBoard(
            board=board,
            record=record,
            results=tuple(sorted(results, key=_order)),
            places=(ranking or rank_apart(results)[HEADLINE_METRIC]).places,
        )

    def table(self) -> Table:
        """The table for people; the best of a column is marked in each group of solvers that compete."""
        cells = shown_cells([one.score for one in self.results], [one.group for one in self.results])
        names = [[self._rank(one), unmarked(one.solver), _how(one)] for one in self.results]
        board, protocol = self.board, get_protocol(self.board.protocol)
        return Table(
            title=unmarked(f"{board.split}, {protocol.id}, tier {board.tier}: {self.record.title}"),
            facts=[ranking_fact(protocol), _RANKS, *self._facts()],
            head=["rank", "solver", "timing", *SHOWN_HEAD],
            rows=[[*who, *figures] for who, figures in zip(names, cells, strict=True)],
            names=3,
        )

    def _rank(self, result: Result) -> str:
        place = self.places[result.solver]
        return f"{place.rank}" if place.best == place.worst else f"{place.rank} ({place.best}–{place.worst})"

    def rows(self) -> Iterator[list[object]]:
        """A row of values per result, as `_HEAD` names them."""
        where = (self.board.split, self.board.tier)
        for one in self.results:
            place, about = self.places[one.solver], one.about
            protocol = f"{self.board.protocol}/{one.score['protocol_version']}"
            named = (place.rank, place.best, place.worst, one.solver, one.version, about.timing, one.seen)
            facts = (getattr(about, name) for name in _ABOUT)
            yield [*where, protocol, one.dataset, *named, *value_cells(one.score), *facts]

    def _facts(self) -> Iterator[str]:
        score, record = self.results[0].score, self.record
        counts = (
            f"{score['sequences']} sequences, {score['frames']} frames and {score['positions']} positions are scored"
        )
        yield f"{counts}; dataset {record.id}."
        if record.caution:
            yield unmarked(f"Caution: {record.caution}.")
        if record.citation:
            yield unmarked(f"Data: {record.citation}.")


_RANKS = (
    "Rank: one more than the number of solvers that are significantly better in Δx, and never above a solver with a "
    "smaller mean, in brackets what the figures leave open; solvers that see frames after the one they answer are "
    "ranked apart, and so are solvers that were trained or tuned on recordings of the board."
)


def table_address(board: Board, form: Format) -> str:
    """Where a board's file in a format lies in the site."""
    return f"tables/{board.key}.{DOWNLOADS[form][1]}"


def exported_boards(results: Boards, records: Records, keys: Sequence[str] = ()) -> list[ExportedBoard]:
    """The boards called ``keys`` (``SPLIT/PROTOCOL-TIER``) in that order; all without any.

    Raises UnknownNameError if a board is none of those with results.
    """
    known = {board.key: board for board in results}
    for key in keys:
        if key not in known:
            raise UnknownNameError("board", key, known)
    chosen = [known[key] for key in dict.fromkeys(keys or known)]
    return [ExportedBoard.of(board, records[board.split, board.tier], results[board]) for board in chosen]


def exported_text(boards: Sequence[ExportedBoard], form: Format) -> str:
    """Boards as one text: CSV as one table, the others one after the other."""
    if form == "csv":
        return csv_text(_HEAD, (row for board in boards for row in board.rows()))
    return "\n".join(line for board in boards for line in getattr(board.table(), form)())


def _how(result: Result) -> str:
    """Whether a solver is causal, and whether it saw recordings of the board."""
    return f"{result.about.timing}, {result.seen} on these recordings" if result.seen else result.about.timing


def _order(result: Result) -> tuple[tuple[bool, bool], float, str]:
    figure = headline(result, HEADLINE_METRIC).value
    return result.group, float("inf") if figure is None else figure, result.solver
