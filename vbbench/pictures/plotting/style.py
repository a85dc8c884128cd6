"""Shared by figures: colours safe for colour-blind readers (Okabe and Ito; viridis), sizes, layout, words and labels.

Labels go where none covers another; their lengths are in points of the figure.
"""

import io
import textwrap
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.ticker import Locator, NullFormatter

from vbbench.errors import FileError
from vbbench.folders.replacing import write_bytes_atomically
from vbbench.geometry import FloatArray

DPI = 150
INK = "#222222"
TRUTH = "#6f6f6f"
TRUTH_FAINT = "#dcdcdc"
TRUTH_TAIL = "#a8a8a8"
ESTIMATE = "#d55e00"
GIVEN = "#0072b2"
UNSEEN = "#b5b5b5"
FIELD = "#f3efe2"
FIELD_EDGE = "#cbbf98"
FAINT = "#ededed"
CAUTION = "#9c2a00"

LABEL_SIZE = 6.5
TEXT_SIZE = 8.5
_LINE = 0.165  # inches from line to line of text
MOST_LABELS = 60
"""In larger crowds, only so many of the nearest people are labelled."""
TAIL_FRAMES = 8
"""Frames of the past drawn darker than the rest of a track."""

Rectangles = dict[str, tuple[float, float, float, float]]
"""Left, bottom, width and height in inches of every part of a figure, by its label."""


def distance_colours() -> Colormap:
    """Near is dark, far is light; the palest end is omitted because it does not show on white."""
    return ListedColormap(colormaps["viridis"](range(225)), "distance")


def lay_out(
    size: tuple[float, float], rectangles: Rectangles, cautions: Sequence[str] = (), margin: float = 0.6
) -> Figure:
    """An empty figure of that size in inches, with labelled axes in the rectangles.

    Cautions stand below everything, whole, ``margin`` from both sides; the figure grows by as many lines as they have.
    """
    width = size[0]
    lines = [line for text in cautions for line in wrap(text, 72.0 * (width - 2.0 * margin), text_width)]
    foot = _LINE * len(lines) + (0.1 if lines else 0.0)
    height = size[1] + foot
    figure = Figure((width, height), dpi=DPI, facecolor="white")
    for name, (left, bottom, wide, high) in rectangles.items():
        axes = figure.add_axes((left / width, (bottom + foot) / height, wide / width, high / height), label=name)
        axes.tick_params(labelsize=TEXT_SIZE)
    look: dict[str, Any] = {"fontsize": TEXT_SIZE, "style": "italic", "color": CAUTION, "va": "center"}
    for n, line in enumerate(lines):
        figure.text(margin / width, (foot - _LINE * (n + 0.5)) / height, line, gid=f"caution-{n}", **look)
    return figure


def text_width(text: str) -> float:
    """Points that a text takes in the default font at `TEXT_SIZE`."""
    font = get_font(_default_font())
    font.set_size(TEXT_SIZE, 72)
    font.set_text(text)
    return float(font.get_width_height()[0] / 64.0)


@cache
def _default_font() -> str:
    return findfont(FontProperties())


def wrap(text: str, room: float, width: Callable[[str], float]) -> list[str]:
    """The text in lines, none wider than ``room``, which has the unit of ``width``; a word that is wider is parted."""
    letters = max(1, len(text))
    lines = [text]
    while letters > 1 and max(map(width, lines), default=0.0) > room:
        letters = min(letters - 1, int(letters * room / max(map(width, lines))) + 1)
        lines = textwrap.wrap(text, letters, break_on_hyphens=False)
    return lines


def draw_heading(figure: Figure, left: float, title: str, facts: str, axes: Axes) -> None:
    """Over panels of one kind, from ``left`` inches on: a title, a line of facts, and the legend of ``axes``."""
    write_heading(figure, left, title, facts)
    x, height = left / figure.get_figwidth(), figure.get_figheight()
    handles, labels = axes.get_legend_handles_labels()
    look: dict[str, Any] = {"borderaxespad": 0.0, "borderpad": 0.2, "frameon": False, "fontsize": TEXT_SIZE}
    place = (x, 1.0 - 0.66 / height)
    figure.legend(handles, labels, loc="upper left", bbox_to_anchor=place, ncols=len(labels), **look)


def write_heading(figure: Figure, left: float, title: str, *lines: str) -> None:
    """A bold title and lines of facts below it, from ``left`` inches on."""
    x, height = left / figure.get_figwidth(), figure.get_figheight()
    figure.text(x, 1.0 - 0.34 / height, title, fontsize=12.5, weight="bold", color=INK)
    for n, line in enumerate(lines):
        figure.text(x, 1.0 - (0.58 + _LINE * n) / height, line, fontsize=TEXT_SIZE, color=INK)


def name_axes(axes: Axes, along: str = "", up: str = "") -> None:
    """Label both axes; "" leaves a label as it is."""
    if along:
        axes.set_xlabel(along, fontsize=TEXT_SIZE)
    if up:
        axes.set_ylabel(up, fontsize=TEXT_SIZE)


def draw_grid(axes: Axes, **look: Any) -> None:
    """Faint lines under everything else."""
    axes.grid(color=FAINT, linewidth=0.6, **look)
    axes.set_axisbelow(True)


def plain_logarithm(axis: Axis, locator: Locator) -> None:
    """Numbers as they are written on a logarithmic axis, such as 0.1, and none between the ticks of ``locator``."""
    axis.set_major_locator(locator)
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def fit(axes: Axes, low: FloatArray, high: FloatArray) -> FloatArray:
    """Show the ground from ``low`` to ``high`` (x, y) in m at equal scale, filling the axes; the spans [2] in m."""
    box = axes.get_window_extent()
    size = np.array([box.width, box.height])
    spans: FloatArray = max((high - low) / size) * size
    low, high = (low + high - spans) / 2.0, (low + high + spans) / 2.0
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal")
    return spans


def along_path(path: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """A function from places [..., 2] in m to those along, and to the left of, a path's [T, 2] way to its last place.

    The origin is its first place. Each sequence has its own world, turned at random; in these axes pictures of
    several can be compared.
    """
    known = path[np.isfinite(path[:, 0])]
    start, way = (known[0], known[-1] - known[0]) if len(known) else (np.zeros(2), np.array([1.0, 0.0]))
    angle = np.arctan2(way[1], way[0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return lambda places: (places - start) @ turn


def draw_points(axes: Axes, points: FloatArray, gid: str, **look: Any) -> None:
    """Mark points [N, 2] in m."""
    axes.scatter(points[:, 0], points[:, 1], gid=gid, **look)


def draw_lines(
    axes: Axes, lines: Iterable[FloatArray], colours: Any, width: float, zorder: float, dashes: Any = "-"
) -> LineCollection:
    """Draw N lines, each through points [M, 2] in m."""
    drawn = LineCollection(list(lines), colors=colours, linewidths=width, zorder=zorder, linestyles=dashes)
    axes.add_collection(drawn, autolim=False)
    return drawn


_DIRECTIONS = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)], dtype=np.float64)


def text_extent(texts: list[str], size: float) -> FloatArray:
    """Width and height [N, 2] of digits set in the default font at ``size`` points."""
    return np.array([(0.65 * size * len(text), 0.8 * size) for text in texts]).reshape(-1, 2)


def spread(wanted: FloatArray, gap: float, low: float, high: float) -> FloatArray:
    """Places [N] nearest to ``wanted`` (least squares), in its order, ``gap`` apart and between ``low`` and ``high``.

    Where they do not all fit, the gap shrinks until they do.
    """
    if len(wanted) == 0:
        return wanted
    order = np.argsort(wanted, kind="stable")
    gap = min(gap, (high - low) / max(len(wanted) - 1, 1))
    ramp = gap * np.arange(len(wanted))
    places = np.empty_like(wanted)
    places[order] = np.clip(_rising(wanted[order] - ramp), low, high - ramp[-1]) + ramp
    return places


def _rising(values: FloatArray) -> FloatArray:
    """Never falling numbers [N] nearest to ``values`` by least squares: max over i ≤ k of min over j ≥ k of mean i…j.

    For the few labels of a figure; loading `scipy.optimize` for its isotonic regression takes longer than the figure.
    """
    begin, end = np.mgrid[: len(values), : len(values)]
    total = np.concatenate([[0.0], np.cumsum(values)])
    means = np.where(begin <= end, (total[end + 1] - total[begin]) / np.maximum(end - begin + 1, 1), np.inf)
    least = np.minimum.accumulate(means[:, ::-1], axis=1)[:, ::-1]
    rising: FloatArray = np.max(np.where(begin <= end, least, -np.inf), axis=0)
    return rising


def free_offsets(points: FloatArray, extents: FloatArray, obstacles: FloatArray, clearance: float) -> FloatArray:
    """Offsets [N, 2] from points [N, 2] to the centres of their labels; NaN where no free place was found.

    Labels are placed in order. Each avoids the labels before it and all obstacles [M, 2].
    """
    offsets = np.full(points.shape, np.nan)
    centres, halves = np.empty((0, 2)), np.empty((0, 2))
    for n, (point, extent) in enumerate(zip(points, extents, strict=True)):
        half = extent / 2.0
        for offset in _DIRECTIONS * (half + clearance):
            centre = point + offset
            free = not _overlap(centre, half, centres, halves) and not _overlap(centre, half, obstacles, clearance / 2)
            if free:
                offsets[n] = offset
                centres, halves = np.vstack([centres, centre]), np.vstack([halves, half])
                break
    return offsets


def _overlap(centre: FloatArray, half: FloatArray, centres: FloatArray, halves: FloatArray | float) -> bool:
    return bool(np.any(np.all(np.abs(centres - centre) < half + halves, axis=-1)))


_NO_DATES: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": None},
}
"""By the endings of files: facts about their making that are not written."""

_TEXT_AS_TEXT = {"pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "vbbench"}
"""Fonts are TrueType, embedded in a PDF; names in an SVG follow from its shapes, not from chance."""


def save_picture(figure: Figure, path: Path | str) -> None:
    """Write a figure as PNG, PDF or SVG, as its name ends; the file is there whole or not at all.

    Raises FileError if the name ends in something else.
    """
    path = Path(path)
    check_ending(path)
    ending = path.suffix.lower()
    picture = io.BytesIO()
    with mpl.rc_context(_TEXT_AS_TEXT):  # type: ignore[arg-type]
        figure.savefig(picture, format=ending[1:], dpi=DPI, metadata=_NO_DATES[ending])
    write_bytes_atomically(path, picture.getvalue())


def check_ending(path: Path | str) -> None:
    """Raise FileError unless a picture of that name can be written: before the work that the picture takes."""
    if Path(path).suffix.lower() not in _NO_DATES:
        raise FileError(
            Path(path), "pictures are written as PNG, PDF or SVG; give a name that ends in .png, .pdf or .svg"
        )
