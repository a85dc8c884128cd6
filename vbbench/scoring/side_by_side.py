"""Several submissions to one dataset, side by side: one table for people, for papers and for programs."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vbbench.errors import SubmissionError, VbbenchError
from vbbench.files.submission import SubmissionInfo
from vbbench.scoring.score_columns import SHOWN_HEAD, VALUES_HEAD, ranking_fact, shown_cells, value_cells
from vbbench.scoring.scorecard import RANKED_BY, Score
from vbbench.scoring.scores import score
from vbbench.table import Format, Table, csv_text, unmarked


@dataclass(frozen=True, kw_only=True)
class SideBySide:
    """Scores of one dataset under one protocol, in the order in which the submissions were named.

    Parameters
    ----------
    scores : folder → its score.
    refused : folder → what is wrong with the submission in it.
    """

    scores: Mapping[Path, Score]
    refused: Mapping[Path, SubmissionError]

    def write(self, form: Format) -> str:
        """The table in a format."""
        if form == "json":
            return json.dumps(self.values(), indent=2, ensure_ascii=False)
        return self.csv() if form == "csv" else "\n".join(getattr(self.table(), form)()).rstrip()

    def table(self) -> Table:
        """The table for people: capped means with intervals, the best of each column marked, and every caution."""
        cells = shown_cells([one.values() for one in self.scores.values()])
        refused = [[name, "refused", *[""] * (len(SHOWN_HEAD) - 1)] for name in map(_name, self.refused)]
        return Table(
            title=self._title(),
            facts=list(self._facts()),
            head=["solver", *SHOWN_HEAD],
            rows=[*([name, *row] for name, row in zip(self._names(), cells, strict=True)), *refused],
        )

    def csv(self) -> str:
        """A row per submission with all figures; those of a refused one are empty, and its faults are counted."""
        rows = [
            [folder, one.info.solver, one.info.version, *self._place(), *value_cells(one.values()), 0]
            for folder, one in self.scores.items()
        ]
        nothing = [""] * len(VALUES_HEAD)
        rows += [[folder, "", "", *self._place(), *nothing, len(e.faults)] for folder, e in self.refused.items()]
        return csv_text(("submission", "solver", "version", *_PLACE, *VALUES_HEAD, "faults"), rows).rstrip("\n")

    def values(self) -> dict[str, Any]:
        """The scores as ``vbbench score --json`` prints each, and the faults of those that were refused."""
        return {
            **dict(zip(_PLACE, self._place(), strict=True)),
            "ranked_by": RANKED_BY,
            "submissions": [{"submission": str(folder), **one.published()} for folder, one in self.scores.items()],
            "refused": [{"submission": str(folder), "faults": e.faults} for folder, e in self.refused.items()],
        }

    @property
    def _one(self) -> Score:
        return next(iter(self.scores.values()))

    def _place(self) -> tuple[str, ...]:
        info, data = self._one.info, self._one.dataset
        return (info.dataset, data.split, data.tier, self._one.protocol.id)

    def _names(self) -> list[str]:
        """The solvers, with their folders where two have one name."""
        solvers = [one.info.solver for one in self.scores.values()]
        return [
            unmarked(name if solvers.count(name) == 1 else f"{name} ({folder})")
            for folder, name in zip(self.scores, solvers, strict=True)
        ]

    def _title(self) -> str:
        one, data = self._one, self._one.dataset
        return unmarked(
            f"{data.split} ({data.camera.kind}, {data.tier}, seed {data.spoken_seed}, {one.info.dataset}), "
            f"{one.protocol.id}: {one.sequences} of {one.total_sequences} sequences scored, {one.frames} frames, "
            f"{one.per_sequence.positions.sum()} positions"
        )

    def _facts(self) -> Iterator[str]:
        yield ranking_fact(self._one.protocol)
        yield from self._one.notes()
        for folder, error in self.refused.items():
            yield f"{_name(folder)} is refused: {'; '.join(map(unmarked, error.faults))}"


_PLACE = ("dataset", "split", "tier", "protocol")


def score_several(
    submissions: Sequence[Path | str], dataset: Path | str, truth: Path | str | None = None
) -> SideBySide:
    """Score submission folders against the dataset that all of them answer; parameters as of `score`.

    Raises
    ------
    VbbenchError
        If no submission can be scored, with every fault of each; if they answer different datasets, or were made under
        different protocols, or the truth is not available.
    """
    scores: dict[Path, Score] = {}
    refused: dict[Path, SubmissionError] = {}
    folders = list(dict.fromkeys(map(Path, submissions)))
    _check_alike(folders)
    for folder in folders:
        try:
            scores[folder] = score(folder, dataset, truth)
        except SubmissionError as error:
            refused[folder] = error
    if not scores:
        faults = (line for error in refused.values() for line in str(error).splitlines())
        raise VbbenchError("none of these can be scored", *faults)
    return SideBySide(scores=scores, refused=refused)


def _check_alike(folders: Sequence[Path]) -> None:
    """Raise VbbenchError if two submissions do not belong into one table; those without readable facts have none."""
    first: dict[str, tuple[Path, str]] = {}
    for folder in folders:
        try:
            info = SubmissionInfo.read(folder)
        except SubmissionError:
            continue
        for what, own in (("dataset", info.dataset), ("protocol", info.protocol)):
            other, expected = first.setdefault(what, (folder, own))
            if own != expected:
                raise VbbenchError(
                    f"{other} answers {what} {expected}, {folder} {what} {own}; one table holds one {what}, score them "
                    "apart"
                )


def _name(folder: Path) -> str:
    return unmarked(str(folder))
