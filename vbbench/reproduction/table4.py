"""The paper's Table 4: split `street` with centre lines drawn by hand, and with boxes of a tracker.

The inputs are centre lines with jitter, and boxes of a tracker by the paper's rule of tracks.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import NamedTuple

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options, Simulation
from vbbench.paper import COLUMNS, PROTOCOLS, the_paper
from vbbench.reproduction.grid import Making, Row, Study, check_grid, row_at, rows_at
from vbbench.reproduction.report import Report, paragraphs
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import Summary
from vbbench.table import Table

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
        found: dict[str, Summary] = row_at(self.rows, protocol=protocol, solver=solver, input=source)["figures"]
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
        """Raise VbbenchError if a solver or the jitter is invalid."""
        check_grid(self.solvers, PROTOCOLS)
        if not self.jitter or len(set(self.jitter)) < len(self.jitter) or min(self.jitter) < 0.0:
            raise VbbenchError(f"jitter is one or more different numbers of px, 0 or more, not {list(self.jitter)}")

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
            for row in rows_at(found.rows, protocol=protocol)
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
