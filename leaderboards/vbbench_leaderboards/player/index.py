"""The index of a split: which sequences, boards and solvers can be played, and how well each solver did."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import get_protocol
from vbbench_leaderboards.player.playable import Playable
from vbbench_leaderboards.result import Result

_METRICS = ("dx", "dt")
_DIGITS = 4


def split_index(playable: Playable, chosen: IntArray, pictures: Mapping[str, int]) -> dict[str, Any]:
    """The index as the page gets it.

    Parameters
    ----------
    playable : the split.
    chosen : [S] numbers of its sequences.
    pictures : sequence → how many pictures of it there are.
    """
    boards = {
        f"{board.protocol}-{board.tier}": {
            "tier": board.tier,
            "given": get_protocol(board.protocol).given,
            "solvers": {row.solver: _figures(row, chosen) for row in rows},
        }
        for board, rows in playable.boards.items()
    }
    dataset = next(iter(playable.datasets.values()))
    return {"split": playable.split, **_facts(dataset, chosen), "pictures": dict(pictures), "boards": boards}


def _facts(dataset: Dataset, chosen: IntArray) -> dict[str, list[int]]:
    columns = {"sequences": "sequence", "frames": "frames", "people": "people"}
    return {name: dataset.rows[column][chosen].tolist() for name, column in columns.items()}


def _figures(result: Result, chosen: IntArray) -> dict[str, list[float | None]]:
    """A solver's figures in the chosen sequences, None where it has none."""
    own = result.per_sequence
    place = np.searchsorted(own.sequence, chosen).clip(max=len(own.sequence) - 1)
    there = own.sequence[place] == chosen
    return {name: _rounded(np.where(there, own.figures[name][place], np.nan)) for name in _METRICS}


def _rounded(values: FloatArray) -> list[float | None]:
    return [round(float(value), _DIGITS) if np.isfinite(value) else None for value in values]
