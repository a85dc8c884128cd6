"""The paper's figure of Δr, Δt, Δx̃ and Δx over the number of people K, for several spreads σ_h of their heights."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import SequenceTable
from vbbench.generation.generator import Generator, Options, Simulation
from vbbench.geometry import IntArray
from vbbench.pictures.plotting import style
from vbbench.protocol import get_protocol
from vbbench.registry import load
from vbbench.reproduction.grid import Cell, Making, Row, Study, check_grid, distinct, rows_at
from vbbench.reproduction.report import Report, paragraphs
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import known
from vbbench.table import Table

SPLIT, SOLVER = "sim", "vb-sf"
"""The solver's class may name variants to compare it with, in ``variants``."""
SIGMAS = (0.0, 0.01, 0.03, 0.05, 0.07)
"""σ_h in m of the paper's figure."""
PEOPLE = (10, 20, 30, 40, 50)
"""K of the paper's figure."""
PANELS = ("dr", "dt", "dx_rel", "dx")
"""The metrics of the paper's figure, in its order."""
COLUMNS = ("solver", "sigma_h", "people", "sequences", "seen", "coverage", "metric", "mean", "low", "high", "median")
"""Of a row: K with the observer, scored sequences, people scored a frame, coverage, and figures over sequences."""


def compared_solvers() -> dict[str, str]:
    """The solvers of the figure and their titles."""
    return dict(getattr(load("solver", SOLVER), "variants", {SOLVER: SOLVER}))


class SigmaFigure(NamedTuple):
    """Rows of `COLUMNS`, and (solver, σ_h) → frames that the observer's own prior decided, ``None`` if not reported."""

    conditions: str
    rows: list[Row]
    fallback_frames: dict[tuple[str, float], int | None]


@dataclass(frozen=True, kw_only=True)
class SigmaStudy(Study):
    """Errors on split `sim` over K, for each σ_h and solver.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    protocol, seed : of solvers and datasets.
    sequences : at each σ_h; they take the numbers of people in turn.
    sigmas : σ_h in m.
    people : numbers of people K.
    """

    name = "figure-sigma"
    solvers: Sequence[str] = field(default_factory=lambda: tuple(compared_solvers()))
    protocol: str = "one-step"
    sequences: int = 500
    seed: int = 0
    sigmas: Sequence[float] = SIGMAS
    people: Sequence[int] = PEOPLE

    def options(self, sigma_h: float) -> Options:
        """Options of the generator at one σ_h (m)."""
        simulation = Simulation(sequences=self.sequences, people=tuple(self.people))
        return Options(height_std=sigma_h, seed=self.seed, simulation=simulation)

    def check(self) -> None:
        """Raise VbbenchError if a solver, the protocol or an option of the split is invalid."""
        check_grid(self.solvers if self.sigmas else (), [self.protocol])
        generator: Generator = load("generator", SPLIT)
        for sigma_h in self.sigmas:
            generator.plan(self.options(sigma_h))

    def measure(self, out: Path, making: Making) -> SigmaFigure:
        """A dataset for each σ_h."""
        cells, kind = list[Cell](), ""
        for sigma_h in dict.fromkeys(self.sigmas):
            dataset = making.dataset(SPLIT, out / f"sigma-{sigma_h:g}" / "dataset", self.options(sigma_h))
            cells += making.cells(dataset, self.solvers, [self.protocol], sigma_h)
            kind = dataset.info.camera.kind
        where = f"split {SPLIT} ({kind}, ideal), {get_protocol(self.protocol).id}, seed {self.seed}"
        return SigmaFigure(
            conditions=f"{where}, {self.sequences} sequences at each σ_h",
            rows=[row for cell in cells for row in _rows(cell)],
            fallback_frames={(cell.solver, cell.at): cell.score.fallback_frames for cell in cells},
        )

    def report(self, found: SigmaFigure) -> Report:
        """A table per solver, a row for each metric and σ_h, a column for each K."""
        return Report(
            name=self.name,
            title=f"Errors over the number of people: {found.conditions}",
            facts=paragraphs("sigma"),
            tables=[_table(solver, found) for solver in distinct(found.rows, "solver")],
            values={"rows": found.rows},
            pictures={"": plot_sigma(found)},
        )


def _rows(cell: Cell) -> Iterator[Row]:
    """A row for every K, which only the truth has, and metric."""
    every = cell.score.per_sequence
    people = _scene_people(cell.dataset)[every.sequence]
    for count in np.unique(people).tolist():
        own = every.select(people == count)
        figures = np.stack([own.figures[name] for name in PANELS], axis=1)
        intervals = block_means(own.timeline, figures).interval().tolist()
        seen = float(np.mean(own.positions / own.frames))
        head = (cell.solver, cell.at, count, len(figures), seen, own.total_coverage)
        for name, column, (low, high) in zip(PANELS, figures.T, intervals, strict=True):
            values = known(column)
            mean, median = (float(np.mean(values)), float(np.median(values))) if len(values) else (np.nan, np.nan)
            yield dict(zip(COLUMNS, (*head, name, mean, low, high, median), strict=True))


def _scene_people(dataset: Dataset) -> IntArray:
    """[N] number of people in the scene of each sequence, the observer included, seen or not."""
    scenes = dataset.rows["scene"]
    table = SequenceTable(dataset.table_path("truth/people"), "truth/people", "scene")
    rows = table.read(0, int(scenes.max()) + 1, ["scene"])
    return np.asarray(np.bincount(rows["scene"])[scenes])


def _table(solver: str, found: SigmaFigure) -> Table:
    own = rows_at(found.rows, solver=solver)
    sigmas = distinct(own, "sigma_h")
    points = rows_at(own, sigma_h=sigmas[0], metric=PANELS[0])
    facts = [
        f"- solver `{solver}`",
        f"- sequences at each K: {', '.join(str(point['sequences']) for point in points)}",
        f"- people scored in a frame: {', '.join('{seen:.1f}'.format(**point) for point in points)}",
    ]
    counts = [count for sigma_h in sigmas if (count := found.fallback_frames[solver, sigma_h]) is not None]
    if counts:
        facts.append(f"- frames decided by the observer's own prior, at each σ_h: {', '.join(map(str, counts))}")
    if (coverage := min(row["coverage"] for row in own)) < 1.0:
        facts.append(f"- coverage: {coverage:.1%} at least; missing answers are held, not removed")
    return Table(
        title=compared_solvers().get(solver, solver),
        facts=["\n".join(facts)],
        head=["", "σ_h (m)", *(f"K = {point['people']}" for point in points), "change"],
        rows=[_line(rows_at(own, metric=metric, sigma_h=sigma_h)) for metric in PANELS for sigma_h in sigmas],
        names=2,
    )


def _line(points: Sequence[Row]) -> list[str]:
    """A metric at one σ_h, K ascending."""
    first, last, change = points[0], points[-1], "–"
    if first["mean"] > 0.0 and first["median"] > 0.0:
        change = f"{last['mean'] / first['mean'] - 1.0:+.0%} ({last['median'] / first['median'] - 1.0:+.0%})"
    cells = [f"{one['mean']:.4f} [{one['low']:.4f}, {one['high']:.4f}]" for one in points]
    return [METRICS[first["metric"]].label, f"{first['sigma_h']:g}", *cells, change]


_WIDTH, _HEAD, _FOOT, _ROW = 13.0, 1.05, 0.3, 2.75  # inches; a row is its panels with their title and labels
_LEFT, _STEP, _PANEL = 0.88, 3.06, (2.3, 1.85)
_WIDTHS = 4.4, 1.2
"""Line widths in points from the first σ_h to the last, so that lines on top of each other all show."""


def plot_sigma(found: SigmaFigure) -> Figure:
    """Draw every solver's errors over K, a row of panels each."""
    solvers = distinct(found.rows, "solver")
    tops = [_FOOT + (len(solvers) - row) * _ROW - 0.35 for row in range(len(solvers))]
    panels: style.Rectangles = {
        f"{solver} {metric}": (_LEFT + column * _STEP, top - _PANEL[1], *_PANEL)
        for solver, top in zip(solvers, tops, strict=True)
        for column, metric in enumerate(PANELS)
    }
    drawn = style.lay_out((_WIDTH, _HEAD + len(solvers) * _ROW + _FOOT), panels)
    for axes in drawn.axes:
        solver, _, metric = str(axes.get_label()).rpartition(" ")
        _draw_panel(axes, rows_at(found.rows, solver=solver, metric=metric))
    for n, (solver, top) in enumerate(zip(solvers, tops, strict=True)):
        place = _LEFT / _WIDTH, (top + 0.14) / drawn.get_figheight()
        title = f"({chr(ord('a') + n)}) {compared_solvers().get(solver, solver)}"
        drawn.text(*place, title, fontsize=10.0, weight="bold", color=style.INK)
    text = "lines: mean over sequences, with its 95 % bootstrap interval; dotted: median; every panel has its own scale"
    conditions = found.conditions.replace("σ_h", r"$\sigma_h$")
    title = "Errors over the number of people, by the spread of their heights"
    style.draw_heading(drawn, _LEFT, title, f"{conditions};  {text}", drawn.axes[0])
    return drawn


def _draw_panel(axes: Axes, rows: Sequence[Row]) -> None:
    sigmas = distinct(rows, "sigma_h")
    widths = np.linspace(*_WIDTHS, len(sigmas))
    colours = [tuple(colour) for colour in style.distance_colours()(np.linspace(1.0, 0.0, len(sigmas)))]
    for sigma_h, width, colour in zip(sigmas, widths, colours, strict=True):
        own = rows_at(rows, sigma_h=sigma_h)
        people, mean, low, high, median = (
            [row[name] for row in own] for name in ("people", "mean", "low", "high", "median")
        )
        axes.fill_between(people, low, high, color=colour, alpha=0.16, linewidth=0)
        look = {"color": colour, "linewidth": width, "marker": "o", "markersize": width + 2.2}
        axes.plot(people, mean, label=f"$\\sigma_h$ = {sigma_h:g} m", **look)
        axes.plot(people, median, color=colour, linewidth=0.9, linestyle=":")
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xticks(distinct(rows, "people"))
    style.name_axes(axes, "people K in the scene", METRICS[rows[0]["metric"]].label)
    style.draw_grid(axes)
