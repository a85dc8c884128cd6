"""One step from a solver to its place among the published: dataset, answers, score and page of one board."""

import re
from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.generation import generate
from vbbench.protocol import PROTOCOLS
from vbbench.solving import solve
from vbbench.solving.submissions import declared_facts
from vbbench_leaderboards.results.about import NEEDED, NOBODY_YET
from vbbench_leaderboards.results.boards import source
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, record_path
from vbbench_leaderboards.results.folder import dataset_folder, published_results, read_results, submission_folder
from vbbench_leaderboards.results.result import Board
from vbbench_leaderboards.results.standings import SEEN_WORDS, headline, rank_apart
from vbbench_leaderboards.submitting import add

TRIED = "tried"
"""Folder of the results that were tried, in the work folder: they are nobody's but yours."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A solver that was tried on a board.

    Parameters
    ----------
    board : the board.
    results : the folder that holds its result, and others that were tried.
    name : what it is called there.
    """

    board: Board
    results: Path
    name: str

    def text(self) -> str:
        """Its place among the published results, for people."""
        rows = read_results(self.results, published_results())[self.board]
        places = rank_apart(rows)["dx"].places
        own = next(result for result in rows if result.solver == self.name)
        rivals = sum(result.group == own.group for result in rows)
        place, figure = places[self.name], headline(own, "dx")
        between = "" if place.best == place.worst else f" (between {place.best} and {place.worst})"
        interval = "" if figure.low is None else f", 95 % interval {figure.low:.4f}–{figure.high:.4f}"
        return (
            f"{self.name} on {self.board.key}: rank {place.rank}{between} of {rivals} {_KINDS[own.group]}, "
            f"Δx {figure.value:.4f} m{interval}"
        )


_KINDS = {
    (False, False): "causal solvers",
    (False, True): f"causal solvers {SEEN_WORDS}",
    (True, False): "solvers that see the future",
    (True, True): f"solvers that see the future, {SEEN_WORDS}",
}


def try_solver(solver: str, board: str, work: Path, *, name: str = "", jobs: int = 1) -> Trial:
    """Make a published board's dataset, if it is not there, and solve and score it with a solver.

    Parameters
    ----------
    solver : a registered name, or ``module:attribute``.
    board : ``SPLIT/PROTOCOL-TIER``.
    work : the work folder, laid out as that of ``vbbench leaderboard rerun``.
    name : what the solver is called on the board; by default the attribute's name.
    jobs : processes.

    Raises
    ------
    VbbenchError
        If the board is not published, or this machine makes another dataset.
    """
    asked, name = parse_board(board), name or solver.rpartition(":")[2]
    _check_declared(solver)
    record = read_dataset(published_results() / record_path(asked.split, asked.tier))
    dataset = _dataset(asked, record, work, jobs)
    answers = submission_folder(work, asked, name)
    solve(dataset, solver, asked.protocol, answers, jobs=jobs, overwrite=True)
    add(answers, dataset.folder, work / TRIED, name=name, overwrite=True)
    return Trial(board=asked, results=work / TRIED, name=name)


def _check_declared(solver: str) -> None:
    """Raise VbbenchError if the solver's class does not say what its row must, before anything is made."""
    declared = declared_facts(solver)
    missing = [name for name in NEEDED if not declared.get(name, "").strip()]
    if missing:
        example = {"authors": NOBODY_YET} | dict.fromkeys(NEEDED[1:], "nothing")
        words = f"{solver} does not say {', '.join(missing)}"
        raise VbbenchError(f"{words}; its class needs a line such as facts = {example}")


def parse_board(key: str) -> Board:
    """The published board of a key ``SPLIT/PROTOCOL-TIER``; raises UnknownNameError, which suggests the nearest."""
    found = re.fullmatch(rf"([\w.+-]+)/({'|'.join(PROTOCOLS)})-([\w.+-]+)", key)
    if found is None or not (published_results() / key).is_dir():
        known = [path.relative_to(published_results()).as_posix() for path in published_results().glob("*/*/")]
        raise UnknownNameError("published board", key, known)
    split, protocol, tier = found.groups()
    return Board(split=split, protocol=protocol, tier=tier)


def _dataset(board: Board, record: BoardDataset, work: Path, jobs: int) -> Dataset:
    folder = dataset_folder(work, board.split, board.tier)
    if not (folder / INFO_FILE).is_file() or DatasetInfo.read(folder).id != record.id:
        if record.seed is None:
            raise VbbenchError(f"the truth of {board.key} is withheld; {record.advice}")
        generate(board.split, folder, source(board.split, board.tier).options(record.seed), jobs=jobs, overwrite=True)
    dataset = Dataset(folder)
    if dataset.info.id != record.id:
        raise VbbenchError(
            f"{folder} is dataset {dataset.info.id}, {board.key} stands on {record.id}: source files differ, or "
            "versions; see 'vbbench splits'"
        )
    return dataset
