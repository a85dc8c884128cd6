"""One result: what a solver scored on a board, and every sequence's own figures.

A *board* is a split, a tier and a protocol: the table in which solvers stand beside one another. A result's file is
``SPLIT/PROTOCOL-TIER/SOLVER.json`` below the folder of results.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from vbbench import __version__
from vbbench.scorecard import PerSequence, Score
from pathlib import Path
import numpy as np
from vbbench.errors import FileError
from vbbench.estimate import LARGEST
from vbbench.protocol import get_protocol
from vbbench.scorecard import DRIFTS, METRICS, PerSequence
from vbbench_leaderboards.results.sealed_json import Block, decode, encode, whole_columns
from vbbench_leaderboards.results.sealed_json import Values, object_text, read_object, write_object

# DOC """Result files: one JSON a result, ``SPLIT/PROTOCOL-TIER/SOLVER.json`` below the folder of results."""
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


SCHEMA = "result"
COUNTS = ("sequence", "frames", "positions", "posed", "placed")
FIGURES = (*METRICS, *DRIFTS)
LARGEST_FIGURE = 10 * LARGEST
"""No error is larger: answers and truth lie within ± `LARGEST` on each axis, and drift is over 2/3 s or more."""


def read_result(path: Path) -> Result:
    """Read a result file.

    Raises
    ------
    FileError
        If it does not keep to the schema, was changed by hand, or was scored under another version of its protocol.
    """
    values = read_object(path, SCHEMA)
    protocol = values["protocol"].partition("/")[0]
    known = get_protocol(protocol).id
    if values["protocol"] != known:
        raise FileError(
            path, f"$.protocol: is {values['protocol']}, this vbbench scores {known}; solve and add it anew"
        )
    return _result(values, protocol, _per_sequence(values["per_sequence"], path))


def write_result(result: Result, results: Path) -> Path:
    """Write the file of a result below the folder ``results``, whole or not at all, and return its path.

    Raises
    ------
    FileError
        If the result does not keep to the schema.
    """
    return write_object(_values(result), results / result.path, SCHEMA)


def result_text(result: Result, results: Path) -> str:
    """The text that `write_result` writes; raises what that does."""
    return object_text(_values(result), results / result.path, SCHEMA)


def _values(result: Result) -> Values:
    own, board = result.per_sequence, result.board
    columns = {**{name: getattr(own, name) for name in COUNTS}, **{name: own.figures[name] for name in FIGURES}}
    return {
        "format_version": FORMAT_VERSION,
        "solver": {
            "name": result.solver,
            "version": result.version,
            "reference": result.reference,
            "link": result.link,
        },
        "dataset": {
            "id": result.dataset,
            "split": board.split,
            "tier": board.tier,
            "camera": result.camera,
            "seed": result.seed,
        },
        "protocol": result.protocol_id,
        "made_with": {"vbbench": result.package_version, "hardware": result.hardware},
        "submission": result.submission,
        "score": result.score,
        "per_sequence": encode(columns),
    }


def _result(values: Values, protocol: str, per_sequence: PerSequence) -> Result:
    solver, dataset = values["solver"], values["dataset"]
    return Result(
        board=Board(split=dataset["split"], tier=dataset["tier"], protocol=protocol),
        solver=solver["name"],
        version=solver["version"],
        reference=solver["reference"],
        link=solver["link"],
        dataset=dataset["id"],
        camera=dataset["camera"],
        seed=dataset["seed"],
        package_version=values["made_with"]["vbbench"],
        hardware=values["made_with"]["hardware"],
        submission=values["submission"],
        score=values["score"],
        per_sequence=per_sequence,
    )


def _per_sequence(block: Block, path: Path) -> PerSequence:
    columns = decode(block)
    figures = {name: columns[name] for name in FIGURES}
    if not all(((values >= 0) & (values <= LARGEST_FIGURE) | np.isnan(values)).all() for values in figures.values()):
        raise FileError(path, f"$.per_sequence: a figure is below 0 or above {LARGEST_FIGURE:.0f}, where none can be")
    return PerSequence(**whole_columns(columns, COUNTS, path, "$.per_sequence"), figures=figures)
