"""Compares submissions on common sequences by capped figures, with a block bootstrap over time."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import SubmissionError, VbbenchError
from vbbench.files.submission import SubmissionInfo
from vbbench.geometry import FloatArray
from vbbench.parsing.json_text import finite_or_none
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.metrics import METRICS, Metric, section
from vbbench.scoring.scorecard import (
    RANKED_BY,
    SHOWN_HEAD,
    VALUES_HEAD,
    Score,
    capped_figures,
    interval_note,
    known,
    ranking_fact,
    row_title,
    shown_cells,
    value_cells,
)
from vbbench.scoring.scores import score
from vbbench.table import Format, Table, csv_text, unmarked


@dataclass(frozen=True, kw_only=True)
class SideBySide:
    """Scores of one dataset under one protocol, in the order in which the submissions were named.

    Parameters
    ----------
    scores : folder → its score.
    """

    scores: Mapping[Path, Score]

    def write(self, form: Format) -> str:
        """The table in a format."""
        if form == "json":
            return json.dumps(self.values(), indent=2, ensure_ascii=False)
        return self.csv() if form == "csv" else "\n".join(getattr(self.table(), form)()).rstrip()

    def table(self) -> Table:
        """The table as text: capped means with intervals, the best of each column marked, and every caution."""
        cells = shown_cells([one.values() for one in self.scores.values()])
        return Table(
            title=self._title(),
            facts=[ranking_fact(self._one.protocol), *self._one.notes()],
            head=["solver", *SHOWN_HEAD],
            rows=[[name, *row] for name, row in zip(self._names(), cells, strict=True)],
        )

    def csv(self) -> str:
        """A row per submission with all figures."""
        rows = [
            [folder, one.info.solver, one.info.version, *self._place(), *value_cells(one.values())]
            for folder, one in self.scores.items()
        ]
        return csv_text(("submission", "solver", "version", *_PLACE, *VALUES_HEAD), rows).rstrip("\n")

    def values(self) -> dict[str, Any]:
        """The scores as ``vbbench score --json`` prints each."""
        return {
            **dict(zip(_PLACE, self._place(), strict=True)),
            "ranked_by": RANKED_BY,
            "submissions": [{"submission": str(folder), **one.published()} for folder, one in self.scores.items()],
        }

    @property
    def _one(self) -> Score:
        return next(iter(self.scores.values()))

    def _place(self) -> tuple[str, ...]:
        info, data = self._one.info, self._one.dataset
        return (info.dataset, data.split, data.tier, self._one.protocol.id)

    def _names(self) -> list[str]:
        """Names of the solvers, with folders where two names are equal."""
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


_PLACE = ("dataset", "split", "tier", "protocol")


def score_several(
    submissions: Sequence[Path | str], dataset: Path | str, truth: Path | str | None = None
) -> SideBySide:
    """Score submission folders against the dataset that all of them answer; parameters as in `score`.

    Raises VbbenchError if one cannot be scored, with every fault of each; if they answer different datasets, or were
    made under different protocols, or the truth is not available.
    """
    scores: dict[Path, Score] = {}
    faults: list[str] = []
    folders = list(dict.fromkeys(map(Path, submissions)))
    _check_same_rows(folders)
    for folder in folders:
        try:
            scores[folder] = score(folder, dataset, truth)
        except SubmissionError as error:
            faults += str(error).splitlines()
    if faults:
        raise VbbenchError("not all of these can be scored", *faults)
    return SideBySide(scores=scores)


def _check_same_rows(folders: Sequence[Path]) -> None:
    """Raise VbbenchError if two submissions differ in dataset or protocol; skips those without readable facts."""
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


@dataclass(frozen=True, kw_only=True)
class Difference:
    """The difference of two submissions in one metric: mean over sequences of A − B; A is better if it is below 0.

    Parameters
    ----------
    difference, ci95 : mean difference of capped figures, and its 95 % interval, in the metric's unit.
    p_value : two-sided, for no difference of capped figures; NaN where the sequences are too few for one.
    mean_difference : mean difference of uncapped figures.
    sequences : number of sequences with a figure in both.
    """

    difference: float
    ci95: tuple[float, float]
    p_value: float
    mean_difference: float
    sequences: int


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Two scores on one dataset under one protocol, their differences by metric, and the number of blocks of time."""

    a: Score
    b: Score
    differences: dict[str, Difference]
    blocks: float

    def values(self) -> dict[str, Any]:
        """The comparison as the command line prints it with ``--json``."""
        a, b = self.a, self.b
        return {
            "dataset": a.info.dataset,
            "protocol": a.protocol.name,
            "a": {"solver": a.info.solver, "coverage": a.coverage},
            "b": {"solver": b.info.solver, "coverage": b.coverage},
            "ranked_by": RANKED_BY,
            "blocks": self.blocks,
            "metrics": {name: self._values_of(name) for name in section("metrics")},
            "drift": {name: self._values_of(name) for name in section("drift")},
            **({} if a.dataset.caution is None else {"caution": a.dataset.caution}),
        }

    def to_json(self) -> str:
        """`values` as text."""
        return json.dumps(self.values(), indent=2, ensure_ascii=False)

    def table(self) -> str:
        """The comparison as a text table."""
        a, b = self.a, self.b
        head = [
            f"A = {a.info.solver} (coverage {a.coverage:.2%}), B = {b.info.solver} (coverage {b.coverage:.2%})",
            f"{a.dataset.split} ({a.dataset.camera.kind}, {a.dataset.tier}), {a.protocol.id}, {a.sequences} sequences",
            f"{'capped means':<12}{'A':>9}{'B':>9}{'A − B':>10}{'95 % interval':>20}{'p':>9}"
            f"{'failed A, B':>16}{'plain A, B, A − B':>30}",
        ]
        notes = [_COMPARED, interval_note(a.per_sequence.timeline, self.blocks)]
        notes += [f"Caution: {a.dataset.caution}"] if a.dataset.caution else []
        return "\n".join([*head, *(self._line(name, metric) for name, metric in METRICS.items()), *notes])

    def _values_of(self, name: str) -> dict[str, Any]:
        own, a, b = self.differences[name], self.a.summaries[name], self.b.summaries[name]
        values = {"a": a.capped, "b": b.capped, "difference": own.difference, "p_value": own.p_value}
        plain = {"a": a.mean, "b": b.mean, "difference": own.mean_difference}
        failed = {"a": a.failure_rate, "b": b.failure_rate}
        return {
            **_finite(values),
            "ci95": [finite_or_none(end) for end in own.ci95],
            "failure_rate": _finite(failed),
            "mean": _finite(plain),
            "sequences": own.sequences,
        }

    def _line(self, name: str, metric: Metric) -> str:
        own, a, b = self.differences[name], self.a.summaries[name], self.b.summaries[name]
        if self.a.dataset.truth not in metric.known:
            return f"{row_title(metric)}{'not known':>9}"
        p = "–" if np.isnan(own.p_value) else "< 0.0001" if own.p_value < 1e-4 else f"{own.p_value:.4f}"
        low, high = own.ci95
        interval = "–" if np.isnan(low) else f"{low:+.4f} to {high:+.4f}"
        failed = "" if np.isnan(a.failure_rate) else f"{a.failure_rate:.1%}, {b.failure_rate:.1%}"
        plain = f"{a.mean:.4f}, {b.mean:.4f}, {own.mean_difference:+.4f}"
        return (
            f"{row_title(metric)}{a.capped:>9.4f}{b.capped:>9.4f}{own.difference:>+10.4f}{interval:>20}{p:>9}"
            f"{failed:>16}{plain:>30}"
        )


def compare(a: Path | str, b: Path | str, dataset: Path | str, truth: Path | str | None = None) -> Comparison:
    """Compare two submission folders, sequence by sequence.

    Raises SubmissionError if one of them has faults; VbbenchError if they were made under different protocols, or the
    truth is not available.
    """
    one, two = score(a, dataset, truth), score(b, dataset, truth)
    if one.protocol.name != two.protocol.name:
        raise VbbenchError(
            f"{a} was made under the protocol '{one.protocol.name}', {b} under '{two.protocol.name}'; "
            "compare submissions of one protocol"
        )
    differences, blocks = _differences(one, two)
    return Comparison(a=one, b=two, differences=differences, blocks=blocks)


_COMPARED = "Compared, and ranked on boards, by capped means: of min(error, cap of the protocol) over sequences."


def _differences(a: Score, b: Score) -> tuple[dict[str, Difference], float]:
    """The differences by metric, and the number of blocks of time."""
    figures = [{name: score.per_sequence.figures[name] for name in METRICS} for score in (a, b)]
    one, two = (capped_figures(a.protocol.caps, own) for own in figures)
    means = block_means(a.per_sequence.timeline, one - two)
    columns = zip(METRICS, means.mean.tolist(), means.interval().tolist(), means.p_values().tolist(), strict=True)
    return {
        name: Difference(
            difference=difference,
            ci95=(low, high),
            p_value=p,
            mean_difference=_mean(figures[0][name] - figures[1][name]),
            sequences=len(known(figures[0][name] - figures[1][name])),
        )
        for name, difference, (low, high), p in columns
    }, means.blocks


def _mean(values: FloatArray) -> float:
    there = known(values)
    return float(there.mean()) if len(there) else float("nan")


def _finite(values: dict[str, float]) -> dict[str, float | None]:
    return {name: finite_or_none(value) for name, value in values.items()}
