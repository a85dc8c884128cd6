"""The paper's Tables 2, 3 and 4: solvers on its recordings, with heights known and unknown, and on its street.

The paper gives its means over frames; Table 2 is of Hotel, ETH and Students, Table 3 of two recordings of Shibuya.
Table 4 is of split `street` with
centre lines drawn by hand, with jitter, and with boxes of a tracker by the paper's rule of tracks.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vbbench.errors import SourceMissingError, VbbenchError
from vbbench.generation.generator import Generator, Options, Simulation
from vbbench.paper import BEST, COLUMNS, HEADLINE, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.registry import load
from vbbench.reproduction import grid
from vbbench.reproduction.grid import Cell, Making, Row, Study
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

    @property
    def sequences(self) -> str:
        """How many sequences of each recording were solved, as text."""
        counts = ", ".join(f"{split} {own['sequences']}" for split, own in self.recordings.items())
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
    every : only every so-many-th sequence of a recording.
    seed : of the datasets.
    """

    table: int
    splits: Sequence[str]
    solvers: Sequence[str] = tuple(COUNTERPARTS)
    protocols: Sequence[str] = PROTOCOLS
    sigmas: Sequence[float] = (0.0, SIGMA_H)
    every: int = 1
    seed: int = 0

    @property
    def name(self) -> str:
        """Of its command and its files."""
        return f"table{self.table}"

    def check(self) -> None:
        """Raise VbbenchError if a split is not of the table, or a solver, protocol or ``every`` is invalid."""
        if not self.sigmas:
            raise VbbenchError("nothing to measure: name a σ_h")
        grid.check_splits(self.splits, SPLITS[self.table], f"split of the paper's Table {self.table}")
        grid.check_every(self.every)
        grid.check_grid(self.solvers, self.protocols)

    def measure(self, out: Path, making: Making) -> SolverTable:
        """A dataset for each split and σ_h; recordings that are missing are omitted."""
        found = SolverTable({}, {}, [])
        for split in dict.fromkeys(self.splits):
            cells = list[Cell]()
            try:
                for sigma_h in dict.fromkeys(self.sigmas):
                    stride = grid.stride_of(self.every)
                    options = Options(height_std=sigma_h, seed=self.seed, stride=stride)
                    dataset = making.dataset(split, out / f"{split}-sigma-{sigma_h:g}" / "dataset", options)
                    cells += making.cells(dataset, self.solvers, self.protocols, sigma_h)
            except SourceMissingError:
                found.missing[split] = f"`{split}` is not here: {grid.how_to_get(split)} gets it."
                continue
            generator: Generator = load("generator", split)
            found.recordings[split] = {
                "title": generator.card.title,
                "sequences": len(dataset),
                "caution": dataset.info.caution,
            }
            order = {name: n for n, name in enumerate((*self.protocols, *self.solvers))}
            cells.sort(key=lambda cell: (order[cell.protocol], cell.at, order[cell.solver]))
            found.rows.extend(_row(split, cell) for cell in cells)
        return found

    def report(self, found: SolverTable) -> Report:
        """Times the paper's at a glance, then a table for each recording; JSON has figures over sequences, too."""
        tables = [self._at_a_glance(found)] if found.recordings and SIGMA_H in self.sigmas else []
        tables += [_over_frames(found, split) for split in found.recordings]
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
            facts=paragraphs("solver_table", sigma_h=SIGMA_H, table=self.table, missing=missing),
            tables=tables,
            values=values,
        )

    def _at_a_glance(self, found: SolverTable) -> Table:
        """Δx at the paper's σ_h over frames, by solver, protocol and split, with how many times the paper's it is."""
        combinations = [*product(self.protocols, found.recordings)]
        rows = []
        for solver in self.solvers:
            own = [
                grid.row_at(found.rows, protocol=protocol, split=split, sigma_h=SIGMA_H, solver=solver)
                for protocol, split in combinations
            ]
            cells = [
                _with_ratio(_size(row["figures"][HEADLINE].frame_mean), row["times_the_paper"][HEADLINE]) for row in own
            ]
            ratios = {
                protocol: [row["times_the_paper"][HEADLINE] for row in grid.rows_at(own, protocol=protocol)]
                for protocol in self.protocols
            }
            times = [_size(float(np.exp(np.mean(np.log(one)))), 2) for one in ratios.values()]
            rows.append([f"`{solver}`", COUNTERPARTS.get(solver, BEST), *cells, *times])
        return Table(
            title=f"{_DX} at a glance, σ_h = {SIGMA_H:g} m",
            facts=paragraphs("at_a_glance", label=METRICS[HEADLINE].label),
            head=[
                "solver",
                "compared with",
                *(f"{protocol}, {split}" for protocol, split in combinations),
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
        title=f"{split}, the paper's way: mean ± standard deviation over frames",
        facts=[f"{own['title']}; {own['sequences']} sequences. In brackets: divided by the paper's.", *caution],
        head=["protocol", "σ_h (m)", "solver", *_LABELS],
        rows=[
            *paper,
            *map(_line, grid.rows_at(found.rows, split=split)),
        ],
        names=3,
    )


def _line(row: Row) -> list[str]:
    answered = "" if row["coverage"] == 1.0 else f" (answered {row['coverage']:.1%})"
    figures = ((row["figures"][metric], row["times_the_paper"][metric]) for metric in COLUMNS)
    cells = [_with_ratio(f"{_size(own.frame_mean)} ± {_size(own.frame_std)}", times) for own, times in figures]
    return [row["protocol"], f"{row['sigma_h']:g}", f"`{row['solver']}`{answered}", *cells]


def _with_ratio(text: str, ratio: float) -> str:
    return f"{text} ({shown})" if (shown := _size(ratio, 2)) else text


def _size(value: float, decimals: int = 4) -> str:
    """So many decimals; two digits of what is smaller than 10 units of the last; nothing of NaN."""
    if np.isnan(value):
        return ""
    if value >= 10.0 ** (1 - decimals):
        return f"{value:.{decimals}f}"
    return "< 0.00001" if value < 1e-5 else np.format_float_positional(value, 2, fractional=False, trim="-")


SPLIT = "street"
LEAST_TRACK = 4
"""The paper keeps who is tracked in more than three frames."""
KEPT = f"tracked-{LEAST_TRACK}"
"""Boxes of the tracker by the paper's rule."""


class Table4(NamedTuple):
    """Number of sequences, what each input is, and a row for each protocol, input and solver."""

    sequences: int
    inputs: list[Row]
    rows: list[Row]

    def figures(self, protocol: str, solver: str, source: str) -> dict[str, Summary]:
        """Metric → summary of one row."""
        found: dict[str, Summary] = grid.row_at(self.rows, protocol=protocol, solver=solver, input=source)["figures"]
        return found


@dataclass(frozen=True, kw_only=True)
class Table4Study(Study):
    """Every solver under both protocols on every input.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    jitter : standard deviations in px of column, top and bottom of centre lines.
    sequences : of each input; ``None`` for as many as the scenario has.
    seed : of the datasets.
    """

    name = "table4"
    solvers: Sequence[str] = ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal")
    jitter: Sequence[float] = (0.0, 1.0, 2.0, 4.0)
    sequences: int | None = None
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a solver is invalid."""
        grid.check_grid(self.solvers, PROTOCOLS)

    @property
    def lines(self) -> dict[str, float]:
        """Jitter in px of each input of centre lines."""
        return {f"cline-{jitter:g}px": jitter for jitter in self.jitter}

    def measure(self, out: Path, making: Making) -> Table4:
        """A dataset for each input."""
        simulation = None if self.sequences is None else Simulation(sequences=self.sequences)
        plain = Options(seed=self.seed, simulation=simulation)
        least_tracks = {**dict.fromkeys(self.lines), KEPT: LEAST_TRACK}
        inputs: list[Row] = [
            {"kind": name.partition("-")[0], "jitter": self.lines.get(name, 0.0), "least_track": least, "name": name}
            for name, least in least_tracks.items()
        ]
        datasets = {}
        for one in inputs:
            folder = out / str(one["name"]) / "dataset"
            options = replace(plain, tier="tracked", least_track=one["least_track"])
            if one["kind"] == "cline":
                options = replace(plain, tier="noisy", noise=one["jitter"]) if one["jitter"] else plain
            datasets[one["name"]] = making.dataset(SPLIT, folder, options)
        rows = [
            {
                "protocol": protocol,
                "solver": cell.solver,
                "input": name,
                "figures": {metric: cell.summaries[metric] for metric in COLUMNS},
            }
            for protocol, (name, dataset) in product(PROTOCOLS, datasets.items())
            for cell in making.cells(dataset, self.solvers, [protocol])
        ]
        return Table4(len(datasets[KEPT]), inputs, rows)

    def report(self, found: Table4) -> Report:
        """The rows of both protocols, and their ratios."""
        names = {"cline": "ideal", "tracked": "tracked"}
        rows = {name: the_paper().select(SPLIT, tier) for name, tier in names.items()}
        paper = {name: {metric: row.figures[metric] for metric in COLUMNS} for name, (row,) in rows.items()}
        paper["ratio"] = {metric: paper["tracked"][metric] / paper["cline"][metric] for metric in COLUMNS}
        ratios = [*self._ratios(found)]
        return Report(
            name=self.name,
            title=f"Table 4: split {SPLIT}, seed {self.seed}, {found.sequences} sequences",
            facts=paragraphs("table4", least=LEAST_TRACK),
            tables=[
                *(self._errors(found, protocol, paper) for protocol in PROTOCOLS),
                _ratio_table(ratios, paper["ratio"]),
            ],
            values={
                "sequences": found.sequences,
                "seed": self.seed,
                "paper": paper,
                "inputs": found.inputs,
                "rows": found.rows,
                "ratios": ratios,
            },
        )

    def _errors(self, found: Table4, protocol: str, paper: dict[str, dict[str, float]]) -> Table:
        labels = {name: f"cline, {px:g} px" if px else "cline, exact" for name, px in self.lines.items()}
        labels[KEPT] = f"tracked, {LEAST_TRACK} frames or more"
        head = ["solver", "input", *(METRICS[metric].label for metric in COLUMNS)]
        rows = [["the paper", name, *(f"{paper[name][m]:.3f}" for m in COLUMNS)] for name in ("cline", "tracked")]
        rows += [
            [f"`{row['solver']}`", labels[row["input"]], *map(_cell, row["figures"].values())]
            for row in grid.rows_at(found.rows, protocol=protocol)
        ]
        return Table(title=f"Errors, {protocol}", head=head, rows=rows, names=2)

    def _ratios(self, found: Table4) -> Iterator[Row]:
        """Of every protocol, solver and jitter, metric by metric."""
        for protocol, solver, (line, jitter) in product(PROTOCOLS, dict.fromkeys(self.solvers), self.lines.items()):
            below = found.figures(protocol, solver, line)
            times = {
                metric: {
                    "sequences": own.mean / below[metric].mean,
                    "frames": own.frame_mean / below[metric].frame_mean,
                }
                for metric, own in found.figures(protocol, solver, KEPT).items()
            }
            yield {"protocol": protocol, "solver": solver, "jitter": jitter, "tracked": times}


def _cell(own: Summary) -> str:
    places = 4 if own.mean < 0.1 else 3 if own.mean < 1.0 else 2
    return f"{own.mean:.{places}f} ({own.frame_mean:.{places}f} ± {own.frame_std:.{places}f})"


def _ratio_table(ratios: Sequence[Row], paper: dict[str, float]) -> Table:
    rows = [["the paper", "", "by hand", *(f"{value:.2f}" for value in paper.values())]]
    for one in ratios:
        cells = [
            " / ".join(f"{value:.2f}" if value < 10.0 else f"{value:.0f}" for value in own.values())
            for own in one["tracked"].values()
        ]
        jitter = f"{one['jitter']:g} px" if one["jitter"] else "exact"
        rows.append([f"`{one['solver']}`", one["protocol"], jitter, *cells])
    head = ["solver", "protocol", "cline", *(METRICS[metric].symbol for metric in COLUMNS)]
    return Table(title="The ratio of the two rows", facts=paragraphs("table4_ratios"), head=head, rows=rows, names=3)
