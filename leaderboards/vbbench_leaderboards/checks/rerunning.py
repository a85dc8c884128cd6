"""Makes every published result again, with another seed, and says which stand.

A dataset with the seed of its boards must give the committed figures to the last digits. With another seed, noise and
crowds are others, and a result stands when the fresh figures agree with it within the uncertainty of both.
"""

import secrets
import sys
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

from vbbench.errors import SourceMissingError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.tier import get_tier
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench.registry import load
from vbbench.scoring import score
from vbbench.solving.submissions import declared_facts
from vbbench_leaderboards.checks.bundled import REFERENCES, bundled_solvers
from vbbench_leaderboards.checks.judging import Judge, Outcome
from vbbench_leaderboards.checks.making import Workshop
from vbbench_leaderboards.results.about import About
from vbbench_leaderboards.results.boards import BoardSource, chosen_sources
from vbbench_leaderboards.results.result import Board, Result

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
