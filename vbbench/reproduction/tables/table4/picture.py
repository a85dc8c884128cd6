"""Table 4 as a picture: a frame with both inputs as the observer sees it, and errors over inputs."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, NullFormatter

from vbbench.paper import COLUMNS, PROTOCOLS
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.reproduction.tables.table4.inputs import Input
from vbbench.reproduction.tables.table4.study import SPLIT, Example, Table4
from vbbench.scoring.metrics import METRICS

COLOURS = (style.GIVEN, style.ESTIMATE, "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
LOOKS: Mapping[str, dict[str, Any]] = {
    "one-step": {"linestyle": "-", "linewidth": 1.6},
    "sequential": {"linestyle": (0, (2.5, 2.0)), "linewidth": 1.0, "fillstyle": "none"},
}
ASPECT = 0.36
"""Width of a person's box over its height, as the tracker's boxes have it."""
SKY = 0.2
"""Upper part of the picture that is not drawn: nobody is there."""
_WIDTH, _HEIGHT, _LEFT = 13.0, 7.25, 0.7  # inches
_VIEW, _PANEL, _STEP = (5.95, 2.68), (2.45, 2.35), 3.12


def plot_table4(found: Table4, paper: Mapping[str, Mapping[str, float]]) -> Figure:
    """Draw what the observer sees of both inputs, and the errors that come of them, beside the ``paper``'s."""
    rectangles: Rectangles = {
        **{name: (_LEFT + n * (_VIEW[0] + 0.1), 3.55, *_VIEW) for n, name in enumerate(("lines", "boxes"))},
        **{name: (_LEFT + n * _STEP, 0.75, *_PANEL) for n, name in enumerate(COLUMNS)},
    }
    drawn = lay_out((_WIDTH, _HEIGHT), rectangles)
    axes = {one.get_label(): one for one in drawn.axes}
    _draw_lines(axes["lines"], found.example, found.study.lines[-1])
    _draw_boxes(axes["boxes"], found.example)
    for metric in COLUMNS:
        _draw_panel(axes[metric], metric, found, {name: own[metric] for name, own in paper.items()})
    facts = (
        f"split {SPLIT}, seed {found.study.seed}, {found.sequences} sequences; below: means over frames, as the paper "
        "has them; tracks of 4 frames or more"
    )
    draw_heading(drawn, _LEFT, "Centre lines and a tracker's boxes", facts, axes["lines"])
    _draw_legend(drawn, found)
    return drawn


def _draw_view(axes: Axes, example: Example, title: str) -> None:
    """The empty picture with its horizon."""
    width, height = example.camera.picture_size
    horizon = float(example.camera.horizon(np.array([width / 2.0]))[0])
    axes.add_patch(Rectangle((0, 0), width, horizon, color="#f4f7fa", zorder=0))
    axes.add_patch(Rectangle((0, horizon), width, height - horizon, color=style.FIELD, zorder=0))
    axes.axhline(horizon, color=style.FIELD_EDGE, linewidth=0.8, zorder=1)
    axes.set_xlim(0, width)
    axes.set_ylim(height, SKY * height)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_title(title, fontsize=10.0, loc="left", color=style.INK)


def _draw_lines(axes: Axes, example: Example, line: Input) -> None:
    hand = f"jitter of {line.jitter:g} px" if line.jitter else "exact"
    _draw_view(axes, example, f"cline ({hand}), sequence {example.sequence}, frame {example.frame}")
    u, v, length = example.lines[np.argsort(example.lines[:, 2])].T
    ends = np.stack([np.stack([u, v - length / 2], axis=-1), np.stack([u, v + length / 2], axis=-1)], axis=1)
    axes.add_collection(LineCollection(list(ends), colors=style.INK, linewidths=1.2, zorder=3))
    axes.plot(*ends.reshape(-1, 2).T, linestyle="none", marker="o", markersize=2.6, color=style.INK, zorder=4)


def _draw_boxes(axes: Axes, example: Example) -> None:
    _draw_view(axes, example, "tracked, the same frame: that with the most tracks of somebody else")
    for (u, v, length), first, nobody in zip(example.boxes, example.first, example.nobody, strict=True):
        colour = style.UNSEEN if nobody else style.GIVEN if first else style.ESTIMATE
        corner, size = (u - ASPECT * length / 2, v - length / 2), (ASPECT * length, length)
        axes.add_patch(Rectangle(corner, *size, fill=True, facecolor=(*_rgb(colour), 0.12), edgecolor="none", zorder=2))
        axes.add_patch(Rectangle(corner, *size, fill=False, edgecolor=colour, linewidth=1.3, zorder=3))
    labels = {
        style.GIVEN: "still the person it began with",
        style.ESTIMATE: "somebody else by now",
        style.UNSEEN: "nobody",
    }
    handles = [Line2D([], [], color=colour, linewidth=2.0, label=label) for colour, label in labels.items()]
    axes.legend(handles=handles, loc="upper right", fontsize=style.TEXT_SIZE, frameon=True, framealpha=0.9, ncols=3)


def _rgb(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))


def _draw_panel(axes: Axes, metric: str, found: Table4, paper: Mapping[str, float]) -> None:
    study = found.study
    kept, _, linked = study.tracks
    inputs = (*study.lines, kept, linked)
    places, lines = np.arange(len(inputs)), len(study.lines)
    for solver, colour in zip(dict.fromkeys(study.solvers), _colours(found), strict=True):
        for protocol in PROTOCOLS:
            means = [found.figures(protocol, solver, one)[metric].frame_mean for one in inputs]
            look = {"color": colour, "marker": "o", "markersize": 4.0, **LOOKS[protocol]}
            axes.plot(places[:lines], means[:lines], **look)
            axes.plot(places[lines:], means[lines:], **look)
    axes.axvspan(lines - 0.5, len(inputs) - 0.5, color="#f6f6f6", zorder=0)
    look = {"color": style.INK, "linewidth": 2.2, "zorder": 5, "solid_capstyle": "butt"}
    axes.plot([-0.4, lines - 0.6], [paper["cline"]] * 2, **look)
    axes.plot([lines - 0.4, len(inputs) - 0.6], [paper["tracked"]] * 2, **look)
    times, middle = paper["tracked"] / paper["cline"], (lines + len(inputs) - 1) / 2
    look = {"ha": "center", "va": "bottom", "fontsize": style.TEXT_SIZE, "color": style.INK}
    axes.text(middle, 1.08 * paper["tracked"], f"× {times:.2f}", **look)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(numticks=8))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xlim(-0.5, len(inputs) - 0.5)
    names = [f"{one.jitter:g} px" if one.jitter else "exact" for one in study.lines]
    axes.set_xticks(places, [*names, "tracked", "true\nids"], fontsize=7.0)
    axes.set_title(METRICS[metric].label, fontsize=10.0, loc="left", color=style.INK)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def _colours(found: Table4) -> list[str]:
    return [COLOURS[n % len(COLOURS)] for n in range(len(dict.fromkeys(found.study.solvers)))]


def _draw_legend(drawn: Figure, found: Table4) -> None:
    """Solvers, protocols and the paper, below all panels."""
    solvers = dict.fromkeys(found.study.solvers)
    handles = [
        Line2D([], [], color=colour, marker="o", markersize=4.0, label=solver)
        for solver, colour in zip(solvers, _colours(found), strict=True)
    ]
    handles += [
        Line2D([], [], color=style.TRUTH, marker="o", markersize=4.0, label=protocol, **LOOKS[protocol])
        for protocol in PROTOCOLS
    ]
    handles.append(Line2D([], [], color=style.INK, linewidth=2.2, label="the paper"))
    place = (_LEFT / _WIDTH, 0.12 / _HEIGHT)
    look: dict[str, Any] = {"borderaxespad": 0.0, "frameon": False, "fontsize": style.TEXT_SIZE}
    drawn.legend(handles=handles, loc="lower left", bbox_to_anchor=place, ncols=len(handles), **look)
