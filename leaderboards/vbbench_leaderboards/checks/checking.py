"""Checks a folder of results: every file, and all faults of all files at once."""

import contextlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.parallel.parts import progress_bar
from vbbench.scoring import score
from vbbench_leaderboards.checks.drift import drift, record_faults
from vbbench_leaderboards.checks.recount import count_faults, summary_faults
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.folder import read_datasets, read_results, record_paths, result_paths
from vbbench_leaderboards.results.history import history_faults
from vbbench_leaderboards.results.result import Result, table_hashes


class ResultsError(VbbenchError):
    """Result files with faults; every one of them is listed."""

    def __init__(self, results: Path, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        listing = (f"  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        super().__init__(f"{results}: {_count(len(self.faults), 'fault')}", *listing)


def check(
    results: Path, *, work: Path | None = None, datasets: Sequence[Path] = (), submissions: Sequence[Path] = ()
) -> str:
    """Check every file below ``results``; return what was checked, as one line of text.

    Parameters
    ----------
    work : work folder of ``rerun``; results whose submission is there, or is named, are scored again.
    datasets, submissions : more folders to score again with.

    Raises
    ------
    ResultsError
        With every fault of every file.
    """
    unusable: list[FileError] = []
    records = read_datasets(results, unusable=unusable)
    boards = read_results(results, records=records, unusable=unusable)
    usable = [result for rows in boards.values() for result in rows]
    at_hand = _datasets_at_hand(work, datasets)
    faults = [*_misplaced(results), *map(str, unusable)]
    for record in records.values():
        again = record_faults(record, at_hand[record.id]) if record.id in at_hand else ()
        faults += [f"{results / record.path}: {fault}" for fault in (*_contradictions(record), *again)]
    for result in usable:
        record = records[result.board.split, result.board.tier]
        own = (*count_faults(result, record), *history_faults(result.history, result.about.date))
        faults += [f"{results / result.path}: {fault}" for fault in own]
    faults += [f"{results / result.path}: {fault}" for result, fault in summary_faults(usable)]
    faults += _unmatched(usable, submissions, at_hand)
    rescored = list(_rescored(usable, _submissions_at_hand(work, submissions), at_hand))
    for result, found in rescored:
        faults += [f"{results / result.path}: scores differently now: {fault}" for fault in found]
    if faults:
        raise ResultsError(results, faults)
    counts = f"{_count(len(usable), 'result')} on {_count(len(boards), 'board')}"
    return f"{results}: {counts} checked, no faults; {len(rescored)} scored again"


def _misplaced(results: Path) -> Iterator[str]:
    """Misplaced JSON files, names that are equal on some disks, or an empty folder."""
    placed = {*record_paths(results), *result_paths(results)}
    if not placed:
        yield f"{results}: no result is here; vbbench leaderboard add writes them"
    for path in sorted(path.relative_to(results) for path in results.rglob("*.json")):
        if path not in placed:
            yield f"{results / path}: is neither where a result nor where a record belongs; move or remove it"
    names = defaultdict(list)
    for path in sorted(placed):
        names[str(path).casefold()].append(path)
    for _, *others in names.values():
        for path in others:
            yield f"{results / path}: differs from another file only in capitals; rename one"


def _contradictions(record: BoardDataset) -> Iterator[str]:
    """Where a record contradicts itself."""
    counts, own = record.counts, {"id": record.id, "split": record.split, "tier": record.tier}
    for name, value in {**own, "camera": record.camera["kind"]}.items():
        if counts[name] != value:
            yield f"$.counts.{name}: is {counts[name]!r}, the record is of {value!r}"
    for protocol, part in record.scored.items():
        ascending = bool((part.sequence[1:] > part.sequence[:-1]).all())
        if not ascending or part.sequence[-1] >= counts["sequences"] or part.frames.min() < 1:
            yield f"$.scored.{protocol}: is not a list of the dataset's scored sequences"


def _datasets_at_hand(work: Path | None, named: Sequence[Path]) -> dict[str, Path]:
    """Dataset folders by id: those named, and those of the work folder that can be read."""
    found = {}
    for path in sorted(work.glob(f"datasets/*/{INFO_FILE}")) if work else []:
        with contextlib.suppress(VbbenchError):
            found[DatasetInfo.read(path.parent).id] = path.parent
    return found | {DatasetInfo.read(folder).id: folder for folder in named}


def _submissions_at_hand(work: Path | None, named: Sequence[Path]) -> list[Path]:
    """Submission folders: those named, and those of the work folder."""
    below = sorted(work.glob(f"submissions/*/*/*/{SUBMISSION_FILE}")) if work else []
    return [*named, *(path.parent for path in below if not path.parent.suffix)]


def _rescored(
    results: Sequence[Result], submissions: Iterable[Path], datasets: dict[str, Path]
) -> Iterator[tuple[Result, list[str]]]:
    """Results whose submission and dataset are available, with what scores differently now."""
    pairs = [
        (result, folder) for folder in submissions for result in _made_of(folder, results) if result.dataset in datasets
    ]
    with progress_bar(len(pairs), "score again", unit="result") as bar:
        for result, folder in pairs:
            yield result, _differences(result, folder, datasets[result.dataset])
            bar.update()


def _unmatched(results: Sequence[Result], named: Iterable[Path], datasets: dict[str, Path]) -> Iterator[str]:
    """Why a named submission cannot be scored again."""
    for folder in named:
        found = _made_of(folder, results)
        if not found:
            yield f"{folder}: no result has its tables; add it with 'vbbench leaderboard add'"
        elif not any(result.dataset in datasets for result in found):
            yield f"{folder}: its dataset {found[0].dataset} is not available; name its folder, too"


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
        again = score(folder, dataset, sequences=result.per_sequence.sequence)
        fresh = Result.of(again, folder, result.about, name=result.solver)
    except VbbenchError as error:
        return [f"{folder} cannot be scored again: {error}"]
    return drift(result, fresh)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
