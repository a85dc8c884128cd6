"""Errors over the number of people as a picture: a row of panels a solver, a line and its band a σ_h."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.figure import Rectangles, lay_out, save_png
from vbbench.reproduction.curves import PANELS
from vbbench.reproduction.sigma import Curve, SigmaFigure
from vbbench.reproduction.study import title_of
from vbbench.scoring.metrics import METRICS

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
        _write(
            drawn, _top(len(figure.solvers), row) + 0.14, f"({chr(ord('a') + row)}) {title_of(solver)}", weight="bold"
        )
    _draw_heading(drawn, figure)
    return drawn


def plot_sigma_to_file(figure: SigmaFigure, out: Path | str) -> Path:
    """Draw the figure into a PNG file; see `save_png`."""
    save_png(plot_sigma(figure), out)
    return Path(out)


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
    widths, colours = np.linspace(_WIDEST, _THINNEST, len(curves)), _colours(len(curves))
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


def _colours(count: int) -> list[tuple[float, ...]]:
    return [tuple(colour) for colour in style.distance_colours()(np.linspace(1.0, 0.0, count))]


def _draw_heading(drawn: Figure, figure: SigmaFigure) -> None:
    height = drawn.get_figheight()
    _write(drawn, height - 0.34, "Errors over the number of people, by the spread of their heights", 12.5, "bold")
    text = "lines: mean over sequences, with its 95 % bootstrap interval; dotted: median; every panel has its own scale"
    conditions = figure.conditions.replace("σ_h", r"$\sigma_h$")
    _write(drawn, height - 0.58, f"{conditions};  {text}", style.TEXT_SIZE)
    handles, labels = drawn.axes[0].get_legend_handles_labels()
    place = (_LEFT / _WIDTH, 1.0 - 0.66 / height)
    drawn.legend(
        handles,
        labels,
        loc="upper left",
        bbox_to_anchor=place,
        borderaxespad=0.0,
        borderpad=0.2,
        ncols=len(labels),
        frameon=False,
        fontsize=style.TEXT_SIZE,
    )


def _write(drawn: Figure, height: float, text: str, size: float = 10.0, weight: str = "normal") -> None:
    """A line of text, ``height`` inches from below."""
    x, y = _LEFT / _WIDTH, height / drawn.get_figheight()
    drawn.text(x, y, text, fontsize=size, weight=weight, color=style.INK)
