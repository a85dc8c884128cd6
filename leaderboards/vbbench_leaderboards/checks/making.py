"""Makes the datasets and submissions of a rerun in a work folder; what is whole there and of the same code is kept."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from vbbench import __version__
from vbbench.files.dataset import Dataset
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation import generate, generate_partitioned
from vbbench.parallel.partitions import merge
from vbbench.registry import Kind
from vbbench.solving import solve
from vbbench.solving.provenance import source_digest
from vbbench_leaderboards.checks.bundled import bundled_solvers
from vbbench_leaderboards.results.boards import BoardSource, is_diagnostic
from vbbench_leaderboards.results.folder import dataset_folder, submission_folder
from vbbench_leaderboards.results.result import Board


@dataclass(frozen=True, kw_only=True)
class Workshop:
    """Where a rerun makes its files.

    Parameters
    ----------
    room : folder for ``datasets/SPLIT-TIER`` and ``submissions/SPLIT/PROTOCOL-TIER/SOLVER``.
    seed : of every dataset.
    fresh : use nothing of the room again.
    together : solve with bundled solvers in one process a board, as diagnostics always are, for tests show that they
        remember nothing; others are solved in a fresh process for each group of sequences that share no moment.
    jobs : processes that generate.
    scheduler, tls : address of a Dask cluster that generates and solves instead, and the folder of its certificates;
        this process merges and scores.
    """

    room: Path
    seed: int
    fresh: bool = False
    together: bool = False
    jobs: int = 1
    scheduler: str | None = None
    tls: Path | None = None

    def dataset(self, source: BoardSource) -> Dataset:
        """The dataset of a split and tier's boards."""
        folder, options = dataset_folder(self.room, source.split, source.tier), source.options(self.seed)

        def make() -> None:
            if self.scheduler is None:
                generate(source.split, folder, options, jobs=self.jobs, overwrite=True)
            else:
                generate_partitioned(
                    source.split, folder, options, scheduler=self.scheduler, tls=self.tls, overwrite=True
                )
                merge(folder)

        self._make(folder, f"{code_of('generator', source.split)} {options}", make)
        return Dataset(folder)

    def submission(self, dataset: Dataset, board: Board, solver: str) -> Path:
        """A solver's submission to a board."""
        folder, apart = submission_folder(self.room, board, solver), self._is_apart(board, solver)

        def make() -> None:
            solve(
                dataset,
                solver,
                board.protocol,
                folder,
                scheduler=self.scheduler,
                tls=self.tls,
                fresh_processes=apart,
                overwrite=True,
            )
            if self.scheduler is not None:
                merge(folder)

        self._make(folder, f"{code_of('solver', solver)} {dataset.info.id}{' in fresh processes' * apart}", make)
        return folder

    def _is_apart(self, board: Board, solver: str) -> bool:
        """Whether a solver is kept from learning in one sequence what another asks; diagnostics rank nobody."""
        return solver not in bundled_solvers() or not (self.together or is_diagnostic(board))

    def _make(self, folder: Path, code: str, make: Callable[[], object]) -> None:
        """Make a folder, unless the note beside it names that code, and every file is as it was then."""
        note = folder.with_name(folder.name + ".made-by")
        if self.fresh or not (note.is_file() and note.read_text("utf-8") == _note_text(code, folder)):
            note.unlink(missing_ok=True)  # what is made next is not up to date before it is whole
            make()
            write_text_atomically(note, _note_text(code, folder))


@cache
def code_of(kind: Kind, name: str) -> str:
    """A hash of the files of vbbench, and of those that ``name`` comes from, after vbbench's version."""
    return f"{__version__} {source_digest('vbbench')} {source_digest(name, kind)}"


def _note_text(code: str, folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return "".join([f"{code}\n", *(f"{file_sha256(path)}  {path.relative_to(folder)}\n" for path in files)])
