"""Regenerates every published result, with another seed, and reports which stand.

A dataset with the seed of its boards must give the committed figures to the last digits. With another seed, noise and
crowds differ, and a result stands when the new figures agree with it within the uncertainty of both.
"""

import secrets
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass, replace
from functools import cache, partial
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
from vbbench.generation import generate
from vbbench.generation.tier import get_tier
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench.protocol import get_protocol
from vbbench.registry import Kind, load
from vbbench.scoring import score
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import capped_figures
from vbbench.solving import solve
from vbbench.solving.provenance import source_digest
from vbbench.solving.submissions import declared_facts
from vbbench_leaderboards.checks import drift, record_faults
from vbbench_leaderboards.results.boards import REFERENCES, BoardSource, chosen_sources, is_diagnostic
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, write_dataset
from vbbench_leaderboards.results.folder import dataset_folder, result_paths, submission_folder
from vbbench_leaderboards.results.result import About, Board, Result, read_result, write_result

LEVEL = 0.05
"""Probability that chance alone gives a difference that is called drift, over a whole run (Bonferroni's bound)."""

FEW = 0.1
"""Where the sequences are too few for an interval, capped means may differ by this share of the committed one."""

COUNTS = 0.2
"""Counts of another seed's dataset may differ by this share: crowds and those who are seen are others."""

AS_COMMITTED, STANDS, DRIFTED, WRITTEN = "as committed", "stands", "drifted", "written again"
"""The same figures, figures that agree with another seed's, others, and others that were written."""

_SAME = ("split", "tier", "title", "camera", "dt", "caution", "licence", "citation")
_COUNTED = ("sequences", "mean_frames", "people_mean", "observations")
_UNFINISHED = "unfinished-seed"
"""File in the work folder that holds the seed of a run until the run ends."""

Kept = TypeVar("Kept", BoardDataset, Result)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The outcome of one file: its state, and lines that describe how it drifted."""

    path: Path
    state: str
    found: tuple[str, ...] = ()

    @property
    def is_drift(self) -> bool:
        """Whether the committed file differs from the one made again, and stays as it was."""
        return bool(self.found) and self.state != WRITTEN

    @property
    def text(self) -> str:
        """One line, and one more for each thing that drifted."""
        return "\n  ".join([f"{self.path}: {self.state}", *self.found])


@dataclass(frozen=True, kw_only=True)
class Rerun:
    """A run over boards.

    Parameters
    ----------
    results : folder of the result files.
    work : folder for datasets and submissions: itself where results are written again, else its folder ``again``.
    seed : of all datasets; ``None`` for a new one, or that of a run that was stopped.
    by : who regenerates the figures, and when; for rows that stand or are written.
    update : write what drifted and what is new.
    together : solve with bundled solvers in one process a board, as diagnostics always are, for tests show that they
        remember nothing; others are solved in a fresh process for each group of sequences that share no moment.
    jobs : processes.
    root : folder with folders of real recordings, called like their splits; ``None`` for the usual places.
    """

    results: Path
    work: Path
    seed: int | None = None
    by: str = ""
    update: bool = False
    together: bool = False
    jobs: int = 1
    root: Path | None = None

    def boards(
        self, splits: Sequence[str] = (), solvers: Sequence[str] = (), tiers: Sequence[str] = ()
    ) -> Iterator[Outcome]:
        """Outcome of every dataset record and every result; without names those of all that is published.

        Raises VbbenchError if a name is unknown, or the sources of a named split are missing; others are omitted with a
        message.
        """
        chosen, sources = [*(solvers or sorted(REFERENCES))], chosen_sources(splits, tiers)
        for name in chosen:
            load("solver", name)
        for name in tiers:
            get_tier(name)
        run = replace(self, seed=self._drawn_seed())
        runs = sum(len(one.boards) for one in sources) * len(chosen)
        with progress_bar(runs, "leaderboard", unit="result") as bar:
            for one in sources:
                pairs = [(board, solver) for board in one.boards for solver in chosen]
                try:
                    dataset = run.dataset(one)
                except SourceMissingError as error:
                    if one.split in splits:
                        raise
                    sys.stderr.write(f"vbbench: {one.split} {one.tier} is omitted: {error}\n")
                    bar.update(len(pairs))
                    continue
                fresh = []
                for (_, solver), folder in zip(pairs, run._submissions(dataset, pairs), strict=True):
                    fresh.append(self._result(folder, dataset, solver))
                    bar.update()
                yield from self.outcomes(dataset, fresh, runs)
        (self.room / _UNFINISHED).unlink()

    @property
    def room(self) -> Path:
        """Where datasets and submissions are made: what other seeds give is no part of the published boards."""
        return self.work if self.update else self.work / "again"

    def _drawn_seed(self) -> int:
        """The seed of this run, as given, that of a run that was stopped, or a new one, with a message which."""
        note = self.room / _UNFINISHED
        stopped = note.read_text("utf-8").strip() if note.is_file() else ""
        if self.seed is not None:
            seed, why = self.seed, "as asked"
        elif stopped.isdigit():
            seed, why = int(stopped), "of the run that was stopped; --seed or another --work takes another"
        else:
            seed, why = secrets.randbelow(1 << 31), "drawn for this run; --seed repeats it"
        note.parent.mkdir(parents=True, exist_ok=True)
        write_text_atomically(note, f"{seed}\n")
        sys.stderr.write(f"vbbench: seed {seed}, {why}\n")
        return seed

    def dataset(self, source: BoardSource) -> Dataset:
        """The dataset of a split and tier's boards; what is whole there and of the same code is kept."""
        folder = dataset_folder(self.room, source.split, source.tier)
        options = source.options(self.seed or 0, self.root)
        make = partial(generate, source.split, folder, options, jobs=self.jobs, overwrite=True)
        self._make(folder, f"{code_of('generator', source.split)} {options}", make)
        return Dataset(folder)

    def submission(self, dataset: Dataset, board: Board, solver: str) -> Path:
        """A solver's submission to a board; what is whole there and of the same code is kept."""
        folder = submission_folder(self.room, board, solver)
        apart = solver not in REFERENCES or not (self.together or is_diagnostic(board))
        make = partial(solve, dataset, solver, board.protocol, folder, fresh_processes=apart, overwrite=True)
        self._make(folder, f"{code_of('solver', solver)} {dataset.info.id}{' in fresh processes' * apart}", make)
        return folder

    def _make(self, folder: Path, code: str, make: Callable[[], object]) -> None:
        """Make a folder, unless the note next to it names that code, and every file is as it was then."""
        note = folder.with_name(folder.name + ".made-by")
        if not (note.is_file() and note.read_text("utf-8") == _note_text(code, folder)):
            note.unlink(missing_ok=True)  # what is made next is not up to date before it is whole
            make()
            write_text_atomically(note, _note_text(code, folder))

    def _submissions(self, dataset: Dataset, pairs: list[tuple[Board, str]]) -> Iterator[Path]:
        """Submissions to boards of a dataset by solvers, in order, several at a time."""
        if self.jobs == 1:
            yield from (self.submission(dataset, board, solver) for board, solver in pairs)
        else:
            yield from in_parallel(_submission_in_silence, [(self, dataset, *pair) for pair in pairs], self.jobs)

    def _result(self, submission: Path, dataset: Dataset, solver: str) -> Result:
        words = {"reference": REFERENCES.get(solver, ""), "rerun_by": self.by}
        about = About.of(SubmissionInfo.read(submission), **declared_facts(solver), **words)
        return Result.of(score(submission, dataset.folder), submission, about, name=solver)

    def outcomes(self, dataset: Dataset, fresh: Sequence[Result], runs: int) -> Iterator[Outcome]:
        """Outcomes of the dataset's record and of the fresh results on it; ``runs`` are all that the run compares.

        Where the committed files are of another dataset than the fresh ones, all of its boards are written or nothing:
        nobody is ranked next to others who solved something else.
        """
        record = BoardDataset.of(dataset)
        kept = self._kept(record.path, read_dataset)
        found = {record.path: _record_differences(kept, record, dataset)}
        moved = isinstance(kept, BoardDataset) and kept.id != record.id
        for one in fresh:
            old = self._kept(one.path, read_result)
            if isinstance(old, str):
                found[one.path] = [old]
                continue
            elsewhere = old.dataset != one.dataset
            moved = moved or elsewhere
            found[one.path] = disagreements(old, one, runs) if elsewhere else drift(old, one)
        drifted = any(found.values())
        strangers = self._strangers(record, found) if drifted and self.update and moved else []
        if drifted and self.update and not strangers:
            changed = {path for path, lines in found.items() if lines or moved}
            if record.path in changed:
                write_dataset(record, self.results)
            for one in (one for one in fresh if one.path in changed):
                write_result(one, self.results)
            yield from (Outcome(path=p, state=WRITTEN, found=(*found[p],)) for p in found if p in changed)
            yield from (Outcome(path=p, state=AS_COMMITTED) for p in found if p not in changed)
            self._sign([one.path for one in fresh if one.path not in changed])
            return
        why = f"{DRIFTED}, and not written: {', '.join(strangers)} would stand on the old dataset; rerun them, too"
        behind, fine = why if strangers else DRIFTED, STANDS if moved else AS_COMMITTED
        for path, lines in found.items():
            yield Outcome(path=path, state=behind if lines else fine, found=tuple(lines))
        if self.update:
            self._sign([one.path for one in fresh if not found[one.path]])

    def _kept(self, path: Path, read: Callable[[Path], Kept]) -> Kept | str:
        """A committed file, or why there is none to compare with."""
        if not (self.results / path).is_file():
            return "nothing was kept"
        try:
            return read(self.results / path)
        except FileError as error:
            return str(error)

    def _strangers(self, record: BoardDataset, made: dict[Path, list[str]]) -> list[str]:
        """Committed results on the dataset's boards that were not regenerated."""
        own = [path for path in result_paths(self.results) if path.parts[0] == record.split]
        return [str(path) for path in own if path.parts[1].endswith(f"-{record.tier}") and path not in made]

    def _sign(self, paths: Sequence[Path]) -> None:
        """Write into rows that stand who regenerated their figures, if a name is given."""
        for path in paths if self.by else ():
            kept = read_result(self.results / path)
            write_result(replace(kept, about=replace(kept.about, rerun_by=self.by)), self.results)


def _submission_in_silence(run: Rerun, dataset: Dataset, board: Board, solver: str) -> Path:
    """A submission made in a worker, whose progress would be drawn over that of others."""
    with redirect_stderr(StringIO()):
        return run.submission(dataset, board, solver)


@cache
def code_of(kind: Kind, name: str) -> str:
    """The version of vbbench, a hash of its files, and one of the files in which ``name`` is defined."""
    return f"{__version__} {source_digest('vbbench')} {source_digest(name, kind)}"


def _note_text(code: str, folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return "".join([f"{code}\n", *(f"{file_sha256(path)}  {path.relative_to(folder)}\n" for path in files)])


def _record_differences(kept: BoardDataset | str, fresh: BoardDataset, dataset: Dataset) -> list[str]:
    """Where a record differs from the committed one by more than its seed explains."""
    if isinstance(kept, str):
        return [kept]
    if kept.id == fresh.id:
        return [*record_faults(kept, dataset.folder)]
    found = []
    if kept.seed == fresh.seed:
        found.append(f"was {kept.id}, is {fresh.id} with the same seed: it is made in another way now")
    both = {name: (getattr(kept, name), getattr(fresh, name)) for name in _SAME}
    found += [f"$.{name}: was {was!r}, is {now!r}" for name, (was, now) in both.items() if was != now]
    for name in _COUNTED:
        before, after = kept.counts[name], fresh.counts[name]
        if abs(after - before) > COUNTS * before:
            found.append(f"$.counts.{name}: was {before:.6g}, is {after:.6g}")
    return found


def disagreements(kept: Result, fresh: Result, comparisons: int) -> list[str]:
    """The metrics whose capped mean drifted in a result of another seed, one line each.

    The two results answer the same sequences with other noise, or other crowds. The test is on the mean over sequences
    of the difference of capped errors; its uncertainty comes from blocks of time, as that of the boards does.

    Parameters
    ----------
    comparisons : results that the whole run compares: the more, the less often chance may look like drift in each.
    """
    one, other = kept.per_sequence, fresh.per_sequence
    one, other = one.select(np.isin(one.sequence, other.sequence)), other.select(np.isin(other.sequence, one.sequence))
    if not len(one.sequence):
        return ["no sequence is scored in both; solve the whole dataset"]
    names, caps = [*section("metrics")], get_protocol(kept.board.protocol).caps
    old, new = (capped_figures(caps, {name: rows.figures[name] for name in names}) for rows in (one, other))
    difference, level, found = block_means(one.timeline, new - old), LEVEL / (comparisons * len(names)), []
    for m, (name, mean, p) in enumerate(zip(names, difference.mean, difference.p_values(), strict=True)):
        if not np.isfinite(mean):
            continue
        before, after, few = np.nanmean(old[:, m]), np.nanmean(new[:, m]), np.isnan(p)
        if abs(mean) > FEW * before if few else p < level:
            how = f"more than {FEW:.0%} apart" if few else f"p = {p:.1g}, below {level:.1g}"
            found.append(f"{name}: was {before:.4f}, is {after:.4f} with another seed ({how})")
    return found
