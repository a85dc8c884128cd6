"""Runs a solver over a whole dataset and writes its submission."""

import os
import platform
import shutil
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Any

import pyarrow as pa

from vbbench.answer_rows import answer_rows
from vbbench.dataset import Dataset
from vbbench.errors import VbbenchError
from vbbench.isolation import IsolatedSolver
from vbbench.parts import Part, prepare_parts, write_in_parts
from vbbench.protocol import Protocol, get_protocol
from vbbench.registry import make_solver, registered
from vbbench.runner import run_sequence, warm_up
from vbbench.schemas import to_arrow
from vbbench.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.tables import check_free, write_text_atomically

TABLES = ("poses", "positions", "heights")


def solve(
    dataset: Dataset,
    solver: str,
    protocol: str,
    out: Path | str,
    *,
    jobs: int = 1,
    isolate: bool = False,
    covariance: bool = False,
    overwrite: bool = False,
) -> Path:
    """Run the solver called ``solver`` (or named ``module:attribute``) and write the submission folder ``out``.

    Interrupted work goes on where it stopped when the same call is made again.

    Parameters
    ----------
    isolate : run the solver in a process of its own, fed over a pipe, that never holds truth.
    covariance : write the covariances of poses and positions, too.

    Raises
    ------
    VbbenchError
        If a name is unknown, truth is needed but withheld, covariances are wanted of a solver that reports none, or
        ``out`` is in the way.
    """
    out, rules = Path(out), get_protocol(protocol)
    check_free(out, SUBMISSION_FILE, "submission", overwrite)
    if rules.needs_truth and not dataset.has_truth:
        raise VbbenchError(
            f"'{protocol}' needs truth while solving; use sequential or rollout, or name it with --truth"
        )
    make_solver(solver)
    draft = out.with_name(out.name + ".partial")
    prepare_parts(draft / "parts", f"{dataset.info.id} {solver} {solver_version(solver)} {rules.id} {covariance}")
    work = partial(_solve_part, dataset, solver, rules, isolate, covariance)
    tables = {name: draft / f"{name}.parquet" for name in TABLES}
    facts = write_in_parts(work, len(dataset), draft / "parts", tables, jobs=jobs, label=f"{solver} {protocol}")
    if not any(part["heights"] for part in facts):
        tables["heights"].unlink()
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


def _solve_part(
    dataset: Dataset, name: str, protocol: Protocol, isolate: bool, covariance: bool, first: int, last: int
) -> Part:
    groups: dict[str, list[pa.Table]] = {table: [] for table in TABLES}
    seconds, frames = 0.0, 0
    with _solver(name, isolate) as solver:
        sample = dataset.sequence(first)
        warm_up(solver, dataset.problem(sample), sample, protocol)
        for sequence in dataset.sequences(first, last):
            truth = dataset.truth(sequence) if protocol.needs_truth else None
            estimate, spent = run_sequence(solver, dataset.problem(sequence), sequence, protocol, truth)
            for table, rows in answer_rows(sequence, protocol, estimate, covariance).items():
                groups[table].append(to_arrow(table, rows))
            seconds, frames = seconds + spent, frames + sequence.frames
    return Part(groups=groups, facts={"seconds": seconds, "frames": frames, "heights": bool(groups["heights"])})


def _solver(name: str, isolate: bool) -> AbstractContextManager[Any]:
    return IsolatedSolver(name) if isolate else nullcontext(make_solver(name))
