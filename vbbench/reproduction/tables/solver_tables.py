"""The paper's Tables 2 and 3: every solver on its recordings, with heights known and unknown, under both protocols.

The paper gives its means over frames; Table 2 is of Hotel, ETH and Students, Table 3 of two recordings of Shibuya.
Where a recording is missing, a simulated one may take its place, under its own name.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from vbbench.errors import SourceMissingError, UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Card, Generator, Options
from vbbench.paper import BEST, HEADLINE, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.registry import load
from vbbench.reproduction.asked import check_every, check_names, stride_of
from vbbench.reproduction.at_hand import how_to_get
from vbbench.reproduction.making import Making
from vbbench.reproduction.simulated_recording import STAND_INS, SimulatedRecording, record_crowd
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import Summary

COUNTERPARTS = {
    "cv": "CV",
    "sf": "SF",
    "vb-cv": "VB-CV",
    "vb-sf": "VB-SF",
    "vb-sf-literal": "VB-SF",
    "map-causal": "VB-SF",
    "map-batch": "VB-SF",
}
"""The solvers of the tables, and whose row of the paper each is compared with; any other with its best."""


@dataclass(frozen=True, kw_only=True)
class SolverTableStudy:
    """What to measure.

    Parameters
    ----------
    table : the paper's number, 2 or 3.
    splits : of that table.
    solvers : registered names or ``module:attribute``.
    protocols, sigmas : every combination of them; σ_h in m.
    every : only every so-many-th sequence of a recording; ``None`` for all, and of a stand-in as many as are sensible.
    seed : of the datasets.
    source : where the recordings are, if not in the usual places.
    stand_ins : by split, what is simulated where its recording is missing.
    """

    table: int
    splits: Sequence[str]
    solvers: Sequence[str] = tuple(COUNTERPARTS)
    protocols: Sequence[str] = PROTOCOLS
    sigmas: Sequence[float] = (0.0, SIGMA_H)
    every: int | None = None
    seed: int = 0
    source: Path | None = None
    stand_ins: Mapping[str, SimulatedRecording] = field(default_factory=lambda: STAND_INS)

    def check(self) -> None:
        """Find the mistakes that can be found before the work starts.

        Raises
        ------
        VbbenchError
            If a split is not of the table, a solver or protocol is unknown, or ``every`` is no number of sequences.
        """
        if not (self.splits and self.solvers and self.protocols and self.sigmas):
            raise VbbenchError("nothing to measure: name a split, a solver, a protocol and a σ_h")
        for split in self.splits:
            if split not in SPLITS[self.table]:
                raise UnknownNameError(f"split of the paper's Table {self.table}", split, SPLITS[self.table])
        if self.every is not None:
            check_every(self.every)
        check_names(self.solvers, self.protocols)


@dataclass(frozen=True, kw_only=True)
class SolverRow:
    """A solver's figures on a recording.

    Parameters
    ----------
    coverage : share of the scored rows that it answered.
    summaries : metric → figures.
    """

    split: str
    protocol: str
    sigma_h: float
    solver: str
    coverage: float
    summaries: Mapping[str, Summary]

    @property
    def compared_with(self) -> Mapping[str, float]:
        """The paper's figures of its counterpart: metric → mean; none at another σ_h than the paper's."""
        return the_paper().figures(self.split, counterpart(self.solver)) if self.sigma_h == SIGMA_H else {}

    def times_the_paper(self, metric: str = HEADLINE) -> float:
        """The mean over frames by the paper's; NaN where the paper has none."""
        return self.summaries[metric].frame_mean / self.compared_with.get(metric, np.nan)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """One recording, as it was measured.

    Parameters
    ----------
    title : the split's title, or what was simulated instead.
    simulated : whether it is no recording but a stand-in.
    sequences : how many were solved.
    caution : what the split says of itself.
    """

    title: str
    simulated: bool
    sequences: int
    caution: str | None


@dataclass(frozen=True, kw_only=True)
class SolverTable:
    """The results: what was measured and what is missing, by split, and a row for each combination."""

    study: SolverTableStudy
    measured: Mapping[str, Measured]
    missing: Mapping[str, str]
    rows: tuple[SolverRow, ...]

    def of(self, split: str) -> tuple[SolverRow, ...]:
        """The rows of one split."""
        return tuple(row for row in self.rows if row.split == split)

    def name(self, split: str) -> str:
        """The split's name, which tells a stand-in from the recording."""
        return f"{split} (simulated)" if self.measured[split].simulated else split

    def one(self, split: str, protocol: str, sigma_h: float, solver: str) -> SolverRow:
        """The row of one combination."""
        (row,) = (r for r in self.of(split) if (r.protocol, r.sigma_h, r.solver) == (protocol, sigma_h, solver))
        return row

    def times_the_paper(self, protocol: str, solver: str, metric: str = HEADLINE) -> float:
        """Geometric mean over splits of the error over frames by the paper's, at the paper's σ_h."""
        ratios = [self.one(split, protocol, SIGMA_H, solver).times_the_paper(metric) for split in self.measured]
        return float(np.exp(np.mean(np.log(ratios))))


def counterpart(solver: str) -> str:
    """Whose row of the paper a solver is compared with."""
    return COUNTERPARTS.get(solver, BEST)


def measure_solver_table(
    study: SolverTableStudy,
    out: Path | str,
    making: Making = Making(),  # noqa: B008
) -> SolverTable:
    """Generate, solve and score every combination; recordings that are missing are simulated, or left out.

    Datasets and submissions are kept in ``out``; complete ones are reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, its ``source`` lacks a recording, or another dataset or submission is in the way.
    """
    study.check()
    out = Path(out)
    measured: dict[str, Measured] = {}
    missing: dict[str, str] = {}
    rows: list[SolverRow] = []
    with loose_files(out):
        for split in dict.fromkeys(study.splits):
            try:
                measured[split], own = _measure(study, split, out, making)
            except SourceMissingError:
                if study.source is not None:
                    raise
                missing[split] = f"`{split}` is not here: {how_to_get(split)} gets it."
            else:
                rows += own
    return SolverTable(study=study, measured=measured, missing=missing, rows=tuple(rows))


def _measure(study: SolverTableStudy, split: str, out: Path, making: Making) -> tuple[Measured, list[SolverRow]]:
    """One split under every combination."""
    rows: list[SolverRow] = []
    for sigma_h in dict.fromkeys(study.sigmas):
        dataset, simulated = _dataset(study, split, sigma_h, out, making)
        for protocol in dict.fromkeys(study.protocols):
            rows += _rows(study, split, dataset, protocol, making)
    measured = Measured(
        title=study.stand_ins[split].title(split) if simulated else _card(split).title,
        simulated=simulated,
        sequences=len(dataset),
        caution=dataset.info.caution,
    )
    order = {name: n for n, name in enumerate((*study.protocols, *study.solvers))}
    return measured, sorted(rows, key=lambda row: (order[row.protocol], row.sigma_h, order[row.solver]))


def _rows(study: SolverTableStudy, split: str, dataset: Dataset, protocol: str, making: Making) -> Iterator[SolverRow]:
    """Every solver on a dataset."""
    scores = dict(making.scores(dataset, study.solvers, protocol))
    for solver in study.solvers:
        yield SolverRow(
            split=split,
            protocol=protocol,
            sigma_h=dataset.info.height_std,
            solver=solver,
            coverage=scores[solver].coverage,
            summaries={metric: scores[solver].summaries[metric] for metric in section("metrics")},
        )


def _dataset(study: SolverTableStudy, split: str, sigma_h: float, out: Path, making: Making) -> tuple[Dataset, bool]:
    """The dataset at one σ_h (m), and whether it is of a stand-in."""
    options = Options(height_std=sigma_h, seed=study.seed, stride=stride_of(study.every or 1), source=study.source)
    try:
        return making.dataset(split, out / f"{split}-sigma-{sigma_h:g}" / "dataset", options), False
    except SourceMissingError:
        stand_in = study.stand_ins.get(split)
        if stand_in is None or study.source is not None:
            raise
    recording = record_crowd(stand_in, out / f"{split}-simulated", study.seed, making)
    options = replace(options, source=recording, stride=stride_of(study.every or stand_in.every))
    return making.dataset(split, out / f"{split}-simulated-sigma-{sigma_h:g}" / "dataset", options), True


def _card(split: str) -> Card:
    generator: Generator = load("generator", split)
    return generator.card
