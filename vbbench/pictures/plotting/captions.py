"""The texts of a figure: title, legend, distance scale, the facts next to them, and a small table of answers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vbbench.pictures.colours import Look
from vbbench.pictures.plotting import style
from vbbench.pictures.replay import Replay

_POINT: dict[str, Any] = {"marker": "o", "linestyle": "none"}


def draw_title(figure: Figure, replay: Replay, frame: int) -> None:
    """Over everything: what is shown, and the errors of the estimate in this frame."""
    heading = replay.heading(f"frame {frame} (0–{replay.sequence.frames - 1})")
    top, left = 1.0 - 0.32 / figure.get_figheight(), 0.6 / figure.get_figwidth()
    figure.text(left, top, heading, fontsize=12.5, weight="bold")
    below = top - 0.24 / figure.get_figheight()
    figure.text(left, below, replay.headline(frame), fontsize=10, color=style.INK)


def draw_scale(axes: Axes, colours: ScalarMappable) -> None:
    """Distance scale of both views."""
    bar = axes.figure.colorbar(colours, cax=axes, orientation="horizontal")
    bar.outline.set_linewidth(0.5)
    axes.tick_params(labelsize=style.TEXT_SIZE)
    axes.set_title("distance by the box (m)", fontsize=style.TEXT_SIZE, loc="left")


def draw_legend(axes: Axes, replay: Replay, frame: int) -> None:
    """What every mark of the map means, only marks that are there."""
    axes.set_axis_off()
    look: dict[str, Any] = {"loc": "upper left", "frameon": False, "fontsize": style.TEXT_SIZE, "borderpad": 0.0}
    axes.legend(handles=_handles(replay, frame), **look)


def draw_facts(axes: Axes, replay: Replay, frame: int, columns: tuple[float, float]) -> None:
    """What the numbers rest on: camera, frame time, people; and which part of a turn the ``columns`` in px show."""
    axes.set_axis_off()
    info = replay.info
    lines = [
        f"{int(replay.sequence.observed[frame].sum())} people seen, dt = {info.dt:g} s",
        f"f = {replay.camera.focal:.4g} px, h₀ = {replay.camera.mount_height:g} m",
        f"people's heights {info.height_mean:.2f} ± {info.height_std:.2f} m",
        "dashed: horizon; box widths are made up",
    ]
    if replay.sequence.observed[frame].sum() > style.MOST_LABELS:
        lines.append(f"ids of the nearest {style.MOST_LABELS}")
    if replay.camera.period is not None and columns[1] - columns[0] < replay.camera.period:
        turn = 360.0 * (columns[1] - columns[0]) / replay.camera.period
        lines.append(f"{turn:.0f}° shown; nobody is in the rest")
    axes.text(0.03, 1.0, "\n".join(lines), va="top", fontsize=style.TEXT_SIZE, color=style.INK, linespacing=1.4)


def _handles(replay: Replay, frame: int) -> list[Line2D]:
    revealed = replay.answer.protocol.revealed_frames if replay.answer else 0
    given = f"given, besides {revealed} frames before" if revealed else "given to the solver"
    handles = [_line(given, color=style.GIVEN, marker="D", markersize=4, linestyle="none", fill=False)]
    if replay.truth is not None:
        handles += _truth_handles(replay, frame)
    elif replay.answer is None:
        handles.append(_line("given observer and its viewing direction", color=style.TRUTH, marker="o", markersize=6))
        if np.isfinite(replay.given.positions).any():
            some = style.distance_colours()(0.35)
            handles.append(_line("given position now", **_POINT, color=some, markersize=5))
    if replay.answer is not None:
        handles += [
            _line("estimated observer and its path", color=style.ESTIMATE, marker="o", markersize=6),
            _line("estimated person and its path", color=style.distance_colours()(0.35), marker="o", markersize=4),
        ]
    if replay.truth is not None and replay.answer is not None:
        handles.append(_line("error, truth to estimate", color=style.INK, linewidth=1.1))
    if replay.camera.view is not None:
        handles.append(_line("field of view", color=style.FIELD_EDGE, marker="s", linestyle="none", markersize=8))
    return handles


def _truth_handles(replay: Replay, frame: int) -> list[Line2D]:
    now = {"color": style.TRUTH, "fill": False} if replay.answer else {"color": style.distance_colours()(0.35)}
    handles = []
    if replay.poses_known or replay.answer is None:
        text = "true observer and its path" if replay.poses_known else "observer, wherever it is"
        handles.append(_line(text, color=style.TRUTH, marker="o", markersize=6))
    if replay.places_known:
        where = "" if replay.poses_known else ", as seen from there"
        tracks = f"true tracks, last {style.TAIL_FRAMES} frames darker"
        handles.append(_line(tracks, color=style.TRUTH_TAIL, linewidth=1.0))
        handles.append(_line(f"true position now{where}", **_POINT, markersize=6, **now))
    if np.isfinite(replay.known.positions[frame][~replay.sequence.observed[frame]]).any():
        handles.append(_line("there, but not observed now", **_POINT, color=style.UNSEEN, markersize=4, fill=False))
    return handles


def _line(label: str, *, fill: bool = True, **look: Any) -> Line2D:
    if not fill:
        look["markerfacecolor"] = "none"
    return Line2D([], [], label=label, **look)


ROW = 0.19
"""Height of a row in inches."""
_SWATCH, _GAP = 24.0, 16.0  # points


def draw_table(axes: Axes, head: Sequence[str], rows: Sequence[Sequence[str]], looks: Sequence[Look]) -> None:
    """Draw a table of texts, the first column after the line of the row's look, the others set to the right."""
    axes.set_axis_off()
    box = axes.get_window_extent()
    per_point = axes.figure.dpi / 72.0
    axes.set(xlim=(0.0, box.width / per_point), ylim=(len(rows) + 1.0, 0.0))
    right = _SWATCH + 6.0
    for c, cells in enumerate(zip(head, *rows, strict=True)):
        wide = max(map(style.text_width, cells))
        place, side = (right, "left") if c == 0 else (right + wide, "right")
        for r, cell in enumerate(cells):
            bold = "bold" if c == 0 and r > 0 else "normal"
            look: dict[str, Any] = {"ha": side, "va": "center", "fontsize": style.TEXT_SIZE, "fontweight": bold}
            colour = style.TRUTH if r == 0 else style.INK
            axes.text(place, r + 0.5, cell, color=colour, gid=f"cell-{r}-{c}", **look)
        right += wide * (1.15 if c == 0 else 1.0) + _GAP
    for r, own in enumerate(looks):
        axes.plot([0.0, _SWATCH], [r + 1.5, r + 1.5], color=own.colour, linestyle=own.dashes, linewidth=2.2)
