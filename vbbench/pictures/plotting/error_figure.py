"""Errors of submissions in one figure: over time, and how often they stay below a bound.

Every number drawn is one that `vbbench.scoring.error_tables` counts.
"""

from collections.abc import Sequence as Several
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from vbbench.geometry import FloatArray
from vbbench.pictures.colours import Look, solver_looks
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.captions import ROW, draw_table
from vbbench.pictures.plotting.style import Rectangles, check_ending, lay_out, save_picture
from vbbench.scoring.error_tables import FEW, ErrorTables, cumulative, over_time
from vbbench.scoring.metrics import METRICS

_WIDTHS = {"over-time": 5.8, "cumulative": 4.2}
"""Inches of the two panels of a metric, together as wide as the table; `_HIGH` is their height."""
_HIGH, _LEFT, _RIGHT, _BOTTOM, _GAP, _ABOVE, _TITLE = 2.0, 0.95, 0.3, 0.5, (0.75, 0.68), 0.32, 0.72
_TITLES = {"over-time": "over time", "cumulative": "share not above"}
_BAND = 1.6  # of the largest median: how far a band may widen the scale
_FLAT = 25.0
"""Where the largest error is so many times the middle of the smallest solver's, a scale of errors is logarithmic."""


def plot_errors_to_file(tables: ErrorTables, out: Path | str) -> Path:
    """Draw the figure of `plot_errors` into a PNG, PDF or SVG file."""
    check_ending(out)
    save_picture(plot_errors(tables), out)
    return Path(out)


def plot_errors(tables: ErrorTables) -> Figure:
    """Draw both panels of every metric of the submissions' errors; a row is a metric."""
    looks = solver_looks([own.info.solver for own in tables.errors])
    figure = _laid_out(tables)
    parts = {axes.get_label(): axes for axes in figure.axes}
    for metric in tables.metrics:
        for kind, title in _TITLES.items():
            axes = parts[f"{metric} {kind}"]
            _DRAW[kind](axes, tables, metric, looks)
            shown = title if metric == tables.metrics[0] else ""
            axes.set_title(shown, fontsize=style.TEXT_SIZE, loc="left", color=style.INK, pad=14)
    draw_table(parts["table"], *tables.summary(), looks)
    style.write_heading(figure, _LEFT, tables.title, tables.facts)
    return figure


def _laid_out(tables: ErrorTables) -> Figure:
    rows, across = len(tables.metrics), sum(_WIDTHS.values()) + _GAP[0]
    parts: Rectangles = {}
    for row, metric in enumerate(tables.metrics):
        bottom = _BOTTOM + (rows - 1 - row) * (_HIGH + _GAP[1])
        parts[f"{metric} over-time"] = _LEFT, bottom, _WIDTHS["over-time"], _HIGH
        parts[f"{metric} cumulative"] = _LEFT + across - _WIDTHS["cumulative"], bottom, _WIDTHS["cumulative"], _HIGH
    above = _BOTTOM + rows * (_HIGH + _GAP[1]) - _GAP[1] + _ABOVE
    table = ROW * (len(tables.errors) + 1) + 0.1
    parts["table"] = _LEFT, above, across, table
    return lay_out((across + _LEFT + _RIGHT, above + table + _TITLE), parts, tables.notes(), _LEFT)


def _draw_over_time(axes: Axes, tables: ErrorTables, metric: str, looks: Several[Look]) -> None:
    """The errors of one sequence, or the median over all and the middle half, thin where few sequences last."""
    drawn = []
    end, highest = tables.drawn_seconds, 0.0
    for n, (own, look) in enumerate(zip(tables.errors, looks, strict=True)):
        line = over_time(own, metric)
        drawn.append(line.median[line.seconds <= end])
        highest = max(highest, float(np.nanmax(line.high[line.seconds <= end], initial=0.0)))
        style_: dict[str, Any] = {"color": look.colour, "linestyle": look.dashes}
        if tables.only is None:
            enough = line.sequences >= FEW * line.sequences.max(initial=1)
            axes.fill_between(line.seconds, line.low, line.high, where=enough, color=look.colour, alpha=0.14, lw=0)
            few = np.where(enough & np.append(enough[1:], True), np.nan, line.median)
            axes.plot(line.seconds, few, linewidth=0.7, alpha=0.6, gid=f"few-{n}", **style_)
            axes.plot(line.seconds, np.where(enough, line.median, np.nan), linewidth=1.7, gid=f"line-{n}", **style_)
        else:
            axes.plot(line.seconds, line.median, linewidth=1.5, gid=f"line-{n}", **style_)
            missing = ~own.answered & np.isfinite(own.frames[metric])
            cross: dict[str, Any] = {
                "marker": "x",
                "linestyle": "none",
                "color": look.colour,
                "markersize": 5,
                "gid": f"missing-{n}",
            }
            if missing.any():
                axes.plot(own.seconds[missing], own.frames[metric][missing], **cross)
    every = np.concatenate(drawn)
    _scale(axes, "y", np.append(every, min(highest, _BAND * np.nanmax(every, initial=0.0))), drawn)
    axes.set_ylabel(f"{METRICS[metric].name}\n{METRICS[metric].label}", fontsize=style.TEXT_SIZE)
    axes.set_xlabel("time since the given frames (s)", fontsize=style.TEXT_SIZE)
    axes.set_xlim(0.0, end)
    style.draw_grid(axes)


def _draw_cumulative(axes: Axes, tables: ErrorTables, metric: str, looks: Several[Look]) -> None:
    samples = [own.samples(metric) for own in tables.errors]
    for n, (values, look) in enumerate(zip(samples, looks, strict=True)):
        error, share = cumulative(values)
        place: dict[str, Any] = {
            "drawstyle": "steps-post",
            "color": look.colour,
            "linestyle": look.dashes,
            "linewidth": 1.7,
        }
        axes.plot(error, share, gid=f"line-{n}", **place)
    _error_axis(axes, tables, metric, samples)
    axes.set_ylim(0.0, 1.03)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: f"{share:.0%}"))
    axes.set_ylabel(f"share of {tables.unit}", fontsize=style.TEXT_SIZE)
    style.draw_grid(axes)


_DRAW = {"over-time": _draw_over_time, "cumulative": _draw_cumulative}


def _error_axis(axes: Axes, tables: ErrorTables, metric: str, samples: Several[FloatArray]) -> None:
    """The horizontal scale of errors, with the cap and the failure limit of the protocol where it has them."""
    protocol = tables.errors[0].protocol
    marks = {"cap": protocol.caps.get(metric), "failed": protocol.failures.get(metric)}
    bounds = {name: bound for name, bound in marks.items() if bound is not None and tables.only is None}
    every = np.concatenate([*samples, np.array(list(bounds.values()))])
    _scale(axes, "x", every, samples)
    for name, bound in bounds.items():
        axes.axvline(bound, color=style.INK, linewidth=0.9, linestyle="-" if name == "cap" else (0, (3, 2)), gid=name)
        look: dict[str, Any] = {"textcoords": "offset points", "fontsize": 7.0, "color": style.INK, "va": "bottom"}
        side: dict[str, Any] = {"cap": {"ha": "left"}, "failed": {"ha": "right"}}[name]
        axes.annotate(name, (bound, 1.0), (0, 1.5), xycoords=("data", "axes fraction"), **look, **side)
    axes.set_xlabel(METRICS[metric].label, fontsize=style.TEXT_SIZE)


def _scale(axes: Axes, which: str, values: FloatArray, solvers: Several[FloatArray]) -> None:
    """A linear scale from 0, or a logarithmic one where errors differ too much for that."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    positive = values[np.isfinite(values) & (values > 0.0)]
    middles = [np.nanmedian(own) for own in solvers if np.isfinite(own).any()]
    middles = [middle for middle in middles if middle > 0.0]
    largest = float(positive.max(initial=1e-9))
    if not middles or largest < _FLAT * min(middles):
        axes.set(**{f"{which}lim": (0.0, 1.04 * largest)})
        return
    lowest = max(float(np.quantile(positive, 0.01)), 0.02 * min(middles))
    axes.set(**{f"{which}scale": "log", f"{which}lim": (0.8 * lowest, 1.35 * largest)})
    wide = np.log10(largest / lowest)
    axis.set_major_locator(LogLocator(subs=(1.0,) if wide > 2.2 else (1.0, 3.0) if wide > 1.4 else (1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
