"""The figure over σ_h as a report: tables, every number, and a picture with a row of panels per solver."""

import csv
import io
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.reproduction.report import Report
from vbbench.reproduction.sigma.study import PANELS, Curve, SigmaFigure, Statistic, title_of
from vbbench.scoring.metrics import METRICS
from vbbench.table import Table

NAME = "figure-sigma"
COLUMNS = ("solver", "sigma_h", "people", "sequences", "seen", "coverage", "metric", "mean", "low", "high", "median")


def sigma_report(figure: SigmaFigure) -> Report:
    """A table per solver, a row for each metric and σ_h, a column for each K; every number also as CSV."""
    facts = (
        "Mean over sequences [95 % bootstrap interval] by the number K of people in the scene, the observer included. "
        "Last column: change of the mean (of the median) from the fewest people to the most.",
    )
    return Report(
        name=NAME,
        title=f"Errors over the number of people: {figure.conditions}",
        facts=facts,
        tables=[_solver_table(name, curves) for name, curves in figure.solvers.items()],
        values={"rows": [dict(zip(COLUMNS, row, strict=True)) for row in _rows(figure)]},
        pictures={"": plot_sigma(figure)},
        texts={".csv": sigma_csv(figure)},
    )


def sigma_csv(figure: SigmaFigure) -> str:
    """Every number of the figure: a row for each solver, σ_h (m), K and metric (m, rad)."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([COLUMNS, *_rows(figure)])
    return text.getvalue()


def _rows(figure: SigmaFigure) -> Iterator[tuple[str | float, ...]]:
    """Of `COLUMNS`."""
    for curve in figure.curves:
        for point in curve.points:
            head = (curve.solver, curve.sigma_h, point.people, point.sequences, point.seen, point.coverage)
            for metric, s in point.statistics.items():
                yield (*head, metric, s.mean, s.low, s.high, s.median)


def _solver_table(solver: str, curves: list[Curve]) -> Table:
    points = curves[0].points
    return Table(
        title=title_of(solver),
        facts=["\n".join(_facts(solver, curves))],
        head=["", "σ_h (m)", *(f"K = {point.people}" for point in points), "change"],
        rows=[_row(metric, curve) for metric in PANELS for curve in curves],
        names=2,
    )


def _facts(solver: str, curves: list[Curve]) -> Iterator[str]:
    """Facts about the table, a line each."""
    points = curves[0].points
    yield f"- solver `{solver}`"
    yield f"- sequences at each K: {', '.join(str(point.sequences) for point in points)}"
    yield f"- people scored in a frame: {', '.join(f'{point.seen:.1f}' for point in points)}"
    if fallbacks := [str(curve.fallback_frames) for curve in curves if curve.fallback_frames is not None]:
        yield f"- frames decided by the observer's own prior, at each σ_h: {', '.join(fallbacks)}"
    if (coverage := min(point.coverage for curve in curves for point in curve.points)) < 1.0:
        yield f"- coverage: {coverage:.1%} at least; missing answers are held, not left out"


def _row(metric: str, curve: Curve) -> list[str]:
    own = [point.statistics[metric] for point in curve.points]
    cells = [f"{one.mean:.4f} [{one.low:.4f}, {one.high:.4f}]" for one in own]
    return [METRICS[metric].label, f"{curve.sigma_h:g}", *cells, _change(own[0], own[-1])]


def _change(first: Statistic, last: Statistic) -> str:
    """From the fewest people to the most, of the mean and of the median."""
    if not (first.mean > 0.0 and first.median > 0.0):
        return "–"
    return f"{last.mean / first.mean - 1.0:+.0%} ({last.median / first.median - 1.0:+.0%})"


_WIDTH, _HEAD, _FOOT, _ROW = 13.0, 1.05, 0.3, 2.75  # inches; a row is its panels with their title and labels
_LEFT, _STEP = 0.88, 3.06
_PANEL = (2.3, 1.85)
_WIDEST, _THINNEST = 4.4, 1.2
"""Line widths in points from the first σ_h to the last, so that lines on top of each other all show."""


def plot_sigma(figure: SigmaFigure) -> Figure:
    """Draw every solver's errors over K."""
    drawn = lay_out(*_layout(list(figure.solvers)))
    axes = iter(drawn.axes)
    for row, (solver, curves) in enumerate(figure.solvers.items()):
        for metric in PANELS:
            _draw_panel(next(axes), metric, curves)
        place = _LEFT / _WIDTH, (_top(len(figure.solvers), row) + 0.14) / drawn.get_figheight()
        title = f"({chr(ord('a') + row)}) {title_of(solver)}"
        drawn.text(*place, title, fontsize=10.0, weight="bold", color=style.INK)
    text = "lines: mean over sequences, with its 95 % bootstrap interval; dotted: median; every panel has its own scale"
    conditions = figure.conditions.replace("σ_h", r"$\sigma_h$")
    title = "Errors over the number of people, by the spread of their heights"
    draw_heading(drawn, _LEFT, title, f"{conditions};  {text}", drawn.axes[0])
    return drawn


def _layout(solvers: list[str]) -> tuple[tuple[float, float], Rectangles]:
    rows = len(solvers)
    panels = {
        f"{solver} {metric}": (_LEFT + column * _STEP, _top(rows, row) - _PANEL[1], *_PANEL)
        for row, solver in enumerate(solvers)
        for column, metric in enumerate(PANELS)
    }
    return (_WIDTH, _HEAD + rows * _ROW + _FOOT), panels


def _top(rows: int, row: int) -> float:
    """Upper edge of a row's panels, in inches from below."""
    return _FOOT + (rows - row) * _ROW - 0.35


def _draw_panel(axes: Axes, metric: str, curves: list[Curve]) -> None:
    widths = np.linspace(_WIDEST, _THINNEST, len(curves))
    colours = [tuple(colour) for colour in style.distance_colours()(np.linspace(1.0, 0.0, len(curves)))]
    for curve, width, colour in zip(curves, widths, colours, strict=True):
        people = [point.people for point in curve.points]
        own = [point.statistics[metric] for point in curve.points]
        axes.fill_between(people, [s.low for s in own], [s.high for s in own], color=colour, alpha=0.16, linewidth=0)
        look = {"color": colour, "linewidth": width, "marker": "o", "markersize": width + 2.2}
        axes.plot(people, [s.mean for s in own], label=f"$\\sigma_h$ = {curve.sigma_h:g} m", **look)
        axes.plot(people, [s.median for s in own], color=colour, linewidth=0.9, linestyle=":")
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xticks([point.people for point in curves[0].points])
    axes.set_xlabel("people K in the scene", fontsize=style.TEXT_SIZE)
    axes.set_ylabel(METRICS[metric].label, fontsize=style.TEXT_SIZE)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
