"""A leaderboard of one tiny dataset and two solvers: shared by the tests of result files."""

import json
from pathlib import Path
from typing import Any

from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.files.dataset import Dataset
from vbbench.solving import solve
from vbbench_leaderboards.results.sealed_json import digest
from vbbench_leaderboards.submitting import add

FILE = Path("tiny", "sequential-ideal", "cv.json")
SOLVERS = ("cv", "vb-cv")


def tiny_dataset(folder: Path, crowd: Crowd | None = None) -> Path:
    """A dataset folder of a few sequences."""
    write_dataset(folder, crowd or Crowd(sequences=6))
    return folder


def seal(path: Path, values: dict[str, Any]) -> None:
    """Write a file of the leaderboard with a digest that fits, sound or not."""
    path.write_text(json.dumps({**values, "digest": digest(values)}), encoding="utf-8")


def tiny_board(room: Path) -> Path:
    """Dataset, submissions and results below ``room``; the folder of results."""
    dataset = tiny_dataset(room / "work" / "datasets" / "tiny-ideal")
    for solver in SOLVERS:
        answers = room / "work" / "submissions" / "tiny" / "sequential-ideal" / solver
        answers.parent.mkdir(parents=True, exist_ok=True)
        solve(Dataset(dataset), solver, "sequential", answers)
        add(answers, dataset, room / "results")
    return room / "results"
