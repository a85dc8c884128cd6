"""What can be played: the splits whose datasets and submissions lie in a work folder."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench_leaderboards.result import Board, Result

Boards = Mapping[Board, tuple[Result, ...]]


@dataclass(frozen=True, kw_only=True)
class Playable:
    """What of a split can be played.

    Parameters
    ----------
    split : its name.
    boards : the boards whose dataset, with its truth, and submissions are at hand; those results alone.
    datasets : tier → dataset.
    """

    split: str
    boards: Boards
    datasets: Mapping[str, Dataset]


def submission_folder(work: Path, result: Result) -> Path:
    """Where the submission of a result lies in the work folder of ``vbbench leaderboard rerun``."""
    return work / "submissions" / result.board.folder / result.solver


def find_playable(work: Path, boards: Boards) -> Iterator[Playable]:
    """The splits of which something can be played.

    Raises
    ------
    VbbenchError
        If a dataset that lies there is not the one that the results are of.
    """
    for split in sorted({board.split for board in boards}):
        datasets: dict[str, Dataset] = {}
        kept: dict[Board, tuple[Result, ...]] = {}
        for board in sorted(board for board in boards if board.split == split):
            there = tuple(row for row in boards[board] if (submission_folder(work, row) / "submission.json").is_file())
            dataset = datasets.get(board.tier) or _opened(work, board)
            if dataset is not None and there:
                _check_same(dataset, there)
                datasets[board.tier], kept[board] = dataset, there
        if kept:
            yield Playable(split=split, boards=kept, datasets=datasets)


def _opened(work: Path, board: Board) -> Dataset | None:
    folder = work / "datasets" / f"{board.split}-{board.tier}"
    dataset = Dataset(folder) if (folder / "dataset.json").is_file() else None
    return dataset if dataset is not None and dataset.has_truth else None


def _check_same(dataset: Dataset, results: tuple[Result, ...]) -> None:
    for result in results:
        if result.dataset != dataset.info.id:
            raise VbbenchError(
                f"{dataset.folder} is dataset {dataset.info.id}, {result.path} is of {result.dataset}; "
                "run 'vbbench leaderboard rerun' again, or build without --work"
            )
