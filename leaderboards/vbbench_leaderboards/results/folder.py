"""A folder of results: every board's result files, and the record of each split and tier's dataset."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path

from vbbench.errors import FileError
from vbbench_leaderboards.results.boards import seen_by
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, record_path
from vbbench_leaderboards.results.result import Board, Result, read_result

Records = Mapping[tuple[str, str], BoardDataset]
"""The records of datasets, by split and tier."""

Boards = Mapping[Board, tuple[Result, ...]]
"""Results by board, of each board by solver."""

HERE = Path(__file__).parents[1]

CHALLENGE_FILE = "challenge.toml"
"""What makes a folder that of a challenge; its results lie below it."""


def published_results() -> Path:
    """The results that come with vbbench: in the wheel they lie in the package, in a checkout next to it."""
    inside = HERE / "published"
    return inside if inside.is_dir() else HERE.parent / "results"


def published_dataset(split: str, tier: str) -> str | None:
    """The id of the dataset that vbbench publishes results on; ``None`` if it has no boards of the split and tier.

    Raises FileError if its record cannot be used.
    """
    path = published_results() / record_path(split, tier)
    return _id_of(path) if path.is_file() else None


@cache
def _id_of(record: Path) -> str:
    return read_dataset(record).id


def challenge_folder_of(results: Path) -> Path | None:
    """The folder of the challenge that a folder of results belongs to; ``None`` if it belongs to none."""
    places = [results, *results.absolute().parents[:2]]
    return next((place for place in places if (place / CHALLENGE_FILE).is_file()), None)


def result_paths(results: Path) -> Iterator[Path]:
    """Paths of all result files, in order, relative to the folder."""
    yield from sorted(path.relative_to(results) for path in results.glob("*/*/*.json"))


def record_paths(results: Path) -> Iterator[Path]:
    """Paths of all dataset records, in order, relative to the folder."""
    yield from sorted(path.relative_to(results) for path in results.glob("*/*.json"))


def dataset_folder(work: Path, split: str, tier: str) -> Path:
    """Where a dataset lies in the work folder of ``vbbench leaderboard rerun``."""
    return work / "datasets" / f"{split}-{tier}"


def submission_folder(work: Path, board: Board, solver: str) -> Path:
    """Where a solver's submission lies in the work folder of ``vbbench leaderboard rerun``."""
    return work / "submissions" / board.key / solver


def read_results(*folders: Path, records: Records | None = None, unusable: list[FileError] | None = None) -> Boards:
    """Results by board, of each board by solver; of a result in several folders the first counts.

    Raises FileError without ``unusable``: if a file cannot be used, lies where it does not belong, or is made on
    another dataset than its board's.

    Parameters
    ----------
    records : the datasets of the boards, where they have been read already.
    unusable : takes what is wrong with each file that is omitted. Results whose record is there and cannot be used
        are omitted with it.
    """
    if records is None:
        records = read_datasets(*folders, unusable=unusable)
    boards: dict[Board, dict[str, Result]] = defaultdict(dict)
    for folder in folders:
        for path in result_paths(folder):
            with _omitting(unusable):
                result = read_result(folder / path)
                if _is_placed(result, records, folder, path):
                    result = replace(result, seen=seen_by(result.about, result.board.split))
                    boards[result.board].setdefault(result.solver, result)
    return {board: tuple(found[name] for name in sorted(found)) for board, found in sorted(boards.items())}


def read_datasets(*folders: Path, unusable: list[FileError] | None = None) -> Records:
    """Dataset records by split and tier; of a record in several folders the first counts.

    Raises FileError without ``unusable``: if a file cannot be used, lies where it does not belong, or two folders hold
    different datasets.

    Parameters
    ----------
    unusable : takes what is wrong with each file that is omitted.
    """
    records: dict[tuple[str, str], BoardDataset] = {}
    for folder in folders:
        for path in record_paths(folder):
            with _omitting(unusable):
                record = read_dataset(folder / path)
                if path != record.path:
                    raise FileError(folder / path, f"holds the record that belongs in {record.path}; move it there")
                first = records.setdefault((record.split, record.tier), record)
                if record.id != first.id:
                    others = f"is of dataset {record.id}, results of {first.id} stand next to it"
                    way_out = "they cannot be on one page, name one folder with --results"
                    raise FileError(folder / path, f"{others}; {way_out}")
    return dict(sorted(records.items()))


@contextmanager
def _omitting(unusable: list[FileError] | None) -> Iterator[None]:
    """Omit a file with a fault, where its fault can be listed."""
    try:
        yield
    except FileError as error:
        if unusable is None:
            raise
        unusable.append(error)


def _is_placed(result: Result, records: Records, folder: Path, path: Path) -> bool:
    """Whether the record of a result's board can be used; FileError if the result is not the one that belongs there."""
    board = result.board
    record, its_path = records.get((board.split, board.tier)), record_path(board.split, board.tier)
    if record is None and (folder / its_path).is_file():
        return False
    if path != result.path:
        raise FileError(folder / path, f"holds the result that belongs in {result.path}; move it there")
    if record is None:
        raise FileError(folder / path, f"has no dataset record {its_path}; add the result again, which writes it")
    if result.dataset != record.id:
        wanted = f"everything on this board is made on {record.id}; {record.advice}"
        raise FileError(folder / path, f"$.dataset.id: is {result.dataset}, {wanted}")
    return True
