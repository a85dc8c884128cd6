"""A folder of results: every board's result files, and the record of each split and tier's dataset."""

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vbbench.errors import FileError
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.result import read_result

Records = dict[tuple[str, str], BoardDataset]


def published_results() -> Path:
    """The results that come with vbbench: in the wheel they lie in the package, in a checkout beside it."""
    inside = Path(__file__).parent / "results"
    return inside if inside.is_dir() else Path(__file__).parents[1] / "results"


def result_paths(results: Path) -> Iterator[Path]:
    """Paths of all result files, in order, relative to the folder."""
    yield from sorted(path.relative_to(results) for path in results.glob("*/*/*.json"))


def record_paths(results: Path) -> Iterator[Path]:
    """Paths of all dataset records, in order, relative to the folder."""
    yield from sorted(path.relative_to(results) for path in results.glob("*/*.json"))


def read_results(
    *folders: Path, records: Records | None = None, unusable: list[FileError] | None = None
) -> dict[Board, tuple[Result, ...]]:
    """Results by board, of each board by solver; of a result in several folders the first counts.

    Parameters
    ----------
    records : the datasets of the boards, where they have been read already.
    unusable : takes what is wrong with each file that is left out.

    Raises
    ------
    FileError
        Without ``unusable``: if a file cannot be used, lies where it does not belong, or is made on another dataset
        than its board's.
    """
    if records is None:
        records = read_datasets(*folders, unusable=unusable)
    boards: dict[Board, dict[str, Result]] = defaultdict(dict)
    for folder in folders:
        for path in result_paths(folder):
            with _leaving_out(unusable):
                result = read_result(folder / path)
                check_place(result, records, folder, path)
                boards[result.board].setdefault(result.solver, result)
    return {board: tuple(found[name] for name in sorted(found)) for board, found in sorted(boards.items())}


def read_datasets(*folders: Path, unusable: list[FileError] | None = None) -> Records:
    """Dataset records by split and tier; of a record in several folders the first counts.

    Parameters
    ----------
    unusable : takes what is wrong with each file that is left out.

    Raises
    ------
    FileError
        Without ``unusable``: if a file cannot be used, lies where it does not belong, or two folders hold different
        datasets.
    """
    records: Records = {}
    for folder in folders:
        for path in record_paths(folder):
            with _leaving_out(unusable):
                record = read_dataset(folder / path)
                check_record_place(record, folder, path)
                first = records.setdefault((record.split, record.tier), record)
                if record.id != first.id:
                    raise FileError(
                        folder / path,
                        f"is of dataset {record.id}, results of {first.id} stand beside it; they cannot be on one "
                        "page, name one folder with --results",
                    )
    return dict(sorted(records.items()))


@contextmanager
def _leaving_out(unusable: list[FileError] | None) -> Iterator[None]:
    """Leave a file with a fault out, where there is somewhere to say so."""
    try:
        yield
    except FileError as error:
        if unusable is None:
            raise
        unusable.append(error)


def check_place(result: Result, records: Records, folder: Path, path: Path) -> None:
    """Raise FileError if a result's file is not its board's, or its dataset is not the record's."""
    board = result.board
    if path != result.path:
        raise FileError(folder / path, f"holds the result that belongs in {result.path}; move it there")
    record = records.get((board.split, board.tier))
    if record is None:
        raise FileError(
            folder / path,
            f"has no dataset record {board.split}/{board.tier}.json; add the result anew, which writes it",
        )
    if result.dataset != record.id:
        raise FileError(
            folder / path,
            f"$.dataset.id: is {result.dataset}, everything on this board is made on {record.id}; {record.way}",
        )


def check_record_place(record: BoardDataset, folder: Path, path: Path) -> None:
    """Raise FileError if a record's file is not where its split and tier belong."""
    if path != record.path:
        raise FileError(folder / path, f"holds the record that belongs in {record.path}; move it there")
