"""The grid of a study: datasets, protocols and solvers. Each dataset and submission is made unless it exists already.

Long work therefore continues where it stopped.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product, starmap
from pathlib import Path
from typing import Any

from vbbench.errors import SourceMissingError, UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.folders.locks import loose_files
from vbbench.generation import generate, write_dataset
from vbbench.generation.generator import Generator, Options, Plan
from vbbench.generation.planning import planned
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench.protocol import get_protocol
from vbbench.registry import load, make_solver
from vbbench.reproduction.report import Report
from vbbench.scoring import score
from vbbench.scoring.scorecard import Score, Summary
from vbbench.solving import solve, solver_version

Row = dict[str, Any]
"""What was measured at one place of the grid: its axes by name, and its figures."""
OTHERWISE = "choose another folder, or set `overwrite` to replace it"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One solver's scored submission to one dataset under one protocol.

    Parameters
    ----------
    at : the dataset's place in the study's grid.
    """

    at: Any
    dataset: Dataset
    protocol: str
    solver: str
    submission: Path
    score: Score

    @property
    def summaries(self) -> Mapping[str, Summary]:
        """Figures by metric."""
        return self.score.summaries


@dataclass(frozen=True, kw_only=True)
class Making:
    """Makes what is missing: by ``jobs`` processes, or on the Dask cluster at ``scheduler``.

    With ``overwrite`` all is made again.
    """

    jobs: int = 1
    scheduler: str | None = None
    overwrite: bool = False

    def dataset(self, split: str, folder: Path, options: Options) -> Dataset:
        """The dataset in ``folder``, generated unless it exists with the id that these options give.

        Raises VbbenchError if ``folder`` holds another dataset, or as `vbbench.generation.datasets.generate` does.
        """
        plan = planned(split, options)
        if self.scheduler is None or (not self.overwrite and (folder / INFO_FILE).is_file()):
            return self.planned(plan, folder)
        return generate(split, folder, options, scheduler=self.scheduler, overwrite=self.overwrite)

    def planned(self, plan: Plan, folder: Path) -> Dataset:
        """As `dataset`, of a plan that no command can make; a cluster does not make it either."""
        if self.overwrite or not (folder / INFO_FILE).is_file():
            return write_dataset(plan, folder, jobs=self.jobs, overwrite=self.overwrite)
        there, wanted = DatasetInfo.read(folder).id, plan.info.id
        if there != wanted:
            raise VbbenchError(f"{folder} is dataset {there}, wanted is {wanted}; {OTHERWISE}")
        return Dataset(folder)

    def submission(self, dataset: Dataset, solver: str, protocol: str, folder: Path) -> Path:
        """The submission in ``folder``, solved unless it exists for the same dataset, solver, version and protocol.

        Changed code of a solver is not noticed if its version stays the same: overwrite then.

        Raises VbbenchError if ``folder`` holds another submission, or as `vbbench.solving.submissions.solve` does.
        """
        if self.overwrite or not (folder / SUBMISSION_FILE).is_file():
            where: dict[str, Any] = {"scheduler": self.scheduler, "overwrite": self.overwrite}
            return solve(dataset, solver, protocol, folder, jobs=self.jobs, **where)
        info = SubmissionInfo.read(folder)
        there = f"{info.solver} {info.version}, {info.protocol}, dataset {info.dataset}"
        wanted = f"{solver} {solver_version(solver)}, {protocol}, dataset {dataset.info.id}"
        if there != wanted:
            raise VbbenchError(f"{folder} is of {there}; wanted is {wanted}; {OTHERWISE}")
        return folder

    def cell(self, dataset: Dataset, solver: str, protocol: str, at: Any = None) -> Cell:
        """One solver's cell; its submission lies next to the dataset's folder."""
        folder = dataset.folder.with_name(f"{protocol}-{solver.replace(':', '-')}")
        made = self.submission(dataset, solver, protocol, folder)
        scored = score(made, dataset.folder)
        return Cell(at=at, dataset=dataset, protocol=protocol, solver=solver, submission=made, score=scored)

    def cells(self, dataset: Dataset, solvers: Iterable[str], protocols: Iterable[str], at: Any = None) -> list[Cell]:
        """The cells of every protocol and solver on one dataset."""
        pairs = product(dict.fromkeys(protocols), dict.fromkeys(solvers))
        return [self.cell(dataset, solver, protocol, at) for protocol, solver in pairs]


def each(
    function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], jobs: int, label: str, unit: str
) -> Iterator[Any]:
    """The results of all calls in order, with a progress bar, made by ``jobs`` processes."""
    with progress_bar(len(calls), label, unit=unit) as bar:
        for one in starmap(function, calls) if jobs == 1 else in_parallel(function, calls, jobs):
            yield one
            bar.update()


def rows_at(rows: Iterable[Row], **at: Any) -> list[Row]:
    """The rows with these values of their axes, in their order."""
    return [row for row in rows if all(row[axis] == value for axis, value in at.items())]


def row_at(rows: Iterable[Row], **at: Any) -> Row:
    """The only row with these values of its axes."""
    (row,) = rows_at(rows, **at)
    return row


def distinct(rows: Iterable[Row], axis: str) -> list[Any]:
    """The values of an axis, in the order of the rows."""
    return list(dict.fromkeys(row[axis] for row in rows))


class Study(ABC):
    """A table or figure of the paper: what is measured on which grid, and how it is reported."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Of its command and its files."""

    @abstractmethod
    def check(self) -> None:
        """Raise VbbenchError for what is invalid, before the work starts."""

    @abstractmethod
    def measure(self, out: Path, making: Making) -> Any:
        """Make, solve and score; datasets and submissions are kept in ``out``, and complete ones reused."""

    @abstractmethod
    def report(self, found: Any) -> Report:
        """What was measured, as tables, numbers and pictures."""

    def run(self, out: Path | str, making: Making = Making()) -> Report:
        """The report, measured in the folder ``out``.

        Raises VbbenchError if the study is invalid, a source cannot be read, or another dataset or submission is in the
        way.
        """
        self.check()
        with loose_files(Path(out)):
            found = self.measure(Path(out), making)
        return self.report(found)


def check_every(every: int) -> None:
    """Raise VbbenchError if ``every`` is not a number of sequences."""
    if every < 1:
        raise VbbenchError(f"every must be 1 or more, not {every}; 6 measures every sixth sequence")


def check_grid(solvers: Iterable[str], protocols: Iterable[str]) -> None:
    """Raise VbbenchError if there is no protocol or solver, or one is unknown."""
    protocols, solvers = list(protocols), list(solvers)
    if not (solvers and protocols):
        raise VbbenchError("nothing to measure: name a solver and a protocol")
    for protocol in protocols:
        get_protocol(protocol)
    for solver in solvers:
        make_solver(solver)


def check_splits(splits: Sequence[str], known: Sequence[str], kind: str) -> None:
    """Raise VbbenchError if there is no split, or one is not ``known``."""
    if not splits:
        raise VbbenchError(f"nothing to measure: name a split of {', '.join(known)}")
    for split in splits:
        if split not in known:
            raise UnknownNameError(kind, split, known)


def stride_of(every: int) -> int | None:
    """The stride of `vbbench.generation.generator.Options` for every so-many-th sequence."""
    return None if every == 1 else every


def plan_if_here(split: str, source: Path | None, seed: int) -> Plan | None:
    """The split with its default options, from the user's own ``source`` if there is one; ``None`` if it is missing."""
    generator: Generator = load("generator", split)
    try:
        return generator.plan(Options(source=source, seed=seed))
    except SourceMissingError:
        if source is not None:
            raise
        return None


def how_to_get(split: str) -> str:
    """The command that downloads a split's source, or the option that names the user's own download."""
    generator: Generator = load("generator", split)
    return f"`vbbench fetch {split}`" if generator.card.sources else f"your own download, named with `--{split} DIR`"
