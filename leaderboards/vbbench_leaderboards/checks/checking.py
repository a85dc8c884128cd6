"""Checks a folder of results: every file, and all faults of all files at once."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar

from vbbench.errors import FileError, VbbenchError
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, record_path
from vbbench_leaderboards.checks.recount import count_faults, summary_faults
from vbbench_leaderboards.checks.rescoring import (
    datasets_at_hand,
    record_faults,
    rescored,
    submissions_at_hand,
    unmatched,
)
from vbbench_leaderboards.results.result import Result
from vbbench_leaderboards.results.result import read_result
from vbbench_leaderboards.results.folder import (
    Records,
    check_place,
    check_record_place,
    record_paths,
    result_paths,
)

Read = TypeVar("Read")


class ResultsError(VbbenchError):
    """Result files with faults; every one of them is listed."""

    def __init__(self, results: Path, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        listing = "".join(f"\n  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        super().__init__(f"{results}: {count}{listing}")


def check(
    results: Path, *, work: Path | None = None, datasets: Sequence[Path] = (), submissions: Sequence[Path] = ()
) -> str:
    """Check every file below ``results``; return what was checked, as one line of text.

    Parameters
    ----------
    work : work folder of ``rerun``; results whose submission lies there, or is named, are scored again.
    datasets, submissions : more folders to score again with.

    Raises
    ------
    ResultsError
        With every fault of every file.
    """
    folder = _Folder(results)
    folder.read()
    for result in folder.results:
        for fault in count_faults(result, folder.records[result.board.split, result.board.tier]):
            folder.add(result.path, fault)
    for result, fault in summary_faults(folder.results):
        folder.add(result.path, fault)
    again = folder.score_again(work, datasets, submissions)
    if folder.faults:
        raise ResultsError(results, folder.faults)
    boards = len({result.board for result in folder.results})
    counts = f"{_count(len(folder.results), 'result')} on {_count(boards, 'board')}"
    return f"{results}: {counts} checked, all as it should be; {again} scored again"


class _Folder:
    """The files of a folder of results that can be read, and the faults found so far."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.records: Records = {}
        self.results: list[Result] = []
        self.faults: list[str] = []

    def add(self, path: Path, fault: str) -> None:
        self.faults.append(f"{self.folder / path}: {fault}")

    def read(self) -> None:
        """Read every file and check that it lies where it belongs."""
        records, results = list(record_paths(self.folder)), list(result_paths(self.folder))
        if not (results or records):
            self.faults.append(f"{self.folder}: no result is here; vbbench leaderboard add writes them")
        self._find_strays({*records, *results})
        for path in records:
            record = self._attempt(read_dataset, self.folder / path)
            if record is not None and self._is_placed(check_record_place, record, self.folder, path):
                self.records[record.split, record.tier] = record
                self._check_record(record)
        for path in results:
            result = self._attempt(read_result, self.folder / path)
            if result is None or self._lost_record(result):
                continue
            if self._is_placed(check_place, result, self.records, self.folder, path):
                self.results.append(result)

    def score_again(self, work: Path | None, datasets: Sequence[Path], submissions: Sequence[Path]) -> int:
        """Score the submissions at hand again; return how many results that were."""
        at_hand = datasets_at_hand(work, datasets)
        for record in self.records.values():
            if record.id in at_hand:
                for fault in record_faults(record, at_hand[record.id]):
                    self.add(record.path, fault)
        self.faults += unmatched(self.results, submissions, at_hand)
        again = 0
        for result, found in rescored(self.results, submissions_at_hand(work, submissions), at_hand):
            again += 1
            for fault in found:
                self.add(result.path, f"scores differently now: {fault}")
        return again

    def _find_strays(self, placed: set[Path]) -> None:
        """JSON files where none belongs, and names that are one and the same on some disks."""
        for path in sorted(path.relative_to(self.folder) for path in self.folder.rglob("*.json")):
            if path not in placed:
                self.add(path, "lies where no result and no record does; move or remove it")
        names = defaultdict(list)
        for path in sorted(placed):
            names[str(path).casefold()].append(path)
        for _, *others in names.values():
            for path in others:
                self.add(path, "has the name of another file but for capitals; rename one")

    def _check_record(self, record: BoardDataset) -> None:
        counts, own = record.counts, {"id": record.id, "split": record.split, "tier": record.tier}
        for name, value in {**own, "camera": record.camera["kind"]}.items():
            if counts[name] != value:
                self.add(record.path, f"$.counts.{name}: is {counts[name]!r}, the record is of {value!r}")
        for protocol, part in record.scored.items():
            ascending = bool((part.sequence[1:] > part.sequence[:-1]).all())
            if not ascending or part.sequence[-1] >= counts["sequences"] or part.frames.min() < 1:
                self.add(record.path, f"$.scored.{protocol}: is no list of the dataset's scored sequences")

    def _lost_record(self, result: Result) -> bool:
        """Whether the record of the result's board is there and has faults, which are listed once."""
        split, tier = result.board.split, result.board.tier
        return (split, tier) not in self.records and (self.folder / record_path(split, tier)).is_file()

    def _attempt(self, read: Callable[[Path], Read], path: Path) -> Read | None:
        try:
            return read(path)
        except FileError as error:
            self.faults.append(str(error))
            return None

    def _is_placed(self, check: Callable[..., None], *arguments: object) -> bool:
        try:
            check(*arguments)
        except FileError as error:
            self.faults.append(str(error))
            return False
        return True


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
