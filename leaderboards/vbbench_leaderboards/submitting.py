"""Adds a submission to the leaderboard: scored, checked against the board's dataset, written as one file."""

import re
from pathlib import Path
from vbbench.dataset import Dataset
from vbbench.errors import FileError, VbbenchError
from vbbench.scoring import score
from vbbench.submission import SubmissionInfo
from vbbench.tables import file_sha256, write_text_atomically
from vbbench_leaderboards.results.dataset_record import (
    BoardDataset,
    check_same_dataset,
    read_dataset,
    record_path,
    write_dataset,
)
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.result import result_text
from vbbench_leaderboards.results.folder import published_results
from pathlib import Path
from vbbench.errors import VbbenchError
from vbbench.tables import loose_files, write_text_atomically

# DOC """A folder to begin a solver in: copies of the files that lie in ``template`` beside this module."""
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,39}")
_LINK = re.compile(r"(https?://[^\s<>\"']{1,492})?")


def add(
    submission: Path,
    dataset: Path,
    results: Path,
    *,
    truth: Path | None = None,
    name: str = "",
    reference: str = "",
    link: str = "",
    overwrite: bool = False,
) -> Path:
    """Score a submission and write its result file below ``results``; return its path.

    The first result of a split and tier writes the record of its dataset, too.

    Raises
    ------
    VbbenchError
        If the submission has faults, is made on another dataset than its board's, is there already, or its name
        cannot be a file's.
    """
    info, opened = SubmissionInfo.read(submission), Dataset(dataset, truth)
    solver, link = _checked_name(name or info.solver), _checked_link(link)
    if info.dataset != opened.info.id:
        raise VbbenchError(f"{submission} answers dataset {info.dataset}, {dataset} is {opened.info.id}; name its own")
    record = board_dataset(opened, results)
    if record is not None:
        check_same_dataset(record, opened.info.id, dataset)
        check_same_dataset(record, info.dataset, submission)
    board = Board(split=opened.info.split, tier=opened.info.tier, protocol=info.protocol)
    path = results / board.folder / f"{solver}.json"
    if path.exists() and not overwrite:
        raise VbbenchError(f"{path} exists; add --overwrite to replace it, or give another --name")
    check_sums(opened)
    judged = score(submission, dataset, truth)
    result = Result.of(judged, table_hashes(submission), name=solver, reference=reference, link=link)
    text = result_text(result, results)
    if not (results / record_path(opened.info.split, opened.info.tier)).is_file():
        write_dataset(record or BoardDataset.of(opened), results)  # first: no result is without its record
    write_text_atomically(path, text)
    return path


def board_dataset(dataset: Dataset, results: Path) -> BoardDataset | None:
    """The record of the boards that a dataset is for, of the folder or as published; ``None`` if there is none.

    A dataset whose truth is withheld is a challenge of its own, not one of the published boards.
    """
    path = record_path(dataset.info.split, dataset.info.tier)
    folders = [results] if dataset.info.seed is None else [results, published_results()]
    place = next((folder for folder in folders if (folder / path).is_file()), None)
    return None if place is None else read_dataset(place / path)


def check_sums(dataset: Dataset) -> None:
    """Check that every table, the truth's too, has the SHA-256 that ``dataset.json`` publishes.

    Raises
    ------
    FileError
        At the first that has not.
    """
    for name, facts in dataset.info.tables.items():
        path = dataset.table_path(name)
        if not path.is_file():
            where = "; name the folder that holds it with --truth" if name.startswith("truth/") else ""
            raise FileError(path, f"the file is missing{where or '; generate the dataset again'}")
        if file_sha256(path) != facts["sha256"]:
            raise FileError(path, "its SHA-256 is not the one in dataset.json; a result needs the published truth")


def table_hashes(submission: Path) -> dict[str, str]:
    """File name → SHA-256 of a submission's tables."""
    names = (f"{table}.{kind}" for table in ("poses", "positions") for kind in ("parquet", "csv"))
    return {name: file_sha256(submission / name) for name in names if (submission / name).is_file()}


def _checked_name(name: str) -> str:
    if not _NAME.fullmatch(name):
        raise VbbenchError(
            f"'{name}' cannot be the name of a result's file; give one with --name: up to 40 letters, "
            "digits and . _ + -, beginning with a letter or digit"
        )
    return name


def _checked_link(link: str) -> str:
    if not _LINK.fullmatch(link):
        raise VbbenchError(f"--link {link} is no address; give one that begins with https:// or http://")
    return link


TEMPLATE = Path(__file__).parent / "template"


def copy_template(out: Path | str) -> list[Path]:
    """Copy the template into the folder ``out``, made if need be; return the paths of the copies.

    Raises
    ------
    VbbenchError
        If ``out`` is a file, a dataset or a submission, or a file of the template is there already.
    """
    out = Path(out)
    texts = {path.name: path.read_text("utf-8") for path in sorted(TEMPLATE.iterdir()) if path.is_file()}
    with loose_files(out):
        there = [name for name, text in texts.items() if not _is_free(out / name, text)]
        if there:
            raise VbbenchError(f"{out / there[0]} exists and may be yours; choose another folder")
        for name, text in texts.items():
            write_text_atomically(out / name, text)
    return [out / name for name in texts]


def _is_free(path: Path, text: str) -> bool:
    """Whether nothing is there, or the very copy, of a command that was stopped."""
    return not path.exists() or (path.is_file() and path.read_bytes() == text.encode())
