"""Makes datasets and submissions only if they do not exist yet, so that long work continues where it stopped."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.generation import generate, generate_partitioned, write_dataset
from vbbench.generation.generator import Options, Plan
from vbbench.generation.planning import planned
from vbbench.parallel.partitions import merge
from vbbench.reproduction.work import Work
from vbbench.scoring import score
from vbbench.scoring.scorecard import Score
from vbbench.solving import solve, solver_version

OTHERWISE = "choose another folder, or set `overwrite` to replace it"


@dataclass(frozen=True, kw_only=True)
class Making(Work):
    """Makes what is missing where the work is done."""

    @property
    def here(self) -> "Making":
        """The same without a cluster, in one process: for work that is itself done side by side."""
        return replace(self, jobs=1, scheduler=None, tls=None)

    def dataset(self, split: str, folder: Path, options: Options) -> Dataset:
        """The dataset in ``folder``, generated unless it exists with the id that these options give.

        Raises
        ------
        VbbenchError
            If ``folder`` holds another dataset, or as `vbbench.generation.datasets.generate` does.
        """
        if not self.overwrite and (folder / INFO_FILE).is_file():
            return _existing(folder, planned(split, options))
        if self.scheduler is None:
            return generate(split, folder, options, jobs=self.jobs, overwrite=self.overwrite)
        generate_partitioned(split, folder, options, scheduler=self.scheduler, tls=self.tls, overwrite=self.overwrite)
        return Dataset(merge(folder))

    def planned(self, plan: Plan, folder: Path) -> Dataset:
        """As `dataset`, of a plan that no command could make; a cluster does not make it either."""
        if self.overwrite or not (folder / INFO_FILE).is_file():
            return write_dataset(plan, folder, jobs=self.jobs, overwrite=self.overwrite)
        return _existing(folder, plan)

    def submission(self, dataset: Dataset, solver: str, protocol: str, folder: Path) -> Path:
        """The submission in ``folder``, solved unless it exists for the same dataset, solver, version and protocol.

        Changed code of a solver is not noticed if its version stays the same: overwrite then.

        Raises
        ------
        VbbenchError
            If ``folder`` holds another submission, or as `vbbench.solving.submissions.solve` does.
        """
        if not self.overwrite and (folder / SUBMISSION_FILE).is_file():
            return _existing_submission(dataset, solver, protocol, folder)
        made = solve(
            dataset,
            solver,
            protocol,
            folder,
            jobs=self.jobs,
            scheduler=self.scheduler,
            tls=self.tls,
            overwrite=self.overwrite,
        )
        return made if self.scheduler is None else merge(folder)

    def scores(self, dataset: Dataset, solvers: Sequence[str], protocol: str) -> Iterator[tuple[str, Score]]:
        """Each solver and its score; submissions are beside the dataset's folder."""
        for solver in dict.fromkeys(solvers):
            folder = submission_folder(dataset, solver, protocol)
            yield solver, score(self.submission(dataset, solver, protocol, folder), dataset.folder)


def submission_folder(dataset: Dataset, solver: str, protocol: str) -> Path:
    """Where `Making.scores` keeps a solver's submission: beside the dataset's folder."""
    return dataset.folder.with_name(f"{protocol}-{solver.replace(':', '-')}")


def _existing(folder: Path, plan: Plan) -> Dataset:
    there, wanted = DatasetInfo.read(folder).id, plan.info.id
    if there != wanted:
        raise VbbenchError(f"{folder} is dataset {there}, wanted is {wanted}; {OTHERWISE}")
    return Dataset(folder)


def _existing_submission(dataset: Dataset, solver: str, protocol: str, folder: Path) -> Path:
    info = SubmissionInfo.read(folder)
    there = f"{info.solver} {info.version}, {info.protocol}, dataset {info.dataset}"
    wanted = f"{solver} {solver_version(solver)}, {protocol}, dataset {dataset.info.id}"
    if there != wanted:
        raise VbbenchError(f"{folder} is of {there}; wanted is {wanted}; {OTHERWISE}")
    return folder
