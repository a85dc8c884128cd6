"""What can be played: the splits that lie in a work folder, which of their sequences, and the index that says so."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import Known
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.submission import SUBMISSION_FILE
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.people_colours import ON_DARK, ON_LIGHT
from vbbench.protocol import get_protocol
from vbbench_leaderboards.results.boards import HEADLINE_TIER
from vbbench_leaderboards.results.folder import Boards, dataset_folder, submission_folder
from vbbench_leaderboards.results.result import Board, Result

_REFERENCES = (("sequential", HEADLINE_TIER), ("sequential", "noisy"), ("sequential", "ideal"))
"""Protocol and tier by whose errors sequences are chosen: the first of them that has results, or else any board."""

_CHOSEN_BY = ("dx", "dx_rel", "dt")
"""Figures by which sequences are chosen: the first that the truth allows."""

_INDEXED = ("dx", "dt")
_CAPPED = ("dx", "dt", "dr")
_DIGITS = 4


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
            there = tuple(row for row in boards[board] if _has_submission(work, row))
            dataset = datasets.get(board.tier) or _opened(work, board)
            if dataset is not None and there:
                _check_same(dataset, there)
                datasets[board.tier], kept[board] = dataset, there
        if kept:
            yield Playable(split=split, boards=kept, datasets=datasets)


def _has_submission(work: Path, result: Result) -> bool:
    return (submission_folder(work, result.board, result.solver) / SUBMISSION_FILE).is_file()


def _opened(work: Path, board: Board) -> Dataset | None:
    folder = dataset_folder(work, board.split, board.tier)
    dataset = Dataset(folder) if (folder / INFO_FILE).is_file() else None
    return dataset if dataset is not None and dataset.has_truth else None


def _check_same(dataset: Dataset, results: tuple[Result, ...]) -> None:
    for result in results:
        if result.dataset != dataset.info.id:
            raise VbbenchError(
                f"{dataset.folder} is dataset {dataset.info.id}, {result.path} is of {result.dataset}; "
                "run 'vbbench leaderboard rerun' again, or build without --work"
            )


def choose_sequences(results: Boards, count: int, available: int) -> IntArray:
    """Numbers of at most ``count`` sequences, ascending, for all boards of a split.

    They lie evenly over the order of the middle solver's Δx, or where that is not known Δx̃ or Δt; the smallest and the
    largest are among them.

    Parameters
    ----------
    results : the boards of one split.
    count : how many are wanted.
    available : number of sequences in the dataset.
    """
    rows = results[_reference(results)]
    metric = next((name for name in _CHOSEN_BY if _mean(rows[0], name) is not None), _CHOSEN_BY[0])
    own = _middle(rows, metric).per_sequence
    usable = np.isfinite(own.figures[metric]) & (own.sequence < available)
    numbers, errors = own.sequence[usable], own.figures[metric][usable]
    ranked = numbers[np.lexsort((numbers, errors))]
    places = np.unique(np.rint(np.linspace(0, len(ranked) - 1, min(count, len(ranked)))).astype(np.int64))
    return np.sort(ranked[places])


def _reference(results: Boards) -> Board:
    boards = sorted(results)
    for protocol, tier in _REFERENCES:
        found = [board for board in boards if (board.protocol, board.tier) == (protocol, tier) and results[board]]
        if found:
            return found[0]
    return next(board for board in boards if results[board])


def _middle(results: tuple[Result, ...], metric: str) -> Result:
    """The result in the middle of the table; of two, the better."""
    ranked = sorted(results, key=lambda result: (_mean(result, metric) or 0.0, result.solver))
    return ranked[(len(ranked) - 1) // 2]


def _mean(result: Result, metric: str) -> float | None:
    mean: float | None = result.score["metrics"][metric]["mean"]
    return mean


def split_index(playable: Playable, chosen: IntArray, pictures: Mapping[str, int]) -> dict[str, Any]:
    """The index as the page gets it.

    Parameters
    ----------
    playable : the split.
    chosen : [S] numbers of its sequences.
    pictures : sequence → how many pictures of it there are.
    """
    dataset = next(iter(playable.datasets.values()))
    known = dataset.info.truth
    boards = {
        f"{board.protocol}-{board.tier}": {
            "tier": board.tier,
            "given": get_protocol(board.protocol).given,
            "caps": {name: get_protocol(board.protocol).caps[name] for name in _CAPPED},
            "solvers": {row.solver: _figures(row, chosen, known) for row in rows},
        }
        for board, rows in playable.boards.items()
    }
    palette = {"light": ON_LIGHT, "dark": ON_DARK}
    facts = {"split": playable.split, "truth": known, "palette": palette, **_facts(dataset, chosen)}
    return {**facts, "pictures": dict(pictures), "boards": boards}


def _facts(dataset: Dataset, chosen: IntArray) -> dict[str, list[int]]:
    columns = {"sequences": "sequence", "frames": "frames", "people": "people"}
    return {name: dataset.rows[column][chosen].tolist() for name, column in columns.items()}


def _figures(result: Result, chosen: IntArray, known: Known) -> dict[str, list[float | None]]:
    """A solver's figures in the chosen sequences, None where it has none; seen from the camera, Δx̃ stands for Δx."""
    own = result.per_sequence
    place = np.searchsorted(own.sequence, chosen).clip(max=len(own.sequence) - 1)
    there = own.sequence[place] == chosen
    source = {"dx": "dx_rel"} if known == "relative" else {}
    found = {name: own.figures[source.get(name, name)][place] for name in _INDEXED}
    return {name: _rounded(np.where(there, values, np.nan)) for name, values in found.items()}


def _rounded(values: FloatArray) -> list[float | None]:
    return [round(float(value), _DIGITS) if np.isfinite(value) else None for value in values]
