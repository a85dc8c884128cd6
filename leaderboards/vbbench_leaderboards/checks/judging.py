"""What becomes of the committed files of a dataset whose boards were made again: they stand, or are written anew."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from vbbench.errors import FileError
from vbbench.files.dataset import Dataset
from vbbench_leaderboards.checks.agreement import disagreements, record_disagreements
from vbbench_leaderboards.checks.drift import drift, record_faults
from vbbench_leaderboards.results.dataset_record import BoardDataset, read_dataset, write_dataset
from vbbench_leaderboards.results.folder import result_paths
from vbbench_leaderboards.results.result import Result, read_result, write_result

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
