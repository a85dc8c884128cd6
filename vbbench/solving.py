"""Runs a solver over a whole dataset and writes its submission."""

import os
import platform
import shutil
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from vbbench.dataset import Dataset
from vbbench.errors import VbbenchError
from vbbench.isolation import IsolatedSolver
from vbbench.parts import Part, prepare_parts, write_in_parts
from vbbench.protocol import Protocol, get_protocol, scored_frames, scored_positions
from vbbench.registry import load, registered
from vbbench.runner import run_sequence, warm_up
from vbbench.schemas import to_arrow
from vbbench.sequence import Sequence
from vbbench.solver import Estimate
from vbbench.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.tables import check_free, write_text_atomically

TABLES = ("poses", "positions")


def solve(
    dataset: Dataset,
    solver: str,
    protocol: str,
    out: Path | str,
    *,
    jobs: int = 1,
    isolate: bool = False,
    overwrite: bool = False,
) -> Path:
    """Run the solver called ``solver`` (or named ``module:attribute``) and write the submission folder ``out``.

    Interrupted work goes on where it stopped when the same call is made again.

    Parameters
    ----------
    isolate : run the solver in a process of its own, fed over a pipe, that never holds truth.

    Raises
    ------
    VbbenchError
        If a name is unknown, truth is needed but withheld, or ``out`` is in the way.
    """
    out, rules = Path(out), get_protocol(protocol)
    check_free(out, SUBMISSION_FILE, "submission", overwrite)
    if rules.needs_truth and not dataset.has_truth:
        raise VbbenchError(
            f"'{protocol}' needs truth while solving; use sequential or rollout, or name it with --truth"
        )
    load("solver", solver)
    draft = out.with_name(out.name + ".partial")
    prepare_parts(draft / "parts", f"{dataset.info.id} {solver} {solver_version(solver)} {rules.id}")
    work = partial(_solve_part, dataset, solver, rules, isolate)
    tables = {name: draft / f"{name}.parquet" for name in TABLES}
    facts = write_in_parts(work, len(dataset), draft / "parts", tables, jobs=jobs, label=f"{solver} {protocol}")
    info = SubmissionInfo(
        solver=solver,
        version=solver_version(solver),
        dataset=dataset.info.id,
        protocol=protocol,
        seconds_per_frame=sum(part["seconds"] for part in facts) / max(sum(part["frames"] for part in facts), 1),
        hardware=hardware(),
    )
    write_text_atomically(draft / SUBMISSION_FILE, info.to_json())
    shutil.rmtree(out, ignore_errors=True)
    draft.replace(out)
    return out


def solver_version(solver: str) -> str:
    """Version of the distribution that a solver comes from, or ``unknown``."""
    point = registered("solver").get(solver)
    module = (point.value if point else solver).partition(".")[0].partition(":")[0]
    names = [point.dist.name] if point and point.dist else packages_distributions().get(module, [])
    try:
        return version(names[0]) if names else "unknown"
    except PackageNotFoundError:
        return "unknown"


def hardware() -> str:
    """What the solver ran on, for the reader of its seconds a frame."""
    names = [line.partition(":")[2].strip() for line in _cpu_lines() if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, {os.cpu_count()} cores"


def _cpu_lines() -> list[str]:
    path = Path("/proc/cpuinfo")
    return path.read_text("utf-8", "replace").splitlines() if path.is_file() else []


def _solve_part(dataset: Dataset, name: str, protocol: Protocol, isolate: bool, first: int, last: int) -> Part:
    groups: dict[str, list[pa.Table]] = {table: [] for table in TABLES}
    total = {"seconds": 0.0, "frames": 0}
    with _solver(name, isolate) as solver:
        sample = dataset.sequence(first)
        warm_up(solver, dataset.problem(sample), sample, protocol)
        for sequence in dataset.sequences(first, last):
            truth = dataset.truth(sequence) if protocol.needs_truth else None
            estimate, seconds = run_sequence(solver, dataset.problem(sequence), sequence, protocol, truth)
            for table, rows in submitted_rows(sequence, protocol, estimate).items():
                groups[table].append(to_arrow(table, rows))
            total = {"seconds": total["seconds"] + seconds, "frames": total["frames"] + sequence.frames}
    return Part(groups=groups, facts=total)


def _solver(name: str, isolate: bool) -> AbstractContextManager[Any]:
    return IsolatedSolver(name) if isolate else nullcontext(load("solver", name)())


def submitted_rows(sequence: Sequence, protocol: Protocol, estimate: Estimate) -> dict[str, dict[str, Any]]:
    """The columns of ``poses`` and ``positions``: what is scored, and nothing else."""
    observed, given = sequence.observed, protocol.select_given(sequence.given)
    frame = np.flatnonzero(scored_frames(observed))
    x, y, yaw = estimate.poses[frame].T
    poses = {"sequence": np.full(len(frame), sequence.index), "frame": frame, "x": x, "y": y, "yaw": yaw}
    frame, column = np.nonzero(scored_positions(observed, given))
    x, y = estimate.positions[frame, column].T
    where = {"sequence": np.full(len(frame), sequence.index), "frame": frame, "track": sequence.tracks[column]}
    return {"poses": poses, "positions": {**where, "x": x, "y": y}}
