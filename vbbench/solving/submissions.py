"""Runs a solver over a whole dataset and writes its submission."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from threadpoolctl import threadpool_limits

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import part_ranges, ranges_within
from vbbench.files.submission import OFFLINE, SUBMISSION_FILE, SubmissionInfo
from vbbench.files.submission_tables import answer_rows
from vbbench.files.tables import to_arrow
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.work_folder import WorkFolder, check_free
from vbbench.generation.sources import data_folders
from vbbench.geometry import IntArray
from vbbench.parallel.parts import Part, check_jobs, write_in_parts
from vbbench.protocol import Protocol, get_protocol
from vbbench.registry import load, make_solver, own_words
from vbbench.sequence import Sequence
from vbbench.solver import FrameSolver
from vbbench.solving.isolation.confinement import folders_with
from vbbench.solving.isolation.remote import IsolatedSolver, Remote, warn_of_open_files
from vbbench.solving.provenance import hardware, solver_version, source_digest
from vbbench.solving.runner import SEQUENCES_A_PART, run_sequence, separate_groups
from vbbench.version import __version__

FACTS = ("authors", "code", "trained_on", "tuned_on")
"""Keys of ``facts``: those of ``submission.json`` that only the solver's makers know."""


def declared_facts(solver: str) -> dict[str, str]:
    """The attribute ``facts`` of the class called ``solver``, by key; facts of vbbench's own classes are not inherited.

    Raises VbbenchError if it is not a mapping of these keys to text, or the solver cannot be imported.
    """
    found = own_words(load("solver", solver), "facts")
    sound = isinstance(found, Mapping) and all(isinstance(text, str) for text in found.values())
    if not sound or set(found) - set(FACTS):
        raise VbbenchError(f"solver '{solver}': facts must map some of {', '.join(FACTS)} to text")
    return dict(found)


TABLES = ("poses", "positions", "heights")


def solve(
    dataset: Dataset,
    solver: str,
    protocol: str,
    out: Path | str,
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    isolate: bool = False,
    fresh_processes: bool = False,
    covariance: bool = False,
    overwrite: bool = False,
) -> Path:
    """Run the solver called ``solver`` (or named ``module:attribute``) and write the submission folder ``out``.

    Interrupted work continues where it stopped when the same call is made again.

    Raises VbbenchError if a name is unknown, truth is needed but withheld, covariances are requested from a solver that
    reports none, or ``out`` already exists.

    Parameters
    ----------
    scheduler : address of a Dask cluster to run it on, whose workers see the dataset under the same path.
    isolate : run the solver in a separate process that never gets truth; if the kernel has Landlock, it cannot read the
        dataset's files either.
    fresh_processes : isolate it, in a new process for each group of sequences that share no frame of a scene, solved in
        random order: information from one sequence is then of no use in another (`separate_groups`).
    covariance : also write the covariances of poses and positions.
    """
    check_jobs(jobs)
    out, rules = Path(out), get_protocol(protocol)
    _check_truth(dataset, rules)
    isolate = isolate or fresh_processes
    opened = _isolated(dataset, out) if isolate else _opened_here
    how = f"{rules.id} {covariance} {isolate} {fresh_processes}"
    key = f"{dataset.info.id} {solver} {solver_version(solver)} {source_digest(solver)} {how} {__version__}"
    solve_part = partial(_solve_part, dataset, solver, opened, rules, covariance, fresh_processes)
    words = {} if isolate else declared_facts(solver)
    count = len(dataset)
    ranges = ranges_within(count, SEQUENCES_A_PART) if fresh_processes else part_ranges(count, dataset.cells)
    with WorkFolder(out, partial(check_free, out, SUBMISSION_FILE, "submission", overwrite)) as work:
        if work.begin(key):
            longest_first = ("positions", *(name for name in TABLES if name != "positions"))
            tables = {name: work.new / f"{name}.parquet" for name in longest_first}
            where: dict[str, Any] = {"jobs": jobs, "scheduler": scheduler, "label": f"{solver} {protocol}"}
            parts = write_in_parts(solve_part, ranges, work.parts, tables, **where)
            if not any(part["heights"] for part in parts):
                tables["heights"].unlink()
            info = _declared(dataset, solver, protocol, words, parts)
            write_text_atomically(work.new / SUBMISSION_FILE, info.to_json())
            work.publish()
    return out


def _check_truth(dataset: Dataset, rules: Protocol) -> None:
    """Raise VbbenchError if the protocol gives or scores values that this dataset lacks."""
    if rules.given != "origin" and dataset.info.truth != "whole":
        lacking = "where people really are is" if dataset.info.truth == "poses" else "the camera's true poses are"
        raise VbbenchError(
            f"'{rules.name}' gives what is not known of {dataset.folder}: {lacking} missing; use cold-start"
        )
    if rules.needs_truth and not dataset.has_truth:
        raise VbbenchError(
            f"'{rules.name}' needs truth while solving; use sequential, rollout or cold-start, "
            "or name the folder that holds it with `truth`"
        )


Opened = AbstractContextManager[Any]
"""Gives the solver to run, for as long as the context lasts."""


def _opened_here(name: str) -> Opened:
    return nullcontext(make_solver(name))


def _isolated(dataset: Dataset, out: Path) -> Callable[[str], Opened]:
    """Opens solvers that can read neither the dataset, nor its sources, nor other solvers' answers."""
    warn_of_open_files()
    hidden = [*folders_with(dataset.folder), *folders_with(dataset.truth_folder), *folders_with(out), *data_folders()]
    return partial(IsolatedSolver, hidden=hidden)


def _declared(
    dataset: Dataset, solver: str, protocol: str, words: dict[str, Any], facts: list[dict[str, Any]]
) -> SubmissionInfo:
    seconds, frames = (sum(part[name] for part in facts) for name in ("seconds", "frames"))
    return SubmissionInfo(
        **words,
        delay=0 if all(part["causal"] for part in facts) else OFFLINE,
        solver=solver,
        version=solver_version(solver),
        dataset=dataset.info.id,
        protocol=protocol,
        seconds_per_frame=seconds / max(frames, 1),
        hardware="; ".join(sorted({part["hardware"] for part in facts})),
    )


def _solve_part(
    dataset: Dataset,
    name: str,
    opened: Callable[[str], Opened],
    protocol: Protocol,
    covariance: bool,
    fresh_processes: bool,
    first: int,
    last: int,
) -> Part:
    groups = separate_groups(dataset.rows, first, last) if fresh_processes else [np.arange(first, last)]
    answers: dict[int, Rows] = {}
    seconds, frames = 0.0, 0
    for group in groups:
        with opened(name) as solver, threadpool_limits(1):  # the number of threads changes rounding, and so answers
            causal = isinstance(solver, FrameSolver) or protocol.needs_truth  # otherwise it gets whole sequences
            for sequence in _read(dataset, group):
                truth = dataset.truth(sequence) if protocol.needs_truth else None
                problem = dataset.problem(sequence, covariances=covariance)
                if isinstance(solver, Remote):
                    solver.is_now(f"solving sequence {sequence.index}")
                estimate, spent = run_sequence(solver, problem, sequence, protocol, truth)
                rows = answer_rows(sequence, protocol, estimate, covariance)
                answers[sequence.index] = {table: to_arrow(table, columns) for table, columns in rows.items()}
                seconds, frames = seconds + spent, frames + sequence.frames
    in_order = [answers[index] for index in range(first, last)]
    written = {table: [rows[table] for rows in in_order if table in rows] for table in TABLES}
    facts = {"seconds": seconds, "frames": frames, "heights": bool(written["heights"]), "hardware": hardware()}
    facts["causal"] = causal
    return Part(groups=written, facts=facts)


Rows = dict[str, pa.Table]
"""The rows of a sequence's answer, by table."""


def _read(dataset: Dataset, group: IntArray) -> Iterator[Sequence]:
    """The sequences of a group, in its order; consecutive ones are read together."""
    if np.array_equal(group, np.arange(group[0], group[0] + len(group))):
        return dataset.sequences(int(group[0]), int(group[0]) + len(group))
    return map(dataset.sequence, group.tolist())
