"""Commands of the leaderboard: parse, call one library function, print."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tyro.conf import Positional

RESULTS = Path("leaderboards/results")
WORK = Path("out/leaderboard")


def add(
    submission: Positional[Path],
    /,
    dataset: Path,
    truth: Path | None = None,
    results: Path = RESULTS,
    name: str = "",
    reference: str = "",
    link: str = "",
    overwrite: bool = False,
) -> None:
    """Score a submission and write its result file.

    Args:
        submission: Folder with submission.json, poses and positions.
        dataset: The dataset that it answers.
        truth: Folder with the truth tables, where they are kept elsewhere.
        results: Folder of the result files.
        name: What the solver is called on the board; default: as the submission says.
        reference: Where it is described, in a line; default: as the submission says.
        link: Address where it can be had.
        overwrite: Replace the result that is there.
    """
    from vbbench_leaderboards.adding import add as write

    path = write(
        submission,
        dataset,
        results,
        truth=truth,
        name=name,
        reference=reference,
        link=link,
        overwrite=overwrite,
    )
    _say(path)


def _say(text: object) -> None:
    sys.stdout.write(f"{text}\n")


COMMANDS: dict[str, Callable[..., Any]] = {
    "add": add,
}
