"""Result files: who made a solver, what it scored on a board, figures of every sequence, and earlier ones.

A *board* is a split, a tier and a protocol: the table in which solvers stand next to one another. A result's file is
``SPLIT/PROTOCOL-TIER/SOLVER.json`` below the folder of results.
"""

import datetime
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from vbbench import __version__
from vbbench.errors import FileError, VbbenchError
from vbbench.estimate import LARGEST
from vbbench.files.submission import OFFLINE, SubmissionInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.parsing.numbers import is_day
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import PerSequence, Score
from vbbench_leaderboards.results.dataset_record import BoardDataset, write_dataset
from vbbench_leaderboards.results.sealed_json import (
    COUNTS,
    FORMAT_VERSION,
    Values,
    decode,
    encode,
    read_object,
    sealed_text,
    whole_columns,
)

Delay = int | Literal["offline"]
"""Frames that an answer comes after its own frame; 0 = causal, `OFFLINE` = after the whole sequence."""

NOBODY_YET = "your name"
"""The authors that the template and examples name; nobody may hand them in."""

NEEDED = {
    "authors": "who made the solver",
    "trained_on": "what the solver was trained on ('nothing' is an answer)",
    "tuned_on": "what the solver was tuned on by hand ('nothing' is an answer)",
}
"""What every row must declare."""

_CODE = re.compile(r"(https?://[^\s<>\"']{1,492})?")

LARGEST_FIGURE = 10 * LARGEST
"""No error is larger: answers and truth lie within ± `LARGEST` on each axis, and drift is over 2/3 s or more."""

DIGITS = 8
"""Of an earlier figure in a file, which is kept to be seen, not to be computed with."""


class Interval(NamedTuple):
    """A capped mean with the ends of its 95 % interval; ``None`` = there is none."""

    value: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True, kw_only=True)
class About:
    """The facts of a row.

    Parameters
    ----------
    reference : what the solver is, or where it is described, in one line.
    code : web address of its code; may be empty.
    authors : who made it.
    date : the day of the result, YYYY-MM-DD.
    delay : whether it is causal, late or offline; see `Delay`.
    trained_on : what its parameters were learned from; "nothing" is an answer.
    tuned_on : what its makers looked at when they chose the rest; "nothing" is an answer.
    rerun_by : who regenerated the figures, and when; may be empty.
    """

    reference: str = ""
    code: str = ""
    authors: str
    date: str
    delay: Delay
    trained_on: str
    tuned_on: str
    rerun_by: str = ""

    @property
    def sees_the_future(self) -> bool:
        """Whether an answer may depend on frames after its own; such solvers are ranked apart."""
        return self.delay != 0

    @property
    def timing(self) -> str:
        """Causal, late or offline, in words."""
        if self.delay == OFFLINE:
            return "offline"
        return "causal" if self.delay == 0 else f"{self.delay} frame{'' if self.delay == 1 else 's'} late"

    @staticmethod
    def of(info: SubmissionInfo, **given: Any) -> "About":
        """What a submission declares, with what is ``given`` in its place; the day is today unless it is given.

        Raises VbbenchError if something that every row must declare is missing, or the address or the day is none.
        """
        facts: dict[str, Any] = {"date": f"{datetime.date.today()}"}
        facts |= {field.name: getattr(info, field.name) for field in fields(About) if hasattr(info, field.name)}
        facts |= {name: value for name, value in given.items() if value not in ("", None)}
        if facts["delay"] is None:
            how = f"frames that an answer comes after its own (0 for none), or '{OFFLINE}'; or write it into"
            raise VbbenchError(f"a row must state whether the solver is causal: give `delay`, {how} submission.json")
        for name, words in NEEDED.items():
            if not facts[name].strip():
                raise VbbenchError(f"a row must state {words}: give `{name}`, or write it into submission.json")
        about = About(**facts)
        if not _CODE.fullmatch(about.code):
            raise VbbenchError(f"`code` {about.code} is not an address; give one that begins with https:// or http://")
        if not is_day(about.date):
            raise VbbenchError(f"`date` {about.date} is not a day; write it as YYYY-MM-DD")
        return about


FACTS = [field.name for field in fields(About) if field.name != "date"]
"""Names of what a row says of its solver."""


def parse_facts(words: Mapping[str, str]) -> dict[str, Any]:
    """Facts of a row from their words on a command line; VbbenchError if a delay is none."""
    delay = words.get("delay", OFFLINE)
    if not re.fullmatch(rf"{OFFLINE}|[0-9]{{1,6}}", delay):
        raise VbbenchError(f"a delay is a number of frames, 0 for a causal solver, or '{OFFLINE}', not '{delay}'")
    return {**words} if delay == OFFLINE else {**words, "delay": int(delay)}


@dataclass(frozen=True, kw_only=True)
class Past:
    """Earlier figures of a row.

    Parameters
    ----------
    date : the day of that result, YYYY-MM-DD.
    version : of the solver.
    vbbench : the version that scored it.
    dataset : id of the dataset that was solved; with another, the task was another.
    protocol : name and version.
    capped : metric → capped mean and interval.
    """

    date: str
    version: str
    vbbench: str
    dataset: str
    protocol: str
    capped: Mapping[str, Interval]

    @staticmethod
    def of(score: Mapping[str, Any], **facts: str) -> "Past":
        """The entry of a score, as ``vbbench score --json`` prints it; ``facts`` are the other parameters."""
        found = {**score["metrics"], **score["drift"]}.items()
        return Past(**facts, capped={name: Interval(one["capped"], *one["capped_ci95"]) for name, one in found})

    @staticmethod
    def read(values: Mapping[str, Any]) -> "Past":
        """An entry of a file of the right form."""
        return Past(**{**values, "capped": {name: Interval(*ends) for name, ends in values["capped"].items()}})

    def values(self) -> dict[str, Any]:
        """The entry as the file has it."""
        return {**vars(self), "capped": {name: [_rounded(end) for end in ends] for name, ends in self.capped.items()}}

    @property
    def release(self) -> tuple[str, ...]:
        """Those of the solver and of vbbench; a development version, such as 0.5.0.dev12+gabc1234, counts as 0.5.0."""
        return tuple(version.partition(".dev")[0] for version in (self.version, self.vbbench))


def grown(history: Sequence[Past], old: Past, new: Past) -> tuple[Past, ...]:
    """The history of a row whose figures ``old`` are replaced by ``new``: the last figures of each earlier release."""
    last: dict[tuple[str, ...], Past] = {}
    for past in (*history, old, new):
        last.pop(past.release, None)
        last[past.release] = past
    return tuple(last.values())[:-1]


def history_faults(history: Sequence[Past], date: str) -> Iterator[str]:
    """What is wrong with the history of a result of the day ``date``."""
    days = [*(past.date for past in history), date]
    for n, past in enumerate(history):
        place = f"$.history[{n}]"
        if not is_day(past.date):
            yield f"{place}.date: {past.date} is not a day; write it as YYYY-MM-DD"
        elif days[n + 1] < past.date:
            yield f"{place}.date: {past.date} is after {days[n + 1]}, which follows it; the oldest comes first"
        for name, (value, low, high) in past.capped.items():
            if name not in METRICS:
                yield f"{place}.capped.{name}: is no metric"
            ends = [end for end in (low, value, high) if end is not None]
            if ends != sorted(ends) or (value is None and ends):
                yield f"{place}.capped.{name}: the mean does not lie in its interval"


def _rounded(figure: float | None) -> float | None:
    return None if figure is None else float(f"{figure:.{DIGITS}g}")


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
    submission : file name → SHA-256 of the submission's tables, by which one at hand is identified.
    score : as ``vbbench score --json`` prints it, under the name that the solver goes by here.
    per_sequence : figures of each scored sequence, to float32.
    history : the row's last figures in each earlier release, the oldest first.
    seen : how its solver saw recordings of the board (`boards.seen_by`); "" if not at all. No part of the file.
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
    def protocol_id(self) -> str:
        """Name and version of the protocol that scored it."""
        return f"{self.board.protocol}/{self.score['protocol_version']}"

    @property
    def present(self) -> Past:
        """The row's figures, as its history will have them."""
        facts = {"date": self.about.date, "version": self.version, "vbbench": self.package_version}
        return Past.of(self.score, dataset=self.dataset, protocol=self.protocol_id, **facts)

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
            submission=file_hashes(submission),
            score={**score.values(), "solver": solver},
            per_sequence=replace(own, figures={n: v.astype("f4").astype("f8") for n, v in own.figures.items()}),
        )


def read_result(path: Path) -> Result:
    """Read a result file.

    Raises FileError if it is of another form, was changed by hand, or was scored under another version of its protocol.
    """
    values = read_object(path, "result")
    protocol = values["protocol"].partition("/")[0]
    current = get_protocol(protocol).id
    if values["protocol"] != current:
        problem = f"$.protocol: is {values['protocol']}, this vbbench scores {current}; solve and add it again"
        raise FileError(path, problem)
    columns = decode(values["per_sequence"])
    figures = {name: columns[name] for name in METRICS}
    for name, column in figures.items():
        absurd = ~((column >= 0) & (column <= LARGEST_FIGURE) | np.isnan(column))
        if absurd.any():
            row = f"$.per_sequence: {name} of sequence {columns['sequence'][absurd][0]:.0f}"
            raise FileError(path, f"{row} is below 0 or above {LARGEST_FIGURE:.0f}, where none can be; score it again")
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
        per_sequence=PerSequence(**whole_columns(columns, COUNTS, path, "$.per_sequence"), figures=figures),
        history=tuple(map(Past.read, values.get("history", ()))),
    )


def write_result(result: Result, results: Path, record: BoardDataset | None = None) -> Path:
    """Write the file of a result below the folder ``results``, whole or not at all, and return its path.

    Figures of the solver that lie there already become part of the row's history, if they are of another release.

    Raises FileError if the result is of another form; nothing is written then.

    Parameters
    ----------
    record : of the board's dataset, written first where the folder has none: no result is without its record.
    """
    path = results / result.path
    if path.is_file():
        with suppress(FileError):  # what is damaged leaves no history; it may be of an older version of its protocol
            result = replace(result, history=_history(read_object(path, "result"), result.present))
    text = sealed_text(_values(result), path, "result")
    if record is not None and not (results / record.path).is_file():
        write_dataset(record, results)
    write_text_atomically(path, text)
    return path


def _history(old: Values, present: Past) -> tuple[Past, ...]:
    """The history of a row whose file held ``old``."""
    facts = {name: old["solver"][name] for name in ("date", "version")} | {"vbbench": old["made_with"]["vbbench"]}
    past = Past.of(old["score"], dataset=old["dataset"]["id"], protocol=old["protocol"], **facts)
    return grown([*map(Past.read, old.get("history", ()))], past, present)


TABLES = tuple(f"{table}.{kind}" for table in ("poses", "positions") for kind in ("parquet", "csv"))
"""The files that a submission's tables may be in."""


def file_hashes(submission: Path, names: Iterable[str] = TABLES) -> dict[str, str]:
    """File name → SHA-256 of those files of a submission that there are."""
    return {name: file_sha256(submission / name) for name in names if (submission / name).is_file()}


def _values(result: Result) -> Values:
    own, board = result.per_sequence, result.board
    columns = {**{name: getattr(own, name) for name in COUNTS}, **{name: own.figures[name] for name in METRICS}}
    return {
        "format_version": FORMAT_VERSION,
        "solver": {"name": result.solver, "version": result.version, **vars(result.about)},
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
        **({"history": [past.values() for past in result.history]} if result.history else {}),
    }
