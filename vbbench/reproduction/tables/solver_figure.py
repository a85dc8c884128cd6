"""The picture of the paper's Tables 2 and 3: Δx and Δt of every solver, a column of panels for each recording."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from vbbench.paper import SIGMA_H, the_paper
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.reproduction.tables.solver_tables import SolverRow, SolverTable, counterpart
from vbbench.scoring.metrics import METRICS

PANELS = ("dx", "dt")
"""The metrics that are drawn, from the top."""

_WIDTH, _LEFT, _GAP, _LINE = 11.0, 1.25, 0.25, 0.4  # inches: the whole, names, between panels, height of a row
_BETWEEN, _HEAD, _FOOT = 0.75, 1.15, 0.55
_APART = 0.18
"""How far, in rows, protocols are from the middle of their solver's row."""
_LOOKS: Sequence[dict[str, Any]] = ({"marker": "o", "color": style.GIVEN}, {"marker": "s", "color": style.INK})
"""Of the protocols, in their order."""
_DOT, _RING = 4.5, 8.5
"""Sizes in points of the marks at the paper's σ_h and at others: where both agree, a ring is around a dot."""


def plot_solver_table(found: SolverTable, facts: str) -> Figure:
    """Draw Δx and Δt over sequences with 95 % intervals, and the paper's figures as marks."""
    splits, height = list(found.measured), _LINE * len(found.study.solvers)
    size = (_WIDTH, _HEAD + 2 * height + _BETWEEN + _FOOT)
    step = (_WIDTH - _LEFT) / len(splits)
    panels: Rectangles = {
        f"{split} {metric}": (_LEFT + n * step, _FOOT + (1 - m) * (height + _BETWEEN), step - _GAP, height)
        for m, metric in enumerate(PANELS)
        for n, split in enumerate(splits)
    }
    drawn = lay_out(size, panels)
    for axes in drawn.axes:
        split, _, metric = str(axes.get_label()).rpartition(" ")
        _draw_panel(axes, found, split, metric)
        if split == splits[0]:
            axes.set_yticks(range(len(found.study.solvers)), found.study.solvers)
        if metric == PANELS[0]:
            axes.set_title(found.name(split), fontsize=10.0, loc="left", color=style.INK)
    _draw_legend(drawn.axes[0], found)
    sure = any(np.isfinite(row.summaries[metric].ci95).all() for row in found.rows for metric in PANELS)
    bars = "with 95 % intervals" if sure else "(too little time for intervals)"
    title = f"Table {found.study.table}: Δx and Δt of every solver, mean over sequences {bars}"
    draw_heading(drawn, 0.3, title, f"panorama, tier ideal, {facts}", drawn.axes[0])
    return drawn


def _draw_panel(axes: Axes, found: SolverTable, split: str, metric: str) -> None:
    solvers, protocols = list(found.study.solvers), list(found.study.protocols)
    for row in found.of(split):
        side = 2 * _APART * (protocols.index(row.protocol) - (len(protocols) - 1) / 2)
        _draw_row(axes, row, metric, solvers.index(row.solver) + side, _look(found, row.protocol))
    for place, solver in enumerate(solvers):
        printed = the_paper().figures(split, counterpart(solver)).get(metric)
        if printed is not None:
            axes.plot(2 * [printed], [place - 0.36, place + 0.36], color=style.ESTIMATE, linewidth=2.4, zorder=1.5)
    axes.set_xscale("log")
    axes.set_xlim(*_limits(found, metric))
    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(len(solvers) - 0.5, -0.5)
    axes.set_yticks(range(len(solvers)), [])
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(METRICS[metric].label, fontsize=style.TEXT_SIZE)
    axes.grid(axis="x", color=style.FAINT, linewidth=0.8)
    axes.set_axisbelow(True)
    for place in range(1, len(solvers)):
        axes.axhline(place - 0.5, color=style.FAINT, linewidth=0.8)


def _draw_row(axes: Axes, row: SolverRow, metric: str, place: float, look: dict[str, Any]) -> None:
    own = row.summaries[metric]
    if row.sigma_h != SIGMA_H:
        axes.plot(own.mean, place, markersize=_RING, fillstyle="none", linestyle="none", **look)
        return
    axes.plot(own.ci95, 2 * [place], color=look["color"], linewidth=1.4)
    axes.plot(own.mean, place, markersize=_DOT, linestyle="none", **look)


def _look(found: SolverTable, protocol: str) -> dict[str, Any]:
    return _LOOKS[list(found.study.protocols).index(protocol) % len(_LOOKS)]


def _limits(found: SolverTable, metric: str) -> tuple[float, float]:
    """The same for all recordings, so that they can be compared."""
    values = np.array([*_values(found, metric)])
    values = values[values > 0.0]  # a NaN is none
    return float(values.min()) / 1.6, float(values.max()) * 1.6


def _values(found: SolverTable, metric: str) -> Iterator[float]:
    for row in found.rows:
        own = row.summaries[metric]
        yield from (own.mean, *own.ci95, row.compared_with.get(metric, np.nan))


def _draw_legend(axes: Axes, found: SolverTable) -> None:
    """Nothing but labels, for the legend."""
    nothing: dict[str, Any] = {"linestyle": "none"}
    for protocol in found.study.protocols:
        axes.plot(
            [], [], markersize=_DOT, label=f"{protocol}, σ_h = {SIGMA_H:g} m", **nothing, **_look(found, protocol)
        )
    for sigma_h in found.study.sigmas:
        if sigma_h != SIGMA_H:
            ring: dict[str, Any] = {"marker": "o", "color": style.TRUTH, "fillstyle": "none", "markersize": _RING}
            axes.plot([], [], label=f"σ_h = {sigma_h:g} m", **nothing, **ring)
    axes.plot([], [], color=style.ESTIMATE, linewidth=2.4, label=f"the paper's, over frames, σ_h = {SIGMA_H:g} m")
