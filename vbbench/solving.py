"""Runs a solver over a whole dataset and writes its submission."""

import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Any

import pyarrow as pa
from threadpoolctl import threadpool_limits

from vbbench import __version__
from vbbench.answer_rows import answer_rows
from vbbench.dataset import Dataset
from vbbench.errors import VbbenchError
from vbbench.isolation import IsolatedSolver
from vbbench.parallel import check_jobs
from vbbench.partitions import Layout, part_name, write_layout, write_partitions
from vbbench.parts import Part, Ranges, Work, part_ranges, prepare_draft, write_in_parts
from vbbench.protocol import Protocol, get_protocol
from vbbench.registry import held_out, make_solver, registered
from vbbench.runner import run_sequence, warm_up
from vbbench.schemas import to_arrow
from vbbench.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.tables import PARTITIONED, check_free, replace_folder, write_text_atomically

TABLES = ("poses", "positions", "heights")


def solve(
    dataset: Dataset,
    solver: str,
    protocol: str,
    out: Path | str,
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    tls: Path | None = None,
    isolate: bool = False,
    covariance: bool = False,
    overwrite: bool = False,
) -> Path:
    """Run the solver called ``solver`` (or named ``module:attribute``) and write the submission folder ``out``.

    A solver that was fitted on the dataset's split is run as the variant that was not (`registry.held_out`).
    Interrupted work goes on where it stopped when the same call is made again.

    Parameters
    ----------
    scheduler : address of a Dask cluster to run it on, whose workers see the dataset under the same path; the
        submission is then partitioned, and `merging.merge` makes it whole.
    tls : folder of the certificates that an address ``tls://HOST:PORT`` needs (`cluster.on_cluster`).
    isolate : run the solver in a process of its own, fed over a pipe, that never holds truth.
    covariance : write the covariances of poses and positions, too.

    Raises
    ------
    VbbenchError
        If a name is unknown, truth is needed but withheld, covariances are wanted of a solver that reports none, or
        ``out`` is in the way.
    """
    check_jobs(jobs)
    if tls and scheduler is None:
        raise VbbenchError("certificates are for a cluster; give its scheduler's address, tls://HOST:PORT")
    out, rules = Path(out), get_protocol(protocol)
    check_free(out, SUBMISSION_FILE, "submission", overwrite)
    if rules.needs_truth and not dataset.has_truth:
        raise VbbenchError(
            f"'{protocol}' needs truth while solving; use sequential or rollout, or name it with --truth"
        )
    run_as = held_out(solver, dataset.info.split)
    key = f"{dataset.info.id} {solver} {solver_version(solver)} {rules.id} {covariance} {__version__}"
    job = _Job(
        work=partial(_solve_part, dataset, run_as, rules, isolate, covariance),
        ranges=part_ranges(len(dataset), dataset.cells),
        label=f"{solver} {protocol}",
        declare=partial(_declared, dataset, solver, run_as, protocol),
    )
    draft = out.with_name(out.name + ".partial")
    if scheduler is None:
        _solve_here(job, draft, prepare_draft(draft, "parts", key), jobs)
    else:
        prepare_draft(draft, PARTITIONED, key)
        _solve_on_cluster(job, draft, scheduler, tls)
    replace_folder(draft, out)
    return out


@dataclass(frozen=True, kw_only=True)
class _Job:
    """What is to be done, cut into ``ranges``, and how its facts become ``submission.json``."""

    work: Work
    ranges: Ranges
    label: str
    declare: Callable[[list[dict[str, Any]]], SubmissionInfo]


def _solve_here(job: _Job, draft: Path, parts: Path, jobs: int) -> None:
    tables = {name: draft / f"{name}.parquet" for name in TABLES}
    facts = write_in_parts(job.work, job.ranges, parts, tables, jobs=jobs, label=job.label)
    for name in tables.keys() - _reported(facts):
        tables[name].unlink()
    write_text_atomically(draft / SUBMISSION_FILE, job.declare(facts).to_json())


def _solve_on_cluster(job: _Job, draft: Path, scheduler: str, tls: Path | None) -> None:
    facts = write_partitions(job.work, job.ranges, draft, scheduler, tls=tls, label=job.label)
    parts = [part_name(first) for first, _ in job.ranges]
    layout = Layout(marker=SUBMISSION_FILE, tables=_reported(facts), parts=parts)
    write_layout(draft, layout, job.declare(facts).to_json())


def _reported(facts: list[dict[str, Any]]) -> list[str]:
    """The tables of a submission: heights only where a part has some."""
    return [name for name in TABLES if name != "heights" or any(part["heights"] for part in facts)]


def _declared(dataset: Dataset, solver: str, run_as: str, protocol: str, facts: list[dict[str, Any]]) -> SubmissionInfo:
    seconds, frames = (sum(part[name] for part in facts) for name in ("seconds", "frames"))
    return SubmissionInfo(
        solver=solver,
        version=solver_version(solver),
        dataset=dataset.info.id,
        protocol=protocol,
        seconds_per_frame=seconds / max(frames, 1),
        hardware="; ".join(sorted({part["hardware"] for part in facts})),
        reference="" if run_as == solver else f"run as {run_as}, which was not fitted on {dataset.info.split}",
    )


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
    with _warm_solver(dataset, name, protocol, isolate, covariance, first) as solver:
        for sequence in dataset.sequences(first, last):
            truth = dataset.truth(sequence) if protocol.needs_truth else None
            problem = dataset.problem(sequence, covariances=covariance)
            estimate, spent = run_sequence(solver, problem, sequence, protocol, truth)
            for table, rows in answer_rows(sequence, protocol, estimate, covariance).items():
                groups[table].append(to_arrow(table, rows))
            seconds, frames = seconds + spent, frames + sequence.frames
    facts = {"seconds": seconds, "frames": frames, "heights": bool(groups["heights"]), "hardware": hardware()}
    return Part(groups=groups, facts=facts)


@contextmanager
def _warm_solver(
    dataset: Dataset, name: str, protocol: Protocol, isolate: bool, covariance: bool, first: int
) -> Iterator[Any]:
    """The solver, compiled, and on one thread: rounding differs with their number, and with it what is ill-posed."""
    sample = dataset.sequence(first)
    with IsolatedSolver(name) if isolate else nullcontext(make_solver(name)) as solver:
        warm_up(solver, dataset.problem(sample, covariances=covariance), sample, protocol)
        with threadpool_limits(1):
            yield solver
