"""One result: what a solver scored on a board, and every sequence's own figures.

A *board* is a split, a tier and a protocol: the table in which solvers stand beside one another. A result's file is
``SPLIT/PROTOCOL-TIER/SOLVER.json`` below the folder of results.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench import __version__
from vbbench.errors import FileError
from vbbench.estimate import LARGEST
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import PerSequence, Score
from vbbench_leaderboards.results.about import About
from vbbench_leaderboards.results.dataset_record import BoardDataset, write_dataset
from vbbench_leaderboards.results.forms import COUNTS, FORMAT_VERSION
from vbbench_leaderboards.results.history import Past, grown
from vbbench_leaderboards.results.sealed_json import (
    Block,
    Values,
    decode,
    encode,
    read_object,
    sealed_text,
    whole_columns,
)

LARGEST_FIGURE = 10 * LARGEST
"""No error is larger: answers and truth lie within ± `LARGEST` on each axis, and drift is over 2/3 s or more."""


@dataclass(frozen=True, kw_only=True, order=True)
class Board:
    """Where results may be compared: same split, same tier, same protocol."""

    split: str
    tier: str
    protocol: str

    @property
    def key(self) -> str:
        """``SPLIT/PROTOCOL-TIER``: in addresses, and where its result files lie below the folder of results."""
        return f"{self.split}/{self.protocol}-{self.tier}"


@dataclass(frozen=True, kw_only=True)
class Result:
    """A solver's result on a board.

    Parameters
    ----------
    board : split, tier and protocol.
    solver : name it goes by on the board; also its file's name.
    version : the solver's.
    about : who made it, what it was trained on, whether it is causal, and so on.
    dataset, camera, seed : id of the dataset that was solved, the kind of its camera, and its seed;
        ``None`` where that is withheld.
    package_version : of the vbbench that scored it.
    hardware : what the solver ran on.
    submission : file name → SHA-256 of the submission's tables, so that it can be told whether one at hand is the one.
    score : as ``vbbench score --json`` prints it, under the name that the solver goes by here.
    per_sequence : figures of each scored sequence, to float32.
    history : what the row said before, the oldest first.
    seen : how its solver saw recordings of the board (`recordings.seen_by`); "" if not at all. No part of the file.
    """

    board: Board
    solver: str
    version: str
    about: About
    dataset: str
    camera: str
    seed: int | None
    package_version: str
    hardware: str
    submission: dict[str, str]
    score: dict[str, Any]
    per_sequence: PerSequence
    history: tuple[Past, ...] = ()
    seen: str = ""

    @property
    def group(self) -> tuple[bool, bool]:
        """Whom it is ranked with: whether it sees the future, and whether it saw recordings of the board."""
        return self.about.sees_the_future, bool(self.seen)

    @property
    def path(self) -> Path:
        """Where its file lies below the folder of results."""
        return Path(self.board.key, f"{self.solver}.json")

    @property
    def present(self) -> Past:
        """What the row says now, as its history will have it."""
        protocol = f"{self.board.protocol}/{self.score['protocol_version']}"
        said = {"date": self.about.date, "version": self.version, "vbbench": self.package_version}
        return Past.of(self.score, dataset=self.dataset, protocol=protocol, **said)

    @staticmethod
    def of(score: Score, submission: Path, about: About, *, name: str = "") -> "Result":
        """The result that the score of a submission makes; ``name`` replaces the one that it declares."""
        info, data, own = score.info, score.dataset, score.per_sequence
        solver = name or info.solver
        return Result(
            board=Board(split=data.split, tier=data.tier, protocol=score.protocol.name),
            solver=solver,
            version=info.version,
            about=about,
            dataset=info.dataset,
            camera=data.camera.kind,
            seed=data.seed,
            package_version=__version__,
            hardware=info.hardware,
            submission=table_hashes(submission),
            score={**score.values(), "solver": solver},
            per_sequence=replace(own, figures={n: v.astype("f4").astype("f8") for n, v in own.figures.items()}),
        )


def read_result(path: Path) -> Result:
    """Read a result file.

    Raises
    ------
    FileError
        If it is of another form, was changed by hand, or was scored under another version of its protocol.
    """
    values = read_object(path, "result")
    protocol = values["protocol"].partition("/")[0]
    known = get_protocol(protocol).id
    if values["protocol"] != known:
        raise FileError(
            path, f"$.protocol: is {values['protocol']}, this vbbench scores {known}; solve and add it anew"
        )
    solver, dataset = values["solver"], values["dataset"]
    return Result(
        board=Board(split=dataset["split"], tier=dataset["tier"], protocol=protocol),
        solver=solver["name"],
        version=solver["version"],
        about=About(**{name: value for name, value in solver.items() if name not in ("name", "version")}),
        dataset=dataset["id"],
        camera=dataset["camera"],
        seed=dataset["seed"],
        package_version=values["made_with"]["vbbench"],
        hardware=values["made_with"]["hardware"],
        submission=values["submission"],
        score=values["score"],
        per_sequence=_per_sequence(values["per_sequence"], path),
        history=_history(values),
    )


def write_result(result: Result, results: Path, record: BoardDataset | None = None) -> Path:
    """Write the file of a result below the folder ``results``, whole or not at all, and return its path.

    Figures of the solver that lie there already become part of the row's history.

    Parameters
    ----------
    record : of the board's dataset, written first where the folder has none: no result is without its record.

    Raises
    ------
    FileError
        If the result is of another form; nothing is written then.
    """
    path = results / result.path
    text = sealed_text(_values(_with_history(result, path)), path, "result")
    if record is not None and not (results / record.path).is_file():
        write_dataset(record, results)
    write_text_atomically(path, text)
    return path


def _with_history(result: Result, path: Path) -> Result:
    """The result with the history of the one at ``path``, which it replaces; one that is damaged leaves nothing.

    The one there may be of an older version of its protocol.
    """
    if not path.is_file():
        return result
    with suppress(FileError):
        old = read_object(path, "result")
        solver = old["solver"]
        said = {"date": solver["date"], "version": solver["version"], "vbbench": old["made_with"]["vbbench"]}
        past = Past.of(old["score"], dataset=old["dataset"]["id"], protocol=old["protocol"], **said)
        return replace(result, history=grown(_history(old), past, result.present))
    return result


def _history(values: Values) -> tuple[Past, ...]:
    return tuple(map(Past.read, values.get("history", ())))


def table_hashes(submission: Path) -> dict[str, str]:
    """File name → SHA-256 of a submission's tables."""
    names = (f"{table}.{kind}" for table in ("poses", "positions") for kind in ("parquet", "csv"))
    return {name: file_sha256(submission / name) for name in names if (submission / name).is_file()}


def _values(result: Result) -> Values:
    own, board = result.per_sequence, result.board
    columns = {**{name: getattr(own, name) for name in COUNTS}, **{name: own.figures[name] for name in METRICS}}
    return {
        "format_version": FORMAT_VERSION,
        "solver": {
            "name": result.solver,
            "version": result.version,
            **vars(result.about),
        },
        "dataset": {
            "id": result.dataset,
            "split": board.split,
            "tier": board.tier,
            "camera": result.camera,
            "seed": result.seed,
        },
        "protocol": f"{board.protocol}/{result.score['protocol_version']}",
        "made_with": {"vbbench": result.package_version, "hardware": result.hardware},
        "submission": result.submission,
        "score": result.score,
        "per_sequence": encode(columns),
        **({"history": [past.values() for past in result.history]} if result.history else {}),
    }


def _per_sequence(block: Block, path: Path) -> PerSequence:
    columns = decode(block)
    figures = {name: columns[name] for name in METRICS}
    for name, values in figures.items():
        absurd = ~((values >= 0) & (values <= LARGEST_FIGURE) | np.isnan(values))
        if absurd.any():
            row = f"$.per_sequence: {name} of sequence {columns['sequence'][absurd][0]:.0f}"
            raise FileError(path, f"{row} is below 0 or above {LARGEST_FIGURE:.0f}, where none can be; score it anew")
    return PerSequence(**whole_columns(columns, COUNTS, path, "$.per_sequence"), figures=figures)
