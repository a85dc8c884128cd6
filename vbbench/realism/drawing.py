"""The realism report as a picture: a panel per distribution, a line per source."""

from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.saving import save_picture
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.realism.histogram import BINS, Histogram
from vbbench.realism.report import Realism
from vbbench.realism.walking import ACCELERATION, COLLISION, EFFICIENCY, NEAREST

_SIZE = (11.0, 7.4)
_PARTS: Rectangles = {
    "speed": (0.75, 3.75, 4.7, 2.45),
    "nearest distance": (6.15, 3.75, 4.7, 2.45),
    "acceleration": (0.75, 0.6, 4.7, 2.45),
    "path efficiency": (6.15, 0.6, 4.7, 2.45),
}
_COLOURS = (style.ESTIMATE, style.GIVEN, style.INK, style.TRUTH)
_LINES = ("-", "--", ":", "-.")
_STEPS = 60
"""Most steps of a line over its panel."""
_WALK_STEPS = 25
"""The same for path efficiency: there are few walks."""
_REACH = 0.95
"""Share of the samples of every source that a panel holds at least."""
_FLOOR = 0.01
"""Least density shown on a logarithmic scale."""


def plot_realism(report: Realism) -> Figure:
    """Draw the four distributions of every source of the report."""
    figure = lay_out(_SIZE, _PARTS)
    columns = zip(*(walking.distributions for walking in report.columns.values()), strict=True)
    for axes, histograms in zip(figure.axes, columns, strict=True):
        _draw_panel(axes, histograms, list(report.columns))
    facts = [f"every panel holds {_REACH:.0%} of each source, or more"]
    facts += [f"{name} not available" for name in report.missing]
    legend = next(axes for axes in figure.axes if axes.get_label() == NEAREST.name)
    title = f"How people walk: {report.info.split} beside recordings"
    draw_heading(figure, 0.75, title, ";  ".join(facts), legend)
    return figure


def plot_realism_to_file(report: Realism, out: Path | str) -> Path:
    """Draw the report into a PNG, PDF or SVG file; see `save_picture`."""
    save_picture(plot_realism(report), out)
    return Path(out)


def _draw_panel(axes: Axes, histograms: tuple[Histogram, ...], headings: list[str]) -> None:
    axis, edges = histograms[0].axis, _edges(histograms)
    if axis is NEAREST:
        label = f"collision: under {COLLISION:g} m"
        axes.axvspan(0.0, COLLISION, color=style.TRUTH_FAINT, label=label, gid="collision")
    for histogram, heading, colour, line in zip(histograms, headings, cycle(_COLOURS), cycle(_LINES), strict=False):
        look: dict[str, Any] = {"color": colour, "linestyle": line, "linewidth": 1.4, "label": heading, "gid": heading}
        axes.stairs(histogram.density(edges), edges, baseline=None, **look)
    axes.set_xlim(0.0, edges[-1])
    axes.set_xlabel(axis.title, fontsize=style.TEXT_SIZE)
    axes.set_ylabel(f"share of samples per {axis.unit}" if axis.unit else "density of walks", fontsize=style.TEXT_SIZE)
    if axis in (ACCELERATION, EFFICIENCY):  # a linear scale would show the peak alone
        axes.set_yscale("log", nonpositive="clip")
        axes.set_ylim(bottom=_FLOOR)
    else:
        axes.set_ylim(bottom=0.0)


def _edges(histograms: tuple[Histogram, ...]) -> FloatArray:
    """Edges of the steps, which are edges of bins, as far as the panel reaches."""
    axis, bin_width = histograms[0].axis, histograms[0].axis.upper / BINS
    far = max((h.quantile(_REACH) for h in histograms if h.count), default=axis.upper)
    bins = BINS if axis is EFFICIENCY else min(max(int(np.ceil(far / bin_width)), _STEPS), BINS)
    step = -(-bins // (_WALK_STEPS if axis is EFFICIENCY else _STEPS))
    return np.arange(0, bins + step, step).clip(max=BINS) * bin_width
