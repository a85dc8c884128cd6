"""Makes every published result again, with another seed, and reports which stand.

A dataset with the seed of its boards must give the committed figures to the last digits. With another seed, noise and
crowds differ, and a result stands when the new figures agree with it within the uncertainty of both.
"""

import secrets
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass, replace
from functools import cache
from io import StringIO
from pathlib import Path
from typing import TypeVar

import numpy as np

from vbbench import __version__
from vbbench.errors import FileError, SourceMissingError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation import generate, generate_partitioned
from vbbench.generation.tier import get_tier
from vbbench.geometry import FloatArray
from vbbench.parallel.partitions import merge
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench.protocol import get_protocol
from vbbench.registry import Kind, load
from vbbench.scoring import score
from vbbench.scoring.block_bootstrap import Means, block_means
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import PerSequence, capped_figures
from vbbench.solving import solve
from vbbench.solving.provenance import source_digest
from vbbench.solving.submissions import declared_facts
from vbbench_leaderboards.checks.checking import drift, record_faults
from vbbench_leaderboards.results.boards import REFERENCES, BoardSource, bundled_solvers, chosen_sources, is_diagnostic
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, write_dataset
from vbbench_leaderboards.results.folder import dataset_folder, result_paths, submission_folder
from vbbench_leaderboards.results.result import About, Board, Result, read_result, write_result

LEVEL = 0.05

FEW = 0.1
"""Where the sequences are too few for an interval, capped means may differ by this share of the committed one."""

COUNTS = 0.2
"""Counts of another seed's dataset may differ by this share: crowds and those who are seen are others."""

_SAME = ("split", "tier", "title", "camera", "dt", "caution", "licence", "citation")
_COUNTED = ("sequences", "mean_frames", "people_mean", "observations")


def disagreements(kept: Result, fresh: Result, comparisons: int) -> list[str]:
    """The metrics whose capped mean drifted, one line each.

    Parameters
    ----------
    comparisons : results that the whole run compares.
    """
    one, other = _shared(kept.per_sequence, fresh.per_sequence)
    if not len(one.sequence):
        return ["no sequence is scored in both; solve the whole dataset"]
    names, caps = [*section("metrics")], get_protocol(kept.board.protocol).caps
    old, new = (capped_figures(caps, {name: rows.figures[name] for name in names}) for rows in (one, other))
    found = block_means(one.timeline, new - old)
    level = LEVEL / (comparisons * len(names))
    return [*_lines(names, found, _mean(old), _mean(new), level)]


def _lines(names: list[str], found: Means, old: FloatArray, new: FloatArray, level: float) -> Iterator[str]:
    """What drifted: the means of the differences against the level of each, before and after [M]."""
    for name, difference, p, before, after in zip(names, found.mean, found.p_values(), old, new, strict=True):
        few = np.isnan(p)
        if np.isfinite(difference) and (abs(difference) > FEW * before if few else p < level):
            how = f"more than {FEW:.0%} apart" if few else f"p = {p:.1g}, below {level:.1g}"
            yield f"{name}: was {before:.4f}, is {after:.4f} with another seed ({how})"


def record_disagreements(kept: BoardDataset, fresh: BoardDataset) -> Iterator[str]:
    """Where the record of a dataset of another seed differs by more than its seed explains."""
    for name in _SAME:
        mine, theirs = getattr(kept, name), getattr(fresh, name)
        if mine != theirs:
            yield f"$.{name}: was {mine!r}, is {theirs!r}"
    for name in _COUNTED:
        before, after = kept.counts[name], fresh.counts[name]
        if abs(after - before) > COUNTS * before:
            yield f"$.counts.{name}: was {before:.6g}, is {after:.6g}"


def _shared(one: PerSequence, other: PerSequence) -> tuple[PerSequence, PerSequence]:
    """The rows of the sequences that both have."""
    return one.select(np.isin(one.sequence, other.sequence)), other.select(np.isin(other.sequence, one.sequence))


def _mean(values: FloatArray) -> FloatArray:
    """The mean of each column [N, M] over the rows that have a figure."""
    there = np.isfinite(values)
    mean: FloatArray = np.where(there, values, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    return mean


AS_COMMITTED, STANDS, DRIFTED, WRITTEN = "as committed", "stands", "drifted", "written anew"
"""The same figures, figures that agree with another seed's, others, and others that were written."""

Kept = TypeVar("Kept", BoardDataset, Result)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of one file: its state, and lines that say how it drifted."""

    path: Path
    state: str
    found: tuple[str, ...] = ()

    @property
    def is_drift(self) -> bool:
        """Whether the file is now behind."""
        return bool(self.found) and self.state != WRITTEN

    @property
    def text(self) -> str:
        """One line, and one more for each thing that drifted."""
        return "\n  ".join([f"{self.path}: {self.state}", *self.found])


@dataclass(frozen=True, kw_only=True)
class Judge:
    """Holds fresh results against the folder of the committed ones.

    Parameters
    ----------
    results : the folder.
    comparisons : results that the whole run compares: the more, the less often chance may look like drift in each.
    update : write what drifted and what is new.
    by : who makes the figures again; written into rows that stand, with ``update``.
    """

    results: Path
    comparisons: int
    update: bool = False
    by: str = ""

    def outcomes(self, dataset: Dataset, fresh: Sequence[Result]) -> Iterator[Outcome]:
        """Outcomes of the dataset's record and of the fresh results on it.

        Where the committed files are of another dataset than the fresh ones, all of its boards are written or nothing:
        nobody is ranked beside others who solved something else.
        """
        record = BoardDataset.of(dataset)
        kept, found = self._kept(record.path, read_dataset), {}
        found[record.path] = self._record_differences(kept, record, dataset)
        moved = isinstance(kept, BoardDataset) and kept.id != record.id
        for one in fresh:
            found[one.path], elsewhere = self._result_differences(one)
            moved = moved or elsewhere
        drifted = any(found.values())
        strangers = self._strangers(record, found) if drifted and self.update and moved else []
        if drifted and self.update and not strangers:
            anew = set(found) if moved else {path for path, lines in found.items() if lines}
            self._write(record, [one for one in fresh if one.path in anew], record.path in anew)
            yield from (Outcome(path=p, state=WRITTEN, found=(*found[p],)) for p in found if p in anew)
            yield from (Outcome(path=p, state=AS_COMMITTED) for p in found if p not in anew)
            self._sign([one.path for one in fresh if one.path not in anew])
            return
        why = f"{DRIFTED}, and not written: {', '.join(strangers)} would stand on the old dataset; rerun them, too"
        behind, fine = why if strangers else DRIFTED, STANDS if moved else AS_COMMITTED
        for path, lines in found.items():
            yield Outcome(path=path, state=behind if lines else fine, found=tuple(lines))
        if self.update:
            self._sign([one.path for one in fresh if not found[one.path]])

    def _record_differences(self, kept: BoardDataset | str, record: BoardDataset, dataset: Dataset) -> list[str]:
        if isinstance(kept, str):
            return [kept]
        if kept.id == record.id:
            return [*record_faults(kept, dataset.folder)]
        another = [f"was {kept.id}, is {record.id} with the same seed: it is made in another way now"]
        return [*(another if kept.seed == record.seed else []), *record_disagreements(kept, record)]

    def _result_differences(self, fresh: Result) -> tuple[list[str], bool]:
        """How a fresh result differs from the committed one, and whether that is of another dataset."""
        kept = self._kept(fresh.path, read_result)
        if isinstance(kept, str):
            return [kept], False
        if kept.dataset == fresh.dataset:
            return drift(kept, fresh), False
        return disagreements(kept, fresh, self.comparisons), True

    def _kept(self, path: Path, read: Callable[[Path], Kept]) -> Kept | str:
        """A committed file, or why there is none to compare with."""
        if not (self.results / path).is_file():
            return "nothing was kept"
        try:
            return read(self.results / path)
        except FileError as error:
            return str(error)

    def _strangers(self, record: BoardDataset, made: dict[Path, list[str]]) -> list[str]:
        """Committed results on the dataset's boards that were not made again."""
        ending = f"-{record.tier}"
        own = [path for path in result_paths(self.results) if path.parts[0] == record.split]
        return [str(path) for path in own if path.parts[1].endswith(ending) and path not in made]

    def _write(self, record: BoardDataset, fresh: Sequence[Result], anew: bool) -> None:
        if anew:
            write_dataset(record, self.results)
        for one in fresh:
            write_result(one, self.results)

    def _sign(self, paths: Sequence[Path]) -> None:
        """Write into rows that stand who made their figures again, if anybody is named."""
        for path in paths if self.by else ():
            kept = read_result(self.results / path)
            write_result(replace(kept, about=kept.about.made_again(self.by)), self.results)


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


_SEEDS = 1 << 31
_UNFINISHED = "unfinished-seed"
"""File in the work folder that holds the seed of a run until the run ends."""


@dataclass(frozen=True, kw_only=True)
class Rerun:
    """A run over boards.

    Parameters
    ----------
    results : folder of the result files.
    work : folder for datasets and submissions: itself where results are written anew, else its folder ``again``.
    seed : of all datasets; ``None`` for a new one, or that of a run that was stopped.
    by : who makes the figures again, and when; for rows that stand or are written.
    update : write what drifted and what is new.
    fresh : use nothing of the work folder again.
    together : as of `Workshop`.
    jobs : processes.
    scheduler, tls : address of a Dask cluster that generates and solves instead, and the folder of its certificates.
    """

    results: Path
    work: Path
    seed: int | None = None
    by: str = ""
    update: bool = False
    fresh: bool = False
    together: bool = False
    jobs: int = 1
    scheduler: str | None = None
    tls: Path | None = None

    def boards(
        self, splits: Sequence[str] = (), solvers: Sequence[str] = (), tiers: Sequence[str] = ()
    ) -> Iterator[Outcome]:
        """Outcome of every dataset record and every result; without names those of all that is published.

        Raises
        ------
        VbbenchError
            If a name is unknown, or the sources of a named split are missing; those of others are said and left out.
        """
        chosen, sources = [*(solvers or bundled_solvers())], chosen_sources(splits, tiers)
        for name in chosen:
            load("solver", name)
        for name in tiers:
            get_tier(name)
        room = self.room
        seed = self._drawn_seed(room / _UNFINISHED)
        shop = Workshop(
            room=room,
            seed=seed,
            fresh=self.fresh,
            together=self.together,
            jobs=self.jobs,
            scheduler=self.scheduler,
            tls=self.tls,
        )
        runs = sum(len(one.boards) for one in sources) * len(chosen)
        judge = Judge(results=self.results, comparisons=runs, update=self.update, by=self.by)
        with progress_bar(runs, "leaderboard", unit="result") as bar:
            for one in sources:
                dataset = self._dataset(shop, one, must=bool(splits))
                pairs = [(board, solver) for board in one.boards for solver in chosen]
                if dataset is None:
                    bar.update(len(pairs))
                    continue
                fresh = []
                for (_, solver), folder in zip(pairs, self._submissions(shop, dataset, pairs), strict=True):
                    fresh.append(self._result(folder, dataset, solver))
                    bar.update()
                yield from judge.outcomes(dataset, fresh)
        (room / _UNFINISHED).unlink()

    @property
    def room(self) -> Path:
        """Where datasets and submissions are made: what other seeds give is no part of the published boards."""
        return self.work if self.update else self.work / "again"

    def _drawn_seed(self, note: Path) -> int:
        """The seed of this run: as asked, that of a run that was stopped, or a new one; it is said which."""
        stopped = note.read_text("utf-8").strip() if note.is_file() and not self.fresh else ""
        if self.seed is not None:
            seed, why = self.seed, "as asked"
        elif stopped.isdigit():
            seed, why = int(stopped), "of the run that was stopped; --fresh draws another"
        else:
            seed, why = secrets.randbelow(_SEEDS), "drawn for this run; --seed repeats it"
        note.parent.mkdir(parents=True, exist_ok=True)
        write_text_atomically(note, f"{seed}\n")
        sys.stderr.write(f"vbbench: seed {seed}, {why}\n")
        return seed

    def _dataset(self, shop: Workshop, one: BoardSource, *, must: bool) -> Dataset | None:
        try:
            return shop.dataset(one)
        except SourceMissingError as error:
            if must:
                raise
            sys.stderr.write(f"vbbench: {one.split} {one.tier} is left out: {error}\n")
            return None

    def _submissions(self, shop: Workshop, dataset: Dataset, pairs: list[tuple[Board, str]]) -> Iterator[Path]:
        """Submissions to boards of a dataset by solvers, in order; here several at a time, on a cluster one by one."""
        if self.jobs == 1 or self.scheduler is not None:
            yield from (shop.submission(dataset, board, solver) for board, solver in pairs)
        else:
            yield from in_parallel(_submission_in_silence, [(shop, dataset, *pair) for pair in pairs], self.jobs)

    def _result(self, submission: Path, dataset: Dataset, solver: str) -> Result:
        facts = declared_facts(solver)
        words = {"reference": REFERENCES.get(solver, ""), "rerun_by": self.by}
        about = About.of(SubmissionInfo.read(submission), **facts, **words)
        return Result.of(score(submission, dataset.folder), submission, about, name=solver)


def _submission_in_silence(shop: Workshop, dataset: Dataset, board: Board, solver: str) -> Path:
    """A submission made in a worker, whose progress would be drawn over that of others."""
    with redirect_stderr(StringIO()):
        return shop.submission(dataset, board, solver)
