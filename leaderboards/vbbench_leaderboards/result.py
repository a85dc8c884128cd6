"""One result: what a solver scored on a board, and every sequence's own figures.

A *board* is a split, a tier and a protocol: the table in which solvers stand beside one another. A result's file is
``SPLIT/PROTOCOL-TIER/SOLVER.json`` below the folder of results.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vbbench import __version__
from vbbench.scoring.scorecard import PerSequence, Score

FORMAT_VERSION = 1


@dataclass(frozen=True, kw_only=True, order=True)
class Board:
    """Where results may be compared: same split, same tier, same protocol."""

    split: str
    tier: str
    protocol: str

    @property
    def folder(self) -> Path:
        """Where its result files lie below the folder of results."""
        return Path(self.split, f"{self.protocol}-{self.tier}")


@dataclass(frozen=True, kw_only=True)
class Result:
    """A solver's result on a board.

    Parameters
    ----------
    board : split, tier and protocol.
    solver : name it goes by on the board; also its file's name.
    version, reference, link : the solver's version, where it is described, and where it can be had.
    dataset, camera, seed : id of the dataset that was solved, the kind of its camera, and its seed;
        ``None`` where that is withheld.
    package_version : of the vbbench that scored it.
    hardware : what the solver ran on.
    submission : file name → SHA-256 of the submission's tables, so that it can be told whether one at hand is the one.
    score : as ``vbbench score --json`` prints it, under the name that the solver goes by here.
    per_sequence : figures of each scored sequence, to float32.
    """

    board: Board
    solver: str
    version: str
    reference: str
    link: str
    dataset: str
    camera: str
    seed: int | None
    package_version: str
    hardware: str
    submission: dict[str, str]
    score: dict[str, Any]
    per_sequence: PerSequence

    @property
    def path(self) -> Path:
        """Where its file lies below the folder of results."""
        return self.board.folder / f"{self.solver}.json"

    @property
    def protocol_id(self) -> str:
        """Name and version of the protocol, as printed with every score."""
        return f"{self.board.protocol}/{self.score['protocol_version']}"

    @staticmethod
    def of(
        score: Score, submission: dict[str, str], *, name: str = "", reference: str = "", link: str = ""
    ) -> "Result":
        """The result that a score makes; ``name`` and ``reference`` replace what the submission declares."""
        info, data = score.info, score.dataset
        solver = name or info.solver
        return Result(
            board=Board(split=data.split, tier=data.tier, protocol=score.protocol.name),
            solver=solver,
            version=info.version,
            reference=reference or info.reference,
            link=link,
            dataset=info.dataset,
            camera=data.camera.kind,
            seed=data.seed,
            package_version=__version__,
            hardware=info.hardware,
            submission=submission,
            score={**score.values(), "solver": solver},
            per_sequence=_to_float32(score.per_sequence),
        )


def _to_float32(own: PerSequence) -> PerSequence:
    """The figures as their file will hold them."""
    return replace(own, figures={name: values.astype("f4").astype("f8") for name, values in own.figures.items()})
