"""Makes datasets and submissions only if they do not exist yet, so that long work continues where it stopped."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.generation import generate, write_dataset
from vbbench.generation.generator import Generator, Options, Plan
from vbbench.generation.thinning import thinned
from vbbench.registry import load
from vbbench.scoring import score
from vbbench.scoring.scorecard import Score
from vbbench.solving import solve, solver_version

OTHERWISE = "choose another folder, or set overwrite to replace it"


def ensure_dataset(split: str, folder: Path, options: Options, *, jobs: int = 1, overwrite: bool = False) -> Dataset:
    """The dataset in ``folder``, generated unless it exists with the id that these options give.

    Parameters
    ----------
    overwrite : generate it in any case, and replace an existing dataset.

    Raises
    ------
    VbbenchError
        If ``folder`` holds another dataset, or as `vbbench.generation.datasets.generate` does.
    """
    if overwrite or not (folder / INFO_FILE).is_file():
        return generate(split, folder, options, jobs=jobs, overwrite=overwrite)
    generator: Generator = load("generator", split)
    return _existing(folder, thinned(generator.plan(options), options.stride))


def ensure_planned(plan: Plan, folder: Path, *, jobs: int = 1, overwrite: bool = False) -> Dataset:
    """As `ensure_dataset`, of a plan that no command could make."""
    if overwrite or not (folder / INFO_FILE).is_file():
        return write_dataset(plan, folder, jobs=jobs, overwrite=overwrite)
    return _existing(folder, plan)


def _existing(folder: Path, plan: Plan) -> Dataset:
    there, wanted = DatasetInfo.read(folder).id, plan.info.id
    if there != wanted:
        raise VbbenchError(f"{folder} is dataset {there}, wanted is {wanted}; {OTHERWISE}")
    return Dataset(folder)


def ensure_scores(
    dataset: Dataset, solvers: Sequence[str], protocol: str, *, jobs: int = 1, overwrite: bool = False
) -> Iterator[tuple[str, Score]]:
    """Each solver and its score; submissions are beside the dataset's folder, see `ensure_submission`."""
    for solver in dict.fromkeys(solvers):
        folder = dataset.folder.with_name(f"{protocol}-{solver.replace(':', '-')}")
        ensure_submission(dataset, solver, protocol, folder, jobs=jobs, overwrite=overwrite)
        yield solver, score(folder, dataset.folder)


def ensure_submission(
    dataset: Dataset, solver: str, protocol: str, folder: Path, *, jobs: int = 1, overwrite: bool = False
) -> Path:
    """The submission in ``folder``, solved unless it exists for the same dataset, solver, version and protocol.

    Changed code of a solver is not noticed if its version stays the same: overwrite then.

    Parameters
    ----------
    overwrite : solve in any case, and replace an existing submission.

    Raises
    ------
    VbbenchError
        If ``folder`` holds another submission, or as `vbbench.solving.submissions.solve` does.
    """
    if overwrite or not (folder / SUBMISSION_FILE).is_file():
        return solve(dataset, solver, protocol, folder, jobs=jobs, overwrite=overwrite)
    info = SubmissionInfo.read(folder)
    there = f"{info.solver} {info.version}, {info.protocol}, dataset {info.dataset}"
    wanted = f"{solver} {solver_version(solver)}, {protocol}, dataset {dataset.info.id}"
    if there != wanted:
        raise VbbenchError(f"{folder} is of {there}; wanted is {wanted}; {OTHERWISE}")
    return folder
