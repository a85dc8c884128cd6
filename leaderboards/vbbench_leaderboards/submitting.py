"""What a submitter needs: a trial on a published board, and adding a submission."""

import re
from pathlib import Path
from typing import Any

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.submission import SubmissionInfo
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.protocol import PROTOCOLS
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench.solving.submissions import declared_facts
from vbbench_leaderboards.results.boards import source
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, record_path
from vbbench_leaderboards.results.folder import (
    challenge_folder_of,
    dataset_folder,
    published_results,
    read_results,
    submission_folder,
)
from vbbench_leaderboards.results.ranking import KINDS, headline, rank_apart
from vbbench_leaderboards.results.result import NEEDED, NOBODY_YET, About, Board, Result, write_result
from vbbench_leaderboards.results.sealed_json import SOLVER_NAME


def add(
    submission: Path,
    dataset: Path,
    results: Path,
    *,
    truth: Path | None = None,
    name: str = "",
    overwrite: bool = False,
    **about: Any,
) -> Path:
    """Score a submission and write its result file below ``results``; return its path.

    The first result of a split and tier writes the record of its dataset, too.

    Raises VbbenchError if the submission has faults, belongs to another dataset than its board, already exists, or its
    name is not valid for a file; or if its row would lack a fact that every row must have.

    Parameters
    ----------
    about : facts of the row (`About`) that replace or complete what the submission declares.
    """
    challenge = challenge_folder_of(results)
    if challenge is not None:
        raise VbbenchError(f"{results} belongs to the challenge in {challenge}; use 'vbbench challenge accept'")
    info, opened = SubmissionInfo.read(submission), Dataset(dataset, truth)
    solver = name or info.solver
    if not re.fullmatch(SOLVER_NAME, solver):
        rule = "up to 40 letters, digits and . _ + -, beginning with a letter or digit"
        raise VbbenchError(f"'{solver}' cannot be the name of a result's file; give one with `name`: {rule}")
    if info.dataset != opened.info.id:
        raise VbbenchError(f"{submission} answers dataset {info.dataset}, {dataset} is {opened.info.id}; name its own")
    record = _record_of(opened, results)
    if record is not None and record.id != info.dataset:
        alone = f"the boards of {record.split} {record.tier} hold results on {record.id} alone"
        raise VbbenchError(f"{dataset} is dataset {info.dataset}, {alone}; {record.advice}")
    board = Board(split=opened.info.split, tier=opened.info.tier, protocol=info.protocol)
    path = results / board.key / f"{solver}.json"
    if path.exists() and not overwrite:
        raise VbbenchError(f"{path} exists; set `overwrite` to replace it, or give another `name`")
    verify(dataset, truth)
    result = Result.of(score(submission, dataset, truth), submission, About.of(info, **about), name=solver)
    return write_result(result, results, record or BoardDataset.of(opened))


def _record_of(dataset: Dataset, results: Path) -> BoardDataset | None:
    """The record of a dataset's boards, in the folder or as published; ``None`` if there is none.

    A dataset whose truth is withheld is a challenge, not one of the published boards.
    """
    path = record_path(dataset.info.split, dataset.info.tier)
    folders = [results] if dataset.info.seed is None else [results, published_results()]
    place = next((folder for folder in folders if (folder / path).is_file()), None)
    return None if place is None else read_dataset(place / path)


TRIED = "tried"
"""Folder of the results that were tried, in the work folder: they are nobody's but yours."""


def try_solver(solver: str, board: str, work: Path, *, jobs: int = 1) -> str:
    """Make a published board's dataset, if it is not there, and solve and score it with a solver.

    Returns its place among the published results, for people; its result is in the folder `TRIED` of the work folder.
    Raises VbbenchError if the board is not published, or this machine makes another dataset.

    Parameters
    ----------
    solver : a registered name, or ``module:attribute``.
    board : ``SPLIT/PROTOCOL-TIER``.
    work : the work folder, laid out as that of ``vbbench leaderboard rerun``.
    jobs : processes.
    """
    wanted, name = parse_board(board), solver.rpartition(":")[2]
    _check_declared(solver)
    record = read_dataset(published_results() / record_path(wanted.split, wanted.tier))
    dataset = _dataset(wanted, record, work, jobs)
    answers = submission_folder(work, wanted, name)
    solve(dataset, solver, wanted.protocol, answers, jobs=jobs, overwrite=True)
    add(answers, dataset.folder, work / TRIED, name=name, overwrite=True)
    rows = read_results(work / TRIED, published_results())[wanted]
    own = next(result for result in rows if result.solver == name)
    place, figure = rank_apart(rows)["dx"].places[name], headline(own, "dx")
    between = "" if place.best == place.worst else f" (between {place.best} and {place.worst})"
    rivals = sum(result.group == own.group for result in rows)
    interval = "" if figure.low is None else f", 95 % interval {figure.low:.4f}–{figure.high:.4f}"
    where = f"{name} on {board}: rank {place.rank}{between} of {rivals} {KINDS[own.group]}"
    return f"{where}, Δx {figure.value:.4f} m{interval}"


def _check_declared(solver: str) -> None:
    """Raise VbbenchError if the solver's class lacks a fact that its row must have, before anything is made."""
    declared = declared_facts(solver)
    missing = [name for name in NEEDED if not declared.get(name, "").strip()]
    if missing:
        example = dict.fromkeys(NEEDED, "nothing") | {"authors": NOBODY_YET}
        words = f"{solver} does not say {', '.join(missing)}"
        raise VbbenchError(f"{words}; its class needs a line such as facts = {example}")


def parse_board(key: str) -> Board:
    """The published board of a key ``SPLIT/PROTOCOL-TIER``; raises UnknownNameError, which suggests the nearest."""
    found = re.fullmatch(rf"([\w.+-]+)/({'|'.join(PROTOCOLS)})-([\w.+-]+)", key)
    if found is None or not (published_results() / key).is_dir():
        known = [path.relative_to(published_results()).as_posix() for path in published_results().glob("*/*/")]
        of_split = [name for name in known if name.startswith(f"{key.partition('/')[0]}/")]
        raise UnknownNameError("published board", key, of_split or known)
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
        why = "source files differ, or versions; see 'vbbench splits'"
        raise VbbenchError(f"{folder} is dataset {dataset.info.id}, {board.key} stands on {record.id}: {why}")
    return dataset
