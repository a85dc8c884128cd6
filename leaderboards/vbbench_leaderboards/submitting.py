"""What a submitter needs: a template of a solver, and adding a submission to the leaderboard."""

import re
from pathlib import Path
from typing import Any

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.scoring import score
from vbbench_leaderboards.results.about import About
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, record_path
from vbbench_leaderboards.results.folder import challenge_folder_of, published_results
from vbbench_leaderboards.results.result import Board, Result, write_result

TEMPLATE = Path(__file__).parent / "template"
"""The files that `copy_template` copies."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,39}")


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

    Parameters
    ----------
    about : facts of the row (`About`) that replace or complete what the submission declares.

    Raises
    ------
    VbbenchError
        If the submission has faults, belongs to another dataset than its board, already exists, or its name is not
        valid for a file; or if its row would not say all that every row must.
    """
    challenge = challenge_folder_of(results)
    if challenge is not None:
        raise VbbenchError(f"{results} belongs to the challenge in {challenge}; use 'vbbench challenge accept'")
    info, opened = SubmissionInfo.read(submission), Dataset(dataset, truth)
    solver = name or info.solver
    if not _NAME.fullmatch(solver):
        raise VbbenchError(
            f"'{solver}' cannot be the name of a result's file; give one with `name`: up to 40 letters, "
            "digits and . _ + -, beginning with a letter or digit"
        )
    if info.dataset != opened.info.id:
        raise VbbenchError(f"{submission} answers dataset {info.dataset}, {dataset} is {opened.info.id}; name its own")
    record = _record_of(opened, results)
    if record is not None and record.id != info.dataset:
        raise VbbenchError(
            f"{dataset} is dataset {info.dataset}, the boards of {record.split} {record.tier} hold results on "
            f"{record.id} alone; {record.advice}"
        )
    board = Board(split=opened.info.split, tier=opened.info.tier, protocol=info.protocol)
    path = results / board.key / f"{solver}.json"
    if path.exists() and not overwrite:
        raise VbbenchError(f"{path} exists; set `overwrite` to replace it, or give another `name`")
    _check_sums(opened)
    result = Result.of(score(submission, dataset, truth), submission, About.of(info, **about), name=solver)
    return write_result(result, results, record or BoardDataset.of(opened))


def _record_of(dataset: Dataset, results: Path) -> BoardDataset | None:
    """The record of a dataset's boards, in the folder or as published; ``None`` if there is none.

    A dataset whose truth is withheld is a challenge of its own, not one of the published boards.
    """
    path = record_path(dataset.info.split, dataset.info.tier)
    folders = [results] if dataset.info.seed is None else [results, published_results()]
    place = next((folder for folder in folders if (folder / path).is_file()), None)
    return None if place is None else read_dataset(place / path)


def _check_sums(dataset: Dataset) -> None:
    """Raise FileError at the first table, truth included, without the SHA-256 that ``dataset.json`` publishes."""
    for name, facts in dataset.info.tables.items():
        path = dataset.table_path(name)
        if not path.is_file():
            advice = (
                "name the folder that holds it with `truth`"
                if name.startswith("truth/")
                else "generate the dataset again"
            )
            raise FileError(path, f"the file is missing; {advice}")
        if file_sha256(path) != facts["sha256"]:
            raise FileError(path, "its SHA-256 is not the one in dataset.json; a result needs the published truth")


def copy_template(out: Path | str) -> list[Path]:
    """Copy the template into the folder ``out``, created if necessary; return the paths of the copies.

    Raises
    ------
    VbbenchError
        If ``out`` is a file, a dataset or a submission, or holds a changed file of the template.
    """
    out = Path(out)
    texts = {path.name: path.read_text("utf-8") for path in sorted(TEMPLATE.iterdir()) if path.is_file()}
    with loose_files(out):
        for path, text in ((out / name, text) for name, text in texts.items()):
            if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
                raise VbbenchError(f"{path} exists and may be yours; choose another folder")
        for name, text in texts.items():
            write_text_atomically(out / name, text)
    return [out / name for name in texts]
