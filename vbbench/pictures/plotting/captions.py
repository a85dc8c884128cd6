"""The words of the figure: title, legend, distance scale and the facts beside them."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vbbench.camera import PerspectiveCamera
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.moment import Moment
from vbbench.scoring.metrics import METRICS

_POINT: dict[str, Any] = {"marker": "o", "linestyle": "none"}


def draw_title(figure: Figure, moment: Moment) -> None:
    """Over everything: what is shown, how far the estimate is off in this frame, and the split's caution."""
    info, sequence = moment.info, moment.sequence
    what = [info.split, f"sequence {sequence.index}", f"frame {moment.frame} (0–{sequence.frames - 1})"]
    tier = info.tier if info.pixel_std == 0 else f"{info.tier} (σ = {info.pixel_std:g} px)"
    top, left = 1.0 - 0.32 / figure.get_figheight(), 0.6 / figure.get_figwidth()
    figure.text(left, top, "  ·  ".join([*what, info.camera.kind, tier]), fontsize=12.5, weight="bold")
    below = top - 0.24 / figure.get_figheight()
    figure.text(left, below, _result_line(moment), fontsize=10, color=style.INK)
    if info.caution:
        text = textwrap.shorten(f"Caution: {info.caution.split('. ')[0]}", 70, placeholder=" …")
        right = 1.0 - 0.2 / figure.get_figwidth()
        figure.text(right, below, text, fontsize=style.TEXT_SIZE, style="italic", color=style.CAUTION, ha="right")


def draw_scale(axes: Axes, colours: ScalarMappable) -> None:
    """Distance scale of both views."""
    bar = axes.figure.colorbar(colours, cax=axes, orientation="horizontal")
    bar.outline.set_linewidth(0.5)
    axes.tick_params(labelsize=style.TEXT_SIZE)
    axes.set_title("distance told by the box (m)", fontsize=style.TEXT_SIZE, loc="left")


def draw_legend(axes: Axes, moment: Moment, more: Sequence[Line2D] = ()) -> None:
    """What every mark of the map means, only marks that are there; and ``more``."""
    axes.set_axis_off()
    axes.legend(
        handles=[*_handles(moment), *more], loc="upper left", frameon=False, fontsize=style.TEXT_SIZE, borderpad=0.0
    )


def draw_facts(axes: Axes, moment: Moment) -> None:
    """What the numbers rest on: camera, frame time, people."""
    axes.set_axis_off()
    info = moment.info
    lines = [
        f"{int(moment.observed.sum())} people seen, dt = {info.dt:g} s",
        f"f = {info.camera.focal:.4g} px, h₀ = {info.camera.mount_height:g} m",
        f"people's heights {info.height_mean:.2f} ± {info.height_std:.2f} m",
        "dashed: horizon; box widths are made up",
    ]
    if moment.observed.sum() > style.MOST_LABELS:
        lines.append(f"ids of the nearest {style.MOST_LABELS}")
    axes.text(0.03, 1.0, "\n".join(lines), va="top", fontsize=style.TEXT_SIZE, color=style.INK, linespacing=1.4)


def _result_line(moment: Moment) -> str:
    if moment.estimate is None:
        return "truth" if moment.truth else "no truth at hand: what is given"
    parts = [f"{moment.solver or 'estimate'} ({moment.protocol.name})"]
    parts += [f"{METRICS[name].symbol} = {value:.3f} {METRICS[name].unit}" for name, value in moment.errors.items()]
    if moment.truth is None:
        parts.append("no truth at hand")
    return ",  ".join(parts)


def _handles(moment: Moment) -> list[Line2D]:
    revealed = moment.protocol.revealed_frames if moment.estimate else 0
    given = f"given, besides {revealed} frames before" if revealed else "given to the solver"
    handles = [_line(given, color=style.GIVEN, marker="D", markersize=4, linestyle="none", fill=False)]
    if moment.truth is not None:
        handles += _truth_handles(moment)
    elif moment.estimate is None:
        handles += [
            _line("given observer and its viewing direction", color=style.TRUTH, marker="o", markersize=6),
            _line("given position now", **_POINT, color=style.distance_colours()(0.35), markersize=5),
        ]
    if moment.estimate is not None:
        handles += [
            _line("estimated observer and its path", color=style.ESTIMATE, marker="o", markersize=6),
            _line("estimated person and its path", color=style.distance_colours()(0.35), marker="o", markersize=4),
        ]
    if moment.truth is not None and moment.estimate is not None:
        handles.append(_line("error, truth to estimate", color=style.INK, linewidth=1.1))
    if isinstance(moment.info.camera, PerspectiveCamera):
        handles.append(_line("field of view", color="#cbbf98", marker="s", linestyle="none", markersize=8))
    return handles


def _truth_handles(moment: Moment) -> list[Line2D]:
    now = {"color": style.TRUTH, "fill": False} if moment.estimate else {"color": style.distance_colours()(0.35)}
    handles = [
        _line("true observer and its path", color=style.TRUTH, marker="o", markersize=6),
        _line(f"true tracks, last {style.TAIL_FRAMES} frames darker", color=style.TRUTH_TAIL, linewidth=1.0),
        _line("true position now", **_POINT, markersize=6, **now),
    ]
    if np.isfinite(moment.known[~moment.observed]).any():
        handles.append(_line("there, but not observed now", **_POINT, color="#b5b5b5", markersize=4, fill=False))
    return handles


def _line(label: str, *, fill: bool = True, **look: Any) -> Line2D:
    if not fill:
        look["markerfacecolor"] = "none"
    return Line2D([], [], label=label, **look)
