"""Makes every published result again: datasets, submissions, scores; and says what drifted."""

import hashlib
import itertools
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path

from vbbench import __version__
from vbbench.errors import FileError, SourceMissingError
from vbbench.files.dataset import Dataset
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.generation.tier import get_tier
from vbbench.protocol import PROTOCOLS
from vbbench.registry import Kind, load, registered
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_leaderboards.checks.drift import drift, record_faults
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, record_path, write_dataset
from vbbench_leaderboards.results.folder import SPLITS, dataset_folder, submission_folder
from vbbench_leaderboards.results.result import Board, Result, read_result, write_result

REFERENCES = {
    "cv": "Constant-velocity extrapolation, bundled with vbbench (baseline CV of arXiv 2111.05060)",
    "sf": "Social-force extrapolation, bundled with vbbench (baseline SF of arXiv 2111.05060)",
    "vb-cv": "View birdification with constant velocity, bundled with vbbench "
    "(VB-CV of arXiv 2111.05060, with changes)",
    "vb-sf": "View birdification with the social force, bundled with vbbench (VB-SF of arXiv 2111.05060, with changes)",
    "map-causal": "Joint maximum a posteriori over a sliding window, causal, bundled with vbbench "
    "(motion prior fitted on other recordings)",
    "map-batch": "Joint maximum a posteriori over whole sequences, bundled with vbbench "
    "(motion prior fitted on other recordings)",
}
"""What the board says of the bundled solvers."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of one file: the lines ``found`` say how it drifted, and ``updated`` whether it was written anew."""

    path: Path
    found: tuple[str, ...]
    updated: bool

    @property
    def is_drift(self) -> bool:
        """Whether the file is now behind."""
        return bool(self.found) and not self.updated

    @property
    def text(self) -> str:
        """One line, and one more for each thing that drifted."""
        state = "as committed" if not self.found else "written anew" if self.updated else "drifted"
        return "\n  ".join([f"{self.path}: {state}", *self.found])


@dataclass(frozen=True, kw_only=True)
class Rerun:
    """A run over boards.

    Parameters
    ----------
    results : folder of the result files.
    work : folder for ``datasets/SPLIT-TIER`` and ``submissions/SPLIT/PROTOCOL-TIER/SOLVER``.
    update : write what drifted and what is new.
    fresh : use nothing of the work folder again.
    jobs : processes.
    """

    results: Path
    work: Path
    update: bool = False
    fresh: bool = False
    jobs: int = 1

    def boards(
        self, splits: Sequence[str] = (), solvers: Sequence[str] = (), tiers: Sequence[str] = ("ideal", "noisy")
    ) -> Iterator[Outcome]:
        """Outcome of every dataset record and every result; without names those of all that is published.

        Raises
        ------
        VbbenchError
            If a name is unknown, or the sources of a named split are missing; those of others are said and left out.
        """
        chosen = solvers or bundled_solvers()
        for name in chosen:
            load("solver", name)
        for tier in tiers:
            get_tier(tier)
        for split, tier in itertools.product(splits or SPLITS, tiers):
            try:
                dataset = self.dataset(split, tier)
            except SourceMissingError as error:
                if splits:
                    raise
                sys.stderr.write(f"vbbench: {split} {tier} is left out: {error}\n")
                continue
            yield self._record(dataset)
            for protocol, solver in itertools.product(PROTOCOLS, chosen):
                yield self._result(dataset, protocol, solver)

    def dataset(self, split: str, tier: str) -> Dataset:
        """The dataset of a split's boards: its own camera, seed 0."""
        folder = dataset_folder(self.work, split, tier)
        make = partial(generate, split, folder, Options(tier=tier), jobs=self.jobs, overwrite=True)
        self._make(folder, code_of("generator", split), make)
        return Dataset(folder)

    def submission(self, dataset: Dataset, protocol: str, solver: str) -> Path:
        """A solver's submission."""
        board = Board(split=dataset.info.split, tier=dataset.info.tier, protocol=protocol)
        folder = submission_folder(self.work, board, solver)
        make = partial(solve, dataset, solver, protocol, folder, jobs=self.jobs, overwrite=True)
        self._make(folder, f"{code_of('solver', solver)} {dataset.info.id}", make)
        return folder

    def _make(self, folder: Path, code: str, make: Callable[[], object]) -> None:
        """Make a folder, unless the note beside it names that code, and every file is as it was then."""
        note = folder.with_name(folder.name + ".made-by")
        if self.fresh or not (note.is_file() and note.read_text("utf-8") == _note_text(code, folder)):
            note.unlink(missing_ok=True)  # what is made next is not up to date before it is whole
            make()
            write_text_atomically(note, _note_text(code, folder))

    def _record(self, dataset: Dataset) -> Outcome:
        path = record_path(dataset.info.split, dataset.info.tier)
        kept = self.results / path
        found = _differences(kept, lambda: record_faults(read_dataset(kept), dataset.folder), "no record was kept")
        if found and self.update:
            write_dataset(BoardDataset.of(dataset), self.results)
        return Outcome(path=path, found=tuple(found), updated=self.update)

    def _result(self, dataset: Dataset, protocol: str, solver: str) -> Outcome:
        folder = self.submission(dataset, protocol, solver)
        judged = score(folder, dataset.folder)
        fresh = Result.of(judged, folder, name=solver, reference=REFERENCES.get(solver, ""))
        kept = self.results / fresh.path
        found = _differences(kept, lambda: drift(read_result(kept), fresh), "no result was kept")
        if found and self.update:
            write_result(fresh, self.results)
        return Outcome(path=fresh.path, found=tuple(found), updated=self.update)


def _differences(kept: Path, differences: Callable[[], Iterable[str]], missing: str) -> list[str]:
    """What is new against the file ``kept``; one that cannot be used differs, too."""
    if not kept.is_file():
        return [missing]
    try:
        return list(differences())
    except FileError as error:
        return [str(error)]


def bundled_solvers() -> list[str]:
    """Names of the solvers that come with vbbench and stand on its boards."""
    return sorted(REFERENCES)


def code_of(kind: Kind, name: str) -> str:
    """A hash of the source files of vbbench and of the package that ``name`` comes from, after vbbench's version."""
    point = registered(kind).get(name)
    module = (point.value if point else name).partition(":")[0].partition(".")[0]
    return f"{__version__} {_hash_of_source('vbbench')[:16]} {_hash_of_source(module)[:16]}"


def _note_text(code: str, folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return "".join([f"{code}\n", *(f"{file_sha256(path)}  {path.relative_to(folder)}\n" for path in files)])


@cache
def _hash_of_source(module: str) -> str:
    spec = find_spec(module)
    roots = [Path(place) for place in (spec.submodule_search_locations or [])] if spec else []
    files = sorted(path for root in roots for path in root.rglob("*") if path.suffix in (".py", ".toml"))
    if spec and spec.origin and not roots:
        files = [Path(spec.origin)]
    whole = hashlib.sha256()
    for path in files:
        whole.update(f"{path.name}\0".encode() + path.read_bytes())
    return whole.hexdigest()
