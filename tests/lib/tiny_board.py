"""A leaderboard of one tiny dataset and two solvers: shared by the tests of result files."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.files.dataset import Dataset
from vbbench.solving import solve
from vbbench_leaderboards.results.sealed_json import decode, digest, encode
from vbbench_leaderboards.submitting import add

FILE, RECORD = Path("tiny", "sequential-ideal", "cv.json"), Path("tiny", "ideal.json")
"""A result and the record of its dataset, below the folder of results."""

Change = Callable[[dict[str, Any]], object]
SOLVERS = ("cv", "vb-cv")


def tiny_dataset(folder: Path, crowd: Crowd | None = None) -> Path:
    """A dataset folder of a few sequences."""
    write_dataset(folder, crowd or Crowd(sequences=6))
    return folder


def forge(path: Path, change: Change) -> None:
    """Change the values in a file of the leaderboard, sound or not, and make its digest fit."""
    values = json.loads(path.read_text("utf-8"))
    change(values)
    path.write_text(json.dumps({**values, "digest": digest(values)}), encoding="utf-8")


def at(place: str | Sequence[Any], value: object) -> Change:
    """Puts a value at a place of a tree, such as ``score.metrics.dx``."""

    def put(values: Any) -> None:
        *path, last = place.split(".") if isinstance(place, str) else place
        for key in path:
            values = values[key]
        values[last] = value

    return put


def recoded(change: Change, place: Sequence[str] = ("per_sequence",)) -> Change:
    """Changes the columns in the block at a place."""

    def apply(values: dict[str, Any]) -> None:
        block = values
        for key in place:
            block = block[key]
        columns = decode(block)
        change(columns)
        with np.errstate(over="ignore"):
            block.update(encode(columns))

    return apply


def tiny_board(room: Path) -> Path:
    """Dataset, submissions and results below ``room``; the folder of results."""
    dataset = tiny_dataset(room / "work" / "datasets" / "tiny-ideal")
    for solver in SOLVERS:
        answers = room / "work" / "submissions" / "tiny" / "sequential-ideal" / solver
        answers.parent.mkdir(parents=True, exist_ok=True)
        solve(Dataset(dataset), solver, "sequential", answers)
        add(answers, dataset, room / "results")
    return room / "results"
