"""Scores the submissions at hand again, for the results that were made of them."""

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from vbbench.dataset import Dataset
from vbbench.dataset_info import INFO_FILE, DatasetInfo
from vbbench.errors import VbbenchError
from vbbench.parts import progress_bar
from vbbench.scoring import score
from vbbench.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench_leaderboards.submitting import table_hashes
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.checks.drift import drift
from vbbench_leaderboards.results.result import Result


def datasets_at_hand(work: Path | None, named: Sequence[Path]) -> dict[str, Path]:
    """Dataset folders by id: those named, and those of the work folder that can be read."""
    found = {}
    for path in sorted(work.glob(f"datasets/*/{INFO_FILE}")) if work else []:
        with contextlib.suppress(VbbenchError):
            found[DatasetInfo.read(path.parent).id] = path.parent
    return found | {DatasetInfo.read(folder).id: folder for folder in named}


def submissions_at_hand(work: Path | None, named: Sequence[Path]) -> list[Path]:
    """Submission folders: those named, and those of the work folder."""
    below = sorted(work.glob(f"submissions/*/*/*/{SUBMISSION_FILE}")) if work else []
    return [*named, *(path.parent for path in below if not path.parent.suffix)]


def rescored(
    results: Sequence[Result], submissions: Iterable[Path], datasets: dict[str, Path]
) -> Iterator[tuple[Result, list[str]]]:
    """Results whose submission and dataset are at hand, with what scores differently now."""
    pairs = [
        (result, folder) for folder in submissions for result in _made_of(folder, results) if result.dataset in datasets
    ]
    with progress_bar(len(pairs), "score again", unit="result") as bar:
        for result, folder in pairs:
            yield result, _differences(result, folder, datasets[result.dataset])
            bar.update()


def unmatched(results: Sequence[Result], named: Iterable[Path], datasets: dict[str, Path]) -> Iterator[str]:
    """Why a submission that was named cannot be scored again."""
    for folder in named:
        found = _made_of(folder, results)
        if not found:
            yield f"{folder}: no result is made of its tables; add it with 'vbbench leaderboard add'"
        elif not any(result.dataset in datasets for result in found):
            yield f"{folder}: its dataset {found[0].dataset} is not at hand; name its folder with --dataset"


def record_faults(record: BoardDataset, folder: Path) -> Iterator[str]:
    """What a dataset that is at hand says otherwise than its record.

    The bytes of tables depend on the library that wrote them; they must agree only where truth is withheld. There the
    seed may have been told since.
    """
    opened = Dataset(folder)
    if not opened.has_truth:
        return
    fresh, loose = BoardDataset.of(opened), ("tables",) if record.seed is not None else ("seed", "command")
    for name, value in vars(fresh).items():
        if name == "scored":
            yield from _scored_faults(record, fresh, folder)
        elif value != vars(record)[name] and name not in loose:
            yield f"$.{name}: is {vars(record)[name]!r}, {folder} gives {value!r}"


def _scored_faults(record: BoardDataset, fresh: BoardDataset, folder: Path) -> Iterator[str]:
    for protocol, wanted in fresh.scored.items():
        for column, numbers in vars(wanted).items():
            if not np.array_equal(getattr(record.scored[protocol], column), numbers):
                yield f"$.scored.{protocol}: {column} are not those that {folder} gives"


def _made_of(folder: Path, results: Sequence[Result]) -> list[Result]:
    try:
        hashes, info = table_hashes(folder), SubmissionInfo.read(folder)
    except VbbenchError:
        return []
    return [
        result
        for result in results
        if result.submission == hashes and (result.dataset, result.board.protocol) == (info.dataset, info.protocol)
    ]


def _differences(result: Result, folder: Path, dataset: Path) -> list[str]:
    try:
        fresh = Result.of(score(folder, dataset), {}, name=result.solver)
    except VbbenchError as error:
        return [f"{folder} cannot be scored again: {error}"]
    return drift(result, fresh)
