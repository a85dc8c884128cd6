"""Boards as files for papers and programs: CSV, JSON, Markdown, LaTeX, and what to cite as BibTeX."""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from string import Template
from typing import Any, Literal

from vbbench import __version__
from vbbench.errors import UnknownNameError
from vbbench.protocol import get_protocol
from vbbench.scoring.scorecard import SHOWN_HEAD, VALUES_HEAD, ranking_fact, shown_cells, value_cells
from vbbench.table import Table, csv_text, latex_text, unmarked
from vbbench_leaderboards.results.boards import HEADLINE_METRIC
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.folder import Boards, Records
from vbbench_leaderboards.results.ranking import Place, Ranking, rank_apart, ranking_figure
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.words import is_web_address

ALWAYS = ("vbbench", "the paper")
"""What every board rests upon: names in ``references.bib``."""


def bibliography(results: Sequence[Result], records: Sequence[BoardDataset]) -> str:
    """The entries of boards with these results, on these datasets; each once."""
    known = known_references()
    entries = [Template(known[name]).safe_substitute(version=__version__) for name in ALWAYS]
    sources = dict.fromkeys(part for one in records for part in cited(one.citation) if part not in ALWAYS)
    data = (known.get(one) or _entry(f"data-{_short_hash(one)}", {"note": one}) for one in sources)
    return "\n\n".join([*entries, *data, *_solvers(results)]) + "\n"


def cited(citation: str) -> Iterator[str]:
    """The works that a citation names, without the notes in brackets."""
    for part in citation.split("; "):
        if part:
            yield re.sub(r" \([^()]*\)$", "", part)


@cache
def known_references() -> dict[str, str]:
    """Citation, as splits state it → its entry in ``references.bib``, where it stands as a comment above the entry."""
    text = Path(__file__).with_name("references.bib").read_text("utf-8")
    blocks = (block.partition("\n") for block in text.strip().split("\n\n"))
    return {comment.removeprefix("% "): entry.strip() for comment, _, entry in blocks}


def _solvers(results: Sequence[Result]) -> Iterator[str]:
    """An entry for every solver whose row names a description, the same on all boards."""
    found = {(one.solver, one.about.reference): one for one in results if one.about.reference}
    names = [solver for solver, _ in found]
    for (solver, reference), one in found.items():
        key = f"solver-{re.sub('[^A-Za-z0-9]+', '-', solver).strip('-')}"
        if names.count(solver) > 1 or key == "solver-":
            key += f"-{_short_hash(solver + reference)}"
        facts = {"title": solver, "author": one.about.authors, "year": one.about.date[:4], "note": reference}
        yield _entry(key, facts, next(filter(is_web_address, (reference, one.about.code)), ""))


def _entry(key: str, facts: dict[str, str], address: str = "") -> str:
    fields = [f"  {name} = {{{{{latex_text(value)}}}}}," for name, value in facts.items() if value]
    if address:
        fields.append(f"  url = {{{re.sub(r'[{}%]', _percent, address)}}},")
    return "\n".join([f"@misc{{{key},", *fields, "}"])


def _percent(found: re.Match[str]) -> str:
    r"""Braces as an address writes them; ``\%``, because TeX takes the rest of the line after % for a comment."""
    return r"\%" if found[0] == "%" else rf"\%{ord(found[0]):02X}"


def _short_hash(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:8]


Format = Literal["csv", "latex", "markdown", "json", "bibtex"]
DOWNLOADS: dict[Format, str] = {
    "csv": "CSV",
    "latex": "LaTeX",
    "markdown": "Markdown",
    "json": "JSON",
    "bibtex": "what to cite as BibTeX",
}
"""The formats, with the words of the links to their files."""

_ENDINGS: dict[Format, str] = {"latex": "tex", "markdown": "md", "bibtex": "bib"}

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
            results=tuple(sorted(results, key=lambda one: (one.group, ranking_figure(one), one.solver))),
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

    def values(self) -> dict[str, Any]:
        """The board for programs: its dataset, and of every row the place, the score, and who stands there."""
        record, board = self.record, self.board
        facts = ("id", "title", "caution", "licence", "citation", "command")
        rows = [
            {
                **vars(self.places[one.solver]),
                **vars(one.about),
                "seen": one.seen,
                "version": one.version,
                "score": one.score,
            }
            for one in self.results
        ]
        place = {"split": board.split, "tier": board.tier, "protocol": get_protocol(board.protocol).id}
        return place | {"dataset": {name: getattr(record, name) for name in facts}, "rows": rows}

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
    return f"tables/{board.key}.{_ENDINGS.get(form, form)}"


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
    """Boards as one text: CSV and BibTeX as one table and one list, JSON as a list, the others one after the other."""
    if form == "csv":
        return csv_text(_HEAD, (row for board in boards for row in board.rows()))
    if form == "json":
        return json.dumps([board.values() for board in boards], indent=1, ensure_ascii=False) + "\n"
    if form == "bibtex":
        return bibliography([one for board in boards for one in board.results], [board.record for board in boards])
    return "\n".join(line for board in boards for line in getattr(board.table(), form)())


def _how(result: Result) -> str:
    """Whether a solver is causal, and whether it saw recordings of the board."""
    return f"{result.about.timing}, {result.seen} on these recordings" if result.seen else result.about.timing
