"""The paper's Tables 2 and 3: every solver on its recordings, with heights known and unknown, under both protocols.

The paper gives its means over frames; Table 2 is of Hotel, ETH and Students, Table 3 of two recordings of Shibuya.
Where a recording is missing, a simulated one may take its place, under its own name.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vbbench.errors import SourceMissingError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation.generator import Generator, Options
from vbbench.paper import BEST, COLUMNS, HEADLINE, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.registry import load
from vbbench.reproduction.grid import (
    STAND_INS,
    Cell,
    Making,
    Row,
    SimulatedRecording,
    Study,
    check_every,
    check_grid,
    check_splits,
    how_to_get,
    record_crowd,
    row_at,
    rows_at,
    stride_of,
)
from vbbench.reproduction.report import Report, paragraphs
from vbbench.scoring.metrics import METRICS, section
from vbbench.scoring.scorecard import Summary
from vbbench.table import Table

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
_LABELS = tuple(METRICS[metric].label for metric in COLUMNS)
_DX = METRICS[HEADLINE].symbol


class SolverTable(NamedTuple):
    """By split what was measured and why others are missing, and a row for each combination."""

    recordings: dict[str, dict[str, Any]]
    missing: dict[str, str]
    rows: list[Row]

    def name(self, split: str) -> str:
        """The split's name, which differs for a stand-in."""
        return f"{split} (simulated)" if self.recordings[split]["simulated"] else split

    @property
    def sequences(self) -> str:
        """How many sequences of each recording were solved, as text."""
        counts = ", ".join(f"{self.name(split)} {own['sequences']}" for split, own in self.recordings.items())
        return f"sequences: {counts or 'none'}"


@dataclass(frozen=True, kw_only=True)
class SolverTableStudy(Study):
    """Every solver on the recordings of one table.

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

    @property
    def name(self) -> str:
        """Of its command and its files."""
        return f"table{self.table}"

    def check(self) -> None:
        """Raise VbbenchError if a split is not of the table, or a solver, protocol or ``every`` is invalid."""
        if not self.sigmas:
            raise VbbenchError("nothing to measure: name a σ_h")
        check_splits(self.splits, SPLITS[self.table], f"split of the paper's Table {self.table}")
        check_every(1 if self.every is None else self.every)
        check_grid(self.solvers, self.protocols)

    def measure(self, out: Path, making: Making) -> SolverTable:
        """A dataset for each split and σ_h; recordings that are missing are simulated, or omitted."""
        found = SolverTable({}, {}, [])
        for split in dict.fromkeys(self.splits):
            cells = list[Cell]()
            try:
                for sigma_h in dict.fromkeys(self.sigmas):
                    dataset, simulated = self._dataset(split, sigma_h, out, making)
                    cells += making.cells(dataset, self.solvers, self.protocols, sigma_h)
            except SourceMissingError:
                if self.source is not None:
                    raise
                found.missing[split] = f"`{split}` is not here: {how_to_get(split)} gets it."
                continue
            generator: Generator = load("generator", split)
            found.recordings[split] = {
                "title": self.stand_ins[split].title(split) if simulated else generator.card.title,
                "simulated": simulated,
                "sequences": len(dataset),
                "caution": dataset.info.caution,
            }
            order = {name: n for n, name in enumerate((*self.protocols, *self.solvers))}
            cells.sort(key=lambda cell: (order[cell.protocol], cell.at, order[cell.solver]))
            found.rows.extend(_row(split, cell) for cell in cells)
        return found

    def _dataset(self, split: str, sigma_h: float, out: Path, making: Making) -> tuple[Dataset, bool]:
        """The dataset at one σ_h (m), and whether it is of a stand-in."""
        options = Options(height_std=sigma_h, seed=self.seed, stride=stride_of(self.every or 1), source=self.source)
        try:
            return making.dataset(split, out / f"{split}-sigma-{sigma_h:g}" / "dataset", options), False
        except SourceMissingError:
            stand_in = self.stand_ins.get(split)
            if stand_in is None or self.source is not None:
                raise
        recording = record_crowd(stand_in, out / f"{split}-simulated", self.seed, making)
        options = replace(options, source=recording, stride=stride_of(self.every or stand_in.every))
        return making.dataset(split, out / f"{split}-simulated-sigma-{sigma_h:g}" / "dataset", options), True

    def report(self, found: SolverTable) -> Report:
        """Times the paper's at a glance, then a table for each recording; JSON has figures over sequences, too."""
        tables = [self._at_a_glance(found)] if found.recordings and SIGMA_H in self.sigmas else []
        tables += [_over_frames(found, split) for split in found.recordings]
        simulated = [split for split, own in found.recordings.items() if own["simulated"]]
        missing = list(found.missing.values())
        conditions = f"panorama, tier ideal, seed {self.seed}, {found.sequences}"
        printed = {split: {row.solver: dict(row.figures) for row in the_paper().select(split)} for split in self.splits}
        values = {
            "table": self.table,
            "every": self.every,
            "seed": self.seed,
            "recordings": found.recordings,
            "missing": found.missing,
            "paper": printed,
            "rows": found.rows,
        }
        return Report(
            name=self.name,
            title=f"Table {self.table}: every solver, {conditions}",
            facts=paragraphs("solver_table", sigma_h=SIGMA_H, table=self.table, simulated=simulated, missing=missing),
            tables=tables,
            values=values,
            whole=not found.missing and not simulated,
        )

    def _at_a_glance(self, found: SolverTable) -> Table:
        """Δx at the paper's σ_h over frames, by solver, protocol and split, with how many times the paper's it is."""
        combinations = [*product(self.protocols, found.recordings)]
        rows = []
        for solver in self.solvers:
            own = [
                row_at(found.rows, protocol=protocol, split=split, sigma_h=SIGMA_H, solver=solver)
                for protocol, split in combinations
            ]
            cells = [
                _with_ratio(_size(row["figures"][HEADLINE].frame_mean), row["times_the_paper"][HEADLINE]) for row in own
            ]
            ratios = {
                protocol: [row["times_the_paper"][HEADLINE] for row in rows_at(own, protocol=protocol)]
                for protocol in self.protocols
            }
            times = [_ratio(float(np.exp(np.mean(np.log(one))))) for one in ratios.values()]
            rows.append([f"`{solver}`", COUNTERPARTS.get(solver, BEST), *cells, *times])
        return Table(
            title=f"{_DX} at a glance, σ_h = {SIGMA_H:g} m",
            facts=[
                f"{METRICS[HEADLINE].label}, mean over frames (in brackets: divided by the paper's). Last columns: "
                "geometric mean of these ratios over the recordings."
            ],
            head=[
                "solver",
                "compared with",
                *(f"{protocol}, {found.name(split)}" for protocol, split in combinations),
                *(f"{protocol}: times the paper's" for protocol in self.protocols),
            ],
            rows=rows,
            names=2,
        )


def _row(split: str, cell: Cell) -> Row:
    """A solver's figures on a recording, and by metric the mean over frames by the paper's, NaN where it has none."""
    counterpart, figures = COUNTERPARTS.get(cell.solver, BEST), cell.summaries
    printed = the_paper().figures(split, counterpart) if cell.at == SIGMA_H else {}
    return {
        "split": split,
        "protocol": cell.protocol,
        "sigma_h": cell.at,
        "solver": cell.solver,
        "compared_with": counterpart,
        "coverage": cell.score.coverage,
        "figures": {metric: figures[metric] for metric in section("metrics")},
        "times_the_paper": {metric: figures[metric].frame_mean / printed.get(metric, np.nan) for metric in COLUMNS},
    }


def _over_frames(found: SolverTable, split: str) -> Table:
    own = found.recordings[split]
    paper = [
        [
            "the paper",
            f"{SIGMA_H:g}",
            row.solver,
            *(f"{row.figures[m]:.3f}" if m in row.figures else "" for m in COLUMNS),
        ]
        for row in the_paper().select(split)
    ]
    caution = [f"Caution: {own['caution']}."] if own["caution"] else []
    return Table(
        title=f"{found.name(split)}, the paper's way: mean ± standard deviation over frames",
        facts=[f"{own['title']}; {own['sequences']} sequences. In brackets: divided by the paper's.", *caution],
        head=["protocol", "σ_h (m)", "solver", *_LABELS],
        rows=[*paper, *([*_names(row), *map(_frames, *_figures(row))] for row in rows_at(found.rows, split=split))],
        names=3,
    )


def _names(row: Row) -> list[str]:
    answered = "" if row["coverage"] == 1.0 else f" (answered {row['coverage']:.1%})"
    return [row["protocol"], f"{row['sigma_h']:g}", f"`{row['solver']}`{answered}"]


def _figures(row: Row) -> tuple[list[Summary], list[float]]:
    return [row["figures"][metric] for metric in COLUMNS], [row["times_the_paper"][metric] for metric in COLUMNS]


def _frames(own: Summary, times: float) -> str:
    return _with_ratio(f"{_size(own.frame_mean)} ± {_size(own.frame_std)}", times)


def _size(value: float) -> str:
    """Four decimals; two digits of what is smaller than 0.001."""
    return f"{value:.4f}" if value >= 0.001 else _two_digits(value)


def _with_ratio(text: str, ratio: float) -> str:
    return f"{text} ({_ratio(ratio)})" if _ratio(ratio) else text


def _ratio(value: float) -> str:
    """Two decimals; two digits of what is smaller than 0.1; nothing where the paper has no figure."""
    return "" if np.isnan(value) else f"{value:.2f}" if value >= 0.1 else _two_digits(value)


def _two_digits(value: float) -> str:
    return "< 0.00001" if value < 1e-5 else np.format_float_positional(value, 2, fractional=False, trim="-")
