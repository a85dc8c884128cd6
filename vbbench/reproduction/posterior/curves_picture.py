"""The entropies as curves: over the number of people, and at equal number over how people walk and stand around."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, lay_out
from vbbench.reproduction.posterior.effects import less_the_mean
from vbbench.reproduction.posterior.study import REPORTED, SOLVER, Posteriors

PEOPLE = ((2, 3), (4, 4), (5, 5), (6, 6), (7, 8), (9, 10), (11, 12), (13, 15), (16, 26))
"""Numbers of people seen that are taken together."""
SPREADS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 1.001)
"""Ends of the spreads that are taken together."""
_SPREADS_OF = ("spread", "bearings")
_TICKS = (3, 4, 5, 7, 10, 15, 25)
_TEXT = "the paper's text"
_SIZE = (13.9, 4.75)
_PANELS: Rectangles = {
    "entropy": (0.65, 0.55, 2.72, 2.95),
    "kurtosis": (4.05, 0.55, 2.72, 2.95),
    "spread": (7.5, 0.55, 2.72, 2.95),
    "bearings": (10.95, 0.55, 2.72, 2.95),
}


def groups_of(values: FloatArray, groups: tuple[tuple[int, int], ...]) -> IntArray:
    """The number of the group [F] of each value, −1 for none."""
    found = np.full(len(values), -1)
    for number, (least, most) in enumerate(groups):
        found[(values >= least) & (values <= most)] = number
    return found


def spread_groups(spread: FloatArray) -> IntArray:
    """The number of the stretch of `SPREADS` of each spread, −1 where nobody moves."""
    return np.where(np.isnan(spread), -1, np.searchsorted(SPREADS, spread, side="right") - 1)


def plot_curves(found: Posteriors) -> Figure:
    """Draw entropy and kurtosis over the number of people, and entropy at equal number over both spreads."""
    figure = lay_out(_SIZE, _PANELS)
    parts = {axes.get_label(): axes for axes in figure.axes}
    people = found.walking["people"]
    number = groups_of(people, PEOPLE)
    for solver, table in found.tables.items():
        own = solver == SOLVER
        look: dict[str, Any] = {"color": style.GIVEN if own else style.ESTIMATE, "label": SOLVER if own else _TEXT}
        _curve(parts["entropy"], found, table.pose, number, people, **look)
        _curve(parts["kurtosis"], found, table.kurtosis, number, people, **look)
        _draw_at_equal_number(parts, found, table.pose, **look)
    other: dict[str, Any] = {"color": style.TRUTH, "label": f"{REPORTED}: its covariance", "marker": "s"}
    _curve(parts["entropy"], found, found.reported, number, people, **other)
    _draw_at_equal_number(parts, found, found.reported, **other)
    for name in ("entropy", "kurtosis"):
        parts[name].set_xscale("log")
        parts[name].set_xticks(_TICKS, [f"{tick}" for tick in _TICKS])
        parts[name].xaxis.set_minor_formatter(NullFormatter())
    for name in ("kurtosis", *_SPREADS_OF):
        parts[name].axhline(0.0, color=style.INK, linewidth=0.8, linestyle=":")
    _describe(parts)
    _draw_head(figure, found, parts["entropy"])
    return figure


def _draw_at_equal_number(parts: dict[Any, Axes], found: Posteriors, entropy: FloatArray, **look: Any) -> None:
    """Entropy [F] less the mean of frames with as many people, over both spreads."""
    known = ~np.isnan(entropy)
    rest = np.full(len(entropy), np.nan)
    rest[known] = less_the_mean(entropy[known], found.sample.people[known])
    for name in _SPREADS_OF:
        _curve(parts[name], found, rest, spread_groups(found.walking[name]), found.walking[name], **look)


def _curve(axes: Axes, found: Posteriors, values: FloatArray, group: IntArray, along: FloatArray, **look: Any) -> None:
    """Means over sequences with their intervals; each group stands at the mean of what it groups."""
    there = ~np.isnan(values)
    count = int(group.max()) + 1
    mean, interval = found.sample.means(values, group, count)
    x = np.array([along[there & (group == n)].mean() if (there & (group == n)).any() else np.nan for n in range(count)])
    known = ~np.isnan(mean) & ~np.isnan(x)
    axes.fill_between(x[known], *interval[known].T, color=look["color"], alpha=0.12, linewidth=0)
    axes.plot(x[known], mean[known], **{"linewidth": 1.6, "marker": "o", "markersize": 4.0, **look})


def _describe(parts: dict[Any, Axes]) -> None:
    titles = {
        "entropy": ("entropy of the observer's pose", "people seen", "nats of m² rad"),
        "kurtosis": ("tails of its place", "people seen", "kurtosis less that of a normal density"),
        "spread": ("at equal number of people", "spread of directions", "nats above the mean at that number"),
        "bearings": ("at equal number of people", "spread of bearings", "nats above the mean at that number"),
    }
    for name, (title, along, up) in titles.items():
        axes = parts[name]
        axes.set_title(title, fontsize=10.0, loc="left", color=style.INK)
        axes.set_xlabel(along, fontsize=style.TEXT_SIZE)
        axes.set_ylabel(up, fontsize=style.TEXT_SIZE)
        axes.grid(color=style.FAINT, linewidth=0.6)
        axes.set_axisbelow(True)
        _keep_to_the_means(axes)
    low, high = zip(*(parts[name].get_ylim() for name in _SPREADS_OF), strict=True)
    for name in _SPREADS_OF:
        parts[name].set_ylim(min(low), max(high))


def _keep_to_the_means(axes: Axes) -> None:
    """Let means, and not the widest of their intervals, say how far an axis goes."""
    heights = np.concatenate([np.asarray(line.get_ydata(), np.float64) for line in axes.lines])
    heights = heights[~np.isnan(heights)]
    if not len(heights) or not np.ptp(heights):
        return
    low, high = heights.min(), heights.max()
    axes.set_ylim(low - 0.25 * (high - low), high + 0.25 * (high - low))


def _draw_head(figure: Figure, found: Posteriors, axes: Axes) -> None:
    title = "How sure the observer's pose is, by how many people are seen and how they walk"
    facts = f"split {found.study.split}, one-step, seed {found.study.seed}, {len(found.sample.people)} frames of "
    facts += f"{found.sequences} sequences; means over sequences with 95 % intervals by blocks of time"
    style.draw_heading(figure, _PANELS["entropy"][0], title, facts, axes)
