"""A submission folder: its declared facts (``submission.json``), its writer, and the list of its faults."""

import json
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, SubmissionError, is_printable, one_line, quoted
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.tables import FALLBACK, Columns, TableWriter, WholeWriter, to_arrow
from vbbench.folders.locks import locked
from vbbench.folders.replacing import replacing
from vbbench.folders.work_folder import finish_swaps
from vbbench.geometry import BoolArray
from vbbench.parsing.json_text import read_json
from vbbench.protocol import PROTOCOLS

SUBMISSION_FILE = "submission.json"
FAILURE_POLICIES = ("refuse", "hold")
LONGEST_TEXT = 1000
"""Most characters of a text in ``submission.json``: names and references are printed with every score."""

LONGEST_FRAME = 1e6
"""Most seconds per frame that are accepted: eleven days."""

OFFLINE: Literal["offline"] = "offline"
"""The delay of a solver that answers when it has seen the whole sequence."""

LONGEST_DELAY = 1_000_000
"""Most frames that an answer may come late."""

LISTED = 20
"""Faults of one kind that are listed one by one; the others are only counted."""


class Faults:
    """The faults found so far, by kind."""

    def __init__(self) -> None:
        self._listed: dict[str, list[str]] = {}
        self._count: dict[str, int] = {}

    def __bool__(self) -> bool:
        return bool(self._count)

    def add(self, fault: str, kind: str | None = None) -> None:
        """Add a fault: file and place, problem, remedy. Only the first faults of a ``kind`` are listed."""
        self._add(kind or fault, [fault], 1)

    def add_error(self, error: FileError) -> None:
        """Add an error about a file of the submission; its folder is omitted."""
        line = "" if error.line is None else f", line {error.line}"
        self.add(f"{error.path.name}{line}: {error.problem}")

    def add_rows(self, file: str, problem: str, columns: Mapping[str, NDArray[Any]], bad: BoolArray) -> None:
        """Add the same fault for every row marked in ``bad`` [R]; ``columns`` identify the rows (ids, CSV line)."""
        rows = np.flatnonzero(bad)
        if len(rows):
            ids = [name for name in ("line", "sequence", "frame", "track") if name in columns]
            names = [", ".join(f"{name} {columns[name][row]}" for name in ids) for row in rows[:LISTED]]
            self._add(f"{file}: {problem}", [f"{file}, {name}: {problem}" for name in names], len(rows))

    def listing(self) -> tuple[str, ...]:
        """Every fault, one line each."""
        lines = []
        for kind, listed in self._listed.items():
            rest = self._count[kind] - len(listed)
            lines += [*listed, f"{one_line(kind)} ({rest} more)"] if rest else listed
        return tuple(lines)

    def _add(self, kind: str, faults: list[str], count: int) -> None:
        listed = self._listed.setdefault(kind, [])
        listed.extend(map(one_line, faults[: LISTED - len(listed)]))
        self._count[kind] = self._count.get(kind, 0) + count


@dataclass(frozen=True, kw_only=True)
class SubmissionInfo:
    """What a submission declares about itself.

    Parameters
    ----------
    solver : name of the solver.
    dataset : id of the dataset that was solved.
    protocol : name of the protocol.
    version : version of the solver.
    seconds_per_frame : mean run time per frame; ``None`` = not measured.
    hardware, reference : hardware of the run, and a publication about the solver.
    authors, code : authors of the solver, and the web address of its code.
    trained_on, tuned_on : data from which parameters were learned, and data on whose results other choices were made;
        "nothing" is an answer.
    delay : frames by which an answer is later than its own frame: 0 if it depends on this frame and earlier ones alone,
        `OFFLINE` if on the whole sequence; ``None`` = not declared.
    failure_policy : ``refuse`` = every scored row is required; ``hold`` = a missing row is filled with the last known
        value of that track or observer, and coverage is the share of the others.
    """

    solver: str
    dataset: str
    protocol: str
    version: str = ""
    seconds_per_frame: float | None = None
    hardware: str = ""
    reference: str = ""
    authors: str = ""
    code: str = ""
    trained_on: str = ""
    tuned_on: str = ""
    delay: int | Literal["offline"] | None = None
    failure_policy: Literal["refuse", "hold"] = "refuse"

    def to_json(self) -> str:
        """The text of ``submission.json``."""
        return json.dumps(asdict(self), indent=2, ensure_ascii=False) + "\n"

    @staticmethod
    def read(folder: Path | str) -> "SubmissionInfo":
        """Read ``submission.json`` of a submission folder; raises SubmissionError, which lists every fault."""
        faults = Faults()
        info = read_info(Path(folder), faults)
        if faults:
            raise SubmissionError(folder, faults.listing())
        return info


def read_info(folder: Path, faults: Faults) -> SubmissionInfo:
    """The declared facts, with empty text for invalid values, which are added to ``faults``."""
    finish_swaps(folder)
    if not folder.is_dir():
        raise SubmissionError(folder, ["there is no such folder; name the folder of a submission"])
    values = _read_object(folder / SUBMISSION_FILE, faults)
    known = {field.name for field in fields(SubmissionInfo)}
    required: dict[str, Any] = {"solver": "", "dataset": "", "protocol": ""}
    if values is None:
        return SubmissionInfo(**required)
    for name in sorted(set(values) - known):
        problem = f"is unknown; keys are {', '.join(sorted(known))}"
        faults.add(f"{SUBMISSION_FILE}: key {quoted(name)} {problem}", kind=f"{SUBMISSION_FILE}: a key {problem}")
    for name in required:
        if name not in values:
            faults.add(f"{SUBMISSION_FILE}: key '{name}' is missing; add it")
    problems = {name: _problem(name, value) for name, value in values.items() if name in known}
    for name, reason in problems.items():
        if reason:
            faults.add(f"{SUBMISSION_FILE}: key '{name}' {reason}")
    return SubmissionInfo(**required | {name: values[name] for name, reason in problems.items() if not reason})


class SubmissionWriter(WholeWriter):
    """Writes a submission by sequence; the folder is one only when the block ends without error.

    ``info`` is written last and may be replaced inside the block, as the time is known only at its end.

    Parameters
    ----------
    folder : the folder to write into; created if needed.
    info : the declared facts.
    fallback : whether the table of poses has the optional column ``fallback``.

    Examples
    --------
    >>> with SubmissionWriter(folder, info) as writer:                          # doctest: +SKIP
    ...     writer.add(0, {"frame": t, "x": x, "y": y, "yaw": yaw}, {"frame": t, "track": k, "x": x, "y": y})
    """

    def __init__(self, folder: Path | str, info: SubmissionInfo, *, fallback: bool = False) -> None:
        self.folder = Path(folder)
        self.info = info
        optional = {"poses": [FALLBACK] if fallback else [], "positions": []}
        self._tables: dict[str, TableWriter] = {}
        with ExitStack() as stack:
            stack.enter_context(locked(self.folder))
            self._facts = stack.enter_context(replacing(self.folder / SUBMISSION_FILE))
            for name, columns in optional.items():
                table = TableWriter(self.folder / f"{name}.parquet", name, columns)
                self._tables[name] = stack.enter_context(table)
            self._open = stack.pop_all()

    def add(self, sequence: int, poses: Columns, positions: Columns) -> None:
        """Append the rows of one sequence; sequences come in ascending order.

        Parameters
        ----------
        sequence : its number in the dataset.
        poses : columns frame, x, y, yaw, each [N], in m and rad, and perhaps fallback.
        positions : columns frame, track, x, y, each [M], in m.
        """
        for name, columns in (("poses", poses), ("positions", positions)):
            number = np.full(len(columns["frame"]), sequence, dtype=np.int32)
            self._tables[name].add(to_arrow(name, {**columns, "sequence": number}))

    def finish(self) -> None:
        """Write everything before the first file gets its name; the facts get theirs last."""
        for table in self._tables.values():
            table.finish()
        self._facts.write_text(self.info.to_json(), encoding="utf-8")
        (self.folder / SUBMISSION_FILE).unlink(missing_ok=True)


def _read_object(path: Path, faults: Faults) -> dict[str, Any] | None:
    if not path.is_file():
        remedy = "write one with the keys solver, dataset and protocol"
        if (path.parent / INFO_FILE).is_file():
            remedy = "this folder is a dataset; name that of the answers"
        faults.add(f"{SUBMISSION_FILE}: the file is missing; {remedy}")
        return None
    try:
        values = read_json(path, finite=False)
    except ValueError as error:
        faults.add(f"{SUBMISSION_FILE}: cannot be read ({error}); fix the JSON")
        return None
    if not isinstance(values, dict):
        faults.add(f'{SUBMISSION_FILE}: holds no object; write {{"solver": ..., "dataset": ..., "protocol": ...}}')
        return None
    return values


def _problem(name: str, value: Any) -> str | None:
    """The problem of a key's value; ``None`` if it is valid."""
    if name == "seconds_per_frame":
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if value is None or (number and 0 <= value <= LONGEST_FRAME):
            return None
        return f"is {quoted(value)}; give a number of seconds from 0 to {LONGEST_FRAME:.0f}, or remove it"
    if name == "delay":
        number = isinstance(value, int) and not isinstance(value, bool)
        if value in (None, OFFLINE) or (number and 0 <= value <= LONGEST_DELAY):
            return None
        return f"is {quoted(value)}; give a number of frames, 0 for a causal solver, or '{OFFLINE}'"
    if not isinstance(value, str):
        return f"is {quoted(value)}; give text"
    if len(value) > LONGEST_TEXT:
        return f"has {len(value)} characters; write {LONGEST_TEXT} or fewer"
    if not is_printable(value):
        return f"is {quoted(value)}; remove ends of lines and control characters"
    choices = {"failure_policy": FAILURE_POLICIES, "protocol": PROTOCOLS}.get(name)
    if choices and value not in choices:
        return f"is {quoted(value)}, which is unknown; choose {', '.join(choices)}"
    return "is empty; fill it in" if name == "solver" and not value.strip() else None
