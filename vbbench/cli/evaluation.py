"""Commands that run solvers and score their answers: solvers, solve, score, compare."""

from pathlib import Path
from typing import Literal

from vbbench.table import Format

ProtocolName = Literal["one-step", "sequential", "rollout", "cold-start"]


def solvers() -> None:
    """List every solver: its package, how it works, what it is."""
    from vbbench.solving.provenance import describe_solvers

    print(describe_solvers())


def solve(
    folder: Path,
    /,
    solver: str,
    out: Path,
    protocol: ProtocolName = "sequential",
    truth: Path | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    isolate: bool = False,
    fresh_processes: bool = False,
    covariance: bool = False,
    overwrite: bool = False,
) -> None:
    """Run a solver over a dataset and write its submission.

    Args:
        folder: The dataset.
        solver: A registered name ('vbbench solvers' lists them), or module:attribute of your own.
        out: Submission folder to make.
        protocol: Which truth the solver is given, and when.
        truth: Folder with the truth tables, if they are not in the dataset (one-step needs them).
        jobs: Processes; the answers do not depend on it.
        scheduler: Address of a Dask cluster (tcp://...) that does the work instead.
        isolate: Run the solver in a separate process that never holds truth.
        fresh_processes: Isolate it in a new process for each group of sequences that share no frame of a scene, so that
            nothing learned in one answers another.
        covariance: Also write the covariances of poses and positions that the solver reports.
        overwrite: Replace an existing submission.
    """
    from vbbench.files.dataset import Dataset
    from vbbench.solving.submissions import solve as run

    print(
        run(
            Dataset(folder, truth),
            solver,
            protocol,
            out,
            jobs=jobs,
            scheduler=scheduler,
            isolate=isolate,
            fresh_processes=fresh_processes,
            covariance=covariance,
            overwrite=overwrite,
        )
    )


def check(submission: Path, /, dataset: Path) -> None:
    """Check everything about a submission that needs no truth, and list every fault.

    Args:
        submission: Folder with submission.json, poses and positions (.parquet or .csv).
        dataset: The dataset that it answers; its truth is not read.
    """
    from vbbench.files.dataset import Dataset
    from vbbench.scoring.answers import check_submission

    print(check_submission(submission, Dataset(dataset)).table())


def score(
    submissions: tuple[Path, ...],
    /,
    dataset: Path,
    truth: Path | None = None,
    json: bool = False,
    format: Format = "text",  # noqa: A002
    per_sequence: Path | None = None,
) -> None:
    """Score a submission against a dataset's truth, or several side by side.

    Exit status 2 means that a submission has faults; all of them are listed.

    Args:
        submissions: Folders with submission.json, poses and positions (.parquet or .csv).
        dataset: The dataset that they answer.
        truth: Folder with the truth tables, if they are not in the dataset.
        json: Machine-readable; the same as --format json.
        format: Of the table: text, markdown, latex (with booktabs), csv or json.
        per_sequence: CSV file to write with one row per sequence of one submission.
    """
    from vbbench.errors import VbbenchError
    from vbbench.scoring.comparison import SideBySide, score_several
    from vbbench.scoring.scores import score as judge

    if not submissions:
        raise VbbenchError("which submission? give one folder or more, see 'vbbench score --help'")
    form = "json" if json else format
    if len(submissions) > 1:
        if per_sequence is not None:
            raise VbbenchError("--per-sequence is of one submission; score them one by one")
        print(score_several(submissions, dataset, truth).write(form))
        return
    result = judge(submissions[0], dataset, truth)
    if per_sequence is not None:
        result.write_per_sequence(per_sequence)
    if form in ("text", "json"):
        print(result.to_json() if form == "json" else result.table())
    else:
        print(SideBySide(scores={submissions[0]: result}).write(form))


def compare(
    submission_a: Path,
    submission_b: Path,
    /,
    dataset: Path,
    truth: Path | None = None,
    json: bool = False,
) -> None:
    """Compare two submissions sequence by sequence (block bootstrap over time).

    Args:
        submission_a: One submission.
        submission_b: The other.
        dataset: The dataset that both answer.
        truth: Folder with the truth tables, if they are not in the dataset.
        json: Machine-readable.
    """
    from vbbench.scoring.comparison import compare as judge

    result = judge(submission_a, submission_b, dataset, truth)
    print(result.to_json() if json else result.table())
