"""Table 1 as a picture: how many people there are and how long sequences are, with the paper's figures beneath."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator

from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.reproduction.at_hand import how_to_get
from vbbench.reproduction.tables.counting import Tally
from vbbench.reproduction.tables.table1_rows import Row

Counted = tuple[Row, Tally | None]

_WIDTH, _HEAD, _FOOT, _ROW = 11.0, 1.0, 0.62, 0.9  # inches
_LEFT, _PEOPLE, _FRAMES = 0.3, (2.4, 4.1), (7.85, 2.3)
"""Left edge of the names, left edge and width of the panels, in inches; figures stand to the right of both panels."""
_OURS, _PAPERS, _LOWEST, _HIGHEST = -0.24, -0.58, -0.8, 1.02
"""Heights of the two ranges and of a panel's edges; histograms are .95 high."""
_TICKS = (1, 3, 10, 30, 100, 300, 1000)
_STEPS = 55


def plot_table1(rows: Sequence[Counted]) -> Figure:
    """Draw a line for every row that is here, and for those that nothing else stands for."""
    shown = _shown(rows)
    height = _HEAD + _ROW * len(shown) + _FOOT
    drawn = lay_out((_WIDTH, height), _panels(len(shown)))
    for line, (row, tally) in enumerate(shown):
        people, frames = drawn.axes[2 * line : 2 * line + 2]
        _draw_names(drawn, row, tally, (_bottom(len(shown), line) + 0.36) / height)
        _draw_people(people, row, tally)
        _draw_frames(frames, row, tally)
        last = line == len(shown) - 1
        _finish(people, "people" if last else "")
        _finish(frames, "frames of a sequence" if last else "")
    legend = next((axes for (_, tally), axes in zip(shown, drawn.axes[::2], strict=True) if tally), drawn.axes[0])
    title = "How many people, and how many frames: the splits beside the paper's Table 1"
    facts = (
        "figures: least / mean / most people, and mean frames; heights within a panel are shares, on a scale of its own"
    )
    draw_heading(drawn, _LEFT, title, facts, legend)
    return drawn


def _shown(rows: Sequence[Counted]) -> list[Counted]:
    """Rows that are here, and missing ones whose figures of the paper stand in no other line."""
    here = {row.printed for row, tally in rows if tally is not None}
    return [(row, tally) for row, tally in rows if tally is not None or row.printed not in here]


def _panels(lines: int) -> Rectangles:
    return {
        f"{name} {line}": (left, _bottom(lines, line), width, _ROW - 0.12)
        for line in range(lines)
        for name, (left, width) in (("people", _PEOPLE), ("frames", _FRAMES))
    }


def _bottom(lines: int, line: int) -> float:
    """Lower edge of a line's panels, in inches from below."""
    return _FOOT + (lines - 1 - line) * _ROW


def _draw_names(drawn: Figure, row: Row, tally: Tally | None, middle: float) -> None:
    left = _LEFT / _WIDTH
    drawn.text(left, middle + 0.016, row.title, fontsize=10.0, weight="bold", color=style.INK)
    ours = "" if tally is None else f"{len(tally.frames)} sequences"
    paper = f"the paper {row.printed.sequences}" if row.printed.sequences != "–" else ""
    text = ", ".join(filter(None, (ours, paper)))
    drawn.text(left, middle - 0.012, text, fontsize=style.TEXT_SIZE, color=style.TRUTH)


def _draw_people(axes: Axes, row: Row, tally: Tally | None) -> None:
    axes.axhline(0.0, color=style.TRUTH_FAINT, linewidth=0.8)
    if tally is None:
        look: dict[str, Any] = {"fontsize": style.TEXT_SIZE, "style": "italic", "color": style.TRUTH}
        command = how_to_get(row.split).replace("`", "")
        axes.text(0.5, 0.62, f"missing: {command}", ha="center", transform=axes.transAxes, **look)
    else:
        _draw_crowd(axes, row, tally)
        people = row.people(tally)
        _draw_range(axes, _OURS, (people.min(), people.mean(), people.max()), style.GIVEN, "o", "ours")
        _write(axes, _OURS, f"{people.min()} / {people.mean():.2f} / {people.max()}", style.GIVEN)
    _draw_range(axes, _PAPERS, row.printed.bounds, style.ESTIMATE, "D", "the paper's")
    _write(axes, _PAPERS, row.printed.people, style.ESTIMATE)


def _draw_crowd(axes: Axes, row: Row, tally: Tally) -> None:
    edges, blue = _edges(), style.GIVEN
    axes.stairs(_heights(tally.in_a_frame, edges), edges, fill=True, color=blue, alpha=0.3, label="in a frame")
    passing = _heights(tally.passing, edges)
    axes.stairs(passing, edges, baseline=None, color=blue, linewidth=1.0, label="seen during a sequence")
    if row.counted == "of the scene" and tally.crowd is not None:
        sizes, often = np.unique(tally.crowd, return_counts=True)
        heights = 0.95 * often / often.max()
        axes.vlines(sizes, 0.0, heights, color=style.INK, linewidth=2.0, label="in the scene")


def _draw_frames(axes: Axes, row: Row, tally: Tally | None) -> None:
    axes.axhline(0.0, color=style.TRUTH_FAINT, linewidth=0.8)
    if tally is not None:
        edges = _edges()
        axes.stairs(_heights(tally.frames, edges), edges, fill=True, color=style.GIVEN, alpha=0.3)
        mean = float(tally.frames.mean())
        _draw_range(axes, _OURS, (tally.frames.min(), mean, tally.frames.max()), style.GIVEN, "o", "")
        _write(axes, _OURS, f"{mean:.2f}", style.GIVEN)
    axes.plot(row.printed.mean_frames, _PAPERS, marker="D", markersize=5.0, color=style.ESTIMATE)
    _write(axes, _PAPERS, row.printed.frames, style.ESTIMATE)


def _draw_range(
    axes: Axes, height: float, bounds: tuple[float, float, float], colour: str, marker: str, label: str
) -> None:
    """A line from the least to the most, with its ends, and a mark at the mean."""
    least, mean, most = bounds
    axes.plot([least, most], [height, height], color=colour, linewidth=1.6, marker="|", markersize=7.0)
    axes.plot(
        mean,
        height,
        marker=marker,
        markersize=5.0,
        color=colour,
        linestyle="none",
        label=f"{label}: mean" if label else None,
    )


def _edges() -> FloatArray:
    """Edges of bins of numbers, as even on a logarithmic scale as whole numbers can be."""
    return np.unique(np.geomspace(1.0, 1200.0, _STEPS).round()) - 0.5


def _heights(counts: IntArray, edges: FloatArray) -> FloatArray:
    """Shares of the numbers in each bin by the bin's width on a logarithmic scale, the highest .95."""
    shares = np.histogram(counts, edges)[0] / np.diff(np.log(edges))
    return np.asarray(0.95 * shares / shares.max())


def _finish(axes: Axes, label: str) -> None:
    axes.set_xscale("log")
    axes.set_xlim(0.8, 1250.0)
    axes.set_ylim(_LOWEST, _HIGHEST)
    axes.set_xticks(_TICKS, [str(tick) for tick in _TICKS] if label else [])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_yticks([])
    axes.grid(axis="x", color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(length=0 if not label else 3)
    for side in ("top", "left", "right"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(style.TRUTH_TAIL if label else "none")
    if label:
        axes.set_xlabel(label, fontsize=style.TEXT_SIZE)


def _write(axes: Axes, height: float, text: str, colour: str) -> None:
    """A figure to the right of its range."""
    where = axes.get_yaxis_transform()
    axes.text(1.02, height, text, transform=where, fontsize=style.TEXT_SIZE, color=colour, va="center_baseline")
