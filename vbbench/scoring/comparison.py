"""Compares two submissions pairwise: bootstrap over the sequences that both were scored on."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.scoring.metrics import METRICS, Metric, section
from vbbench.scoring.scorecard import Score, row_title
from vbbench.scoring.scores import score
from vbbench.scoring.statistics import bootstrap_means, finite_or_none, two_sided_p

RESAMPLES = 10_000
"""Bootstrap resamples behind a p-value; the smallest is 2/10001."""


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Of one metric: mean over sequences of (A − B), so that below 0 A is better.

    Parameters
    ----------
    difference, ci95 : mean and its bootstrap interval, in the metric's unit.
    p_value : two-sided, for no difference.
    sequences : how many have a figure in both.
    """

    difference: float
    ci95: tuple[float, float]
    p_value: float
    sequences: int


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Two scores on the same dataset under the same protocol, and the differences by metric."""

    a: Score
    b: Score
    differences: dict[str, Difference]

    def values(self) -> dict[str, Any]:
        """The comparison as the command line prints it with ``--json``."""
        a, b = self.a, self.b
        return {
            "dataset": a.info.dataset,
            "protocol": a.protocol.name,
            "a": {"solver": a.info.solver, "coverage": a.coverage},
            "b": {"solver": b.info.solver, "coverage": b.coverage},
            "metrics": {name: self._values_of(name) for name in section("metrics")},
            "drift": {name: self._values_of(name) for name in section("drift")},
            **({} if a.dataset.caution is None else {"caution": a.dataset.caution}),
        }

    def to_json(self) -> str:
        """`values` as text."""
        return json.dumps(self.values(), indent=2, ensure_ascii=False)

    def table(self) -> str:
        """The comparison as a table for people."""
        a, b = self.a, self.b
        head = [
            f"A = {a.info.solver} (coverage {a.coverage:.2%}), B = {b.info.solver} (coverage {b.coverage:.2%})",
            f"{a.dataset.split} ({a.dataset.camera.kind}, {a.dataset.tier}), {a.protocol.id}, {a.sequences} sequences",
            f"{'':<12}{'A':>9}{'B':>9}{'A − B':>10}{'95 % interval':>20}{'p':>9}",
        ]
        caution = [f"Caution: {a.dataset.caution}"] if a.dataset.caution else []
        return "\n".join([*head, *(self._line(name, metric) for name, metric in METRICS.items()), *caution])

    def _values_of(self, name: str) -> dict[str, Any]:
        own = self.differences[name]
        values = {"a": self.a.summaries[name].mean, "b": self.b.summaries[name].mean, "difference": own.difference}
        numbers = {key: finite_or_none(value) for key, value in values.items()}
        ci95 = [finite_or_none(end) for end in own.ci95]
        return {**numbers, "ci95": ci95, "p_value": own.p_value, "sequences": own.sequences}

    def _line(self, name: str, metric: Metric) -> str:
        own = self.differences[name]
        if self.a.dataset.truth not in metric.known:
            return f"{row_title(metric)}{'not known':>9}"
        means = f"{self.a.summaries[name].mean:>9.4f}{self.b.summaries[name].mean:>9.4f}{own.difference:>+10.4f}"
        interval = f"{own.ci95[0]:+.4f} to {own.ci95[1]:+.4f}"
        return f"{row_title(metric)}{means}{interval:>20}{own.p_value:>9.4f}"


def compare(a: Path | str, b: Path | str, dataset: Path | str, truth: Path | str | None = None) -> Comparison:
    """Compare two submission folders, sequence by sequence.

    Raises
    ------
    SubmissionError
        If one of them has faults.
    VbbenchError
        If they were made under different protocols, or the truth is not available.
    """
    one, two = score(a, dataset, truth), score(b, dataset, truth)
    if one.protocol.name != two.protocol.name:
        raise VbbenchError(
            f"{a} was made under the protocol '{one.protocol.name}', {b} under '{two.protocol.name}'; "
            "compare submissions of one protocol"
        )
    return Comparison(a=one, b=two, differences=_differences(one, two))


def _differences(a: Score, b: Score) -> dict[str, Difference]:
    values = np.stack([a.per_sequence.figures[name] - b.per_sequence.figures[name] for name in METRICS], axis=-1)
    means = bootstrap_means(values, RESAMPLES)
    low, high = np.quantile(means, [0.025, 0.975], axis=0).tolist()
    total, counts, p = np.nansum(values, axis=0), np.sum(~np.isnan(values), axis=0), two_sided_p(means)
    return {
        name: Difference(
            difference=float(total[m] / counts[m]) if counts[m] else float("nan"),
            ci95=(low[m], high[m]),
            p_value=float(p[m]) if counts[m] else 1.0,
            sequences=int(counts[m]),
        )
        for m, name in enumerate(METRICS)
    }
