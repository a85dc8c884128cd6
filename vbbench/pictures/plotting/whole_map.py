"""A whole map on one picture: the camera's path, everybody's path, 2σ ellipses and a scale bar."""

from collections.abc import Sequence as Several
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, withStroke
from numpy.typing import NDArray

from vbbench.estimate import Estimate
from vbbench.geometry import BoolArray, FloatArray, runs_of_true
from vbbench.pictures.colours import PEOPLE_ON_LIGHT
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import draw_lines, draw_points, lay_out

_CAMERA = style.ESTIMATE
_SIGMAS = 2.0
_AREA, _LONGEST, _LEAST = 46.0, 11.0, (6.8, 2.6)
"""Square inches of the map, its longest side in inches, and its least width and height."""
_LEFT, _BOTTOM, _LINE, _HANDLE = 0.25, 0.36, 0.175, 40.0
"""Inches left of and below the map and from line to line, and points that a mark takes in the legend."""
_DOTS: Any = (0, (0.6, 1.2))
_MARGIN, _LEAST_MARGIN = 0.06, 1.0
"""Around what is drawn, as a share of it, and in m."""
_OUTLIERS = 1.0
"""Percent of people's places on each side that the map need not hold."""
_ROUND = (1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600)
"""Seconds that may lie between the marks on the camera's path."""
_MOST_MARKS = 10
_CROWD = 60
"""So many people are drawn fainter."""
_FILLED, _SHOWN = 0.25, 0.5
"""Ellipses up to these shares of the map are filled, and drawn at all."""
_UNSEEN = 2.0
"""Seconds without a box that a line bridges."""
_BAR = 0.2
"""Largest share of the map's width that the scale bar takes."""


def plot_map(
    answer: Estimate, observed: BoolArray, dt: float, title: str, facts: Several[str], lost: BoolArray
) -> Figure:
    """Draw a map, x to the right.

    Parameters
    ----------
    answer : poses and positions, with or without covariances.
    observed : [T, K] who has a box when.
    dt : seconds per frame.
    title : name of the recording.
    facts : lines below it.
    lost : [T] frames in which the path is not usable; it is dotted there.
    """
    places = np.where(observed[..., None], answer.positions, np.nan)
    low, high = _window(answer.poses[:, :2], places)
    size = _size(high - low)
    metres = (high - low).max() / size.max()  # an inch
    wider = 0.5 * metres * np.maximum(np.array(_LEAST) - size, 0.0)
    low, high, (width, height) = low - wider, high + wider, np.maximum(size, _LEAST)
    lines = [line for text in facts for line in style.wrap(text, 72.0 * width, style.text_width)]
    entries = _entries(answer, lost)
    rows = 1 if sum(style.text_width(label) + _HANDLE for label, _ in entries) < 72.0 * width else 2
    above = 0.5 + _LINE * (len(lines) + rows)
    figure = lay_out((width + 2.0 * _LEFT, height + _BOTTOM + above), {"map": (_LEFT, _BOTTOM, width, height)})
    (axes,) = figure.axes
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xticks=[], yticks=[])
    axes.set_aspect("equal")
    for spine in axes.spines.values():
        spine.set_color(style.FIELD_EDGE)
    _draw_grid(axes, low, high)
    _draw_people(axes, answer, places, dt)
    _draw_camera(axes, answer, dt, lost)
    _draw_words(figure, title, lines)
    _draw_legend(figure, entries, rows)
    return figure


def _window(path: FloatArray, places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The ground (low, high) that holds the path and nearly all places [T, K, 2]."""
    known = places[np.isfinite(places[..., 0])]
    ends = np.percentile(known, [_OUTLIERS, 100.0 - _OUTLIERS], axis=0) if len(known) else path[:1]
    points = np.vstack([path[np.isfinite(path[:, 0])], ends])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = np.maximum(_MARGIN * (high - low).max(), _LEAST_MARGIN)
    return low - margin, high + margin


def _size(span: FloatArray) -> FloatArray:
    """Inches of a map of so many metres."""
    return np.asarray(span * min(np.sqrt(_AREA / span.prod()), _LONGEST / span.max()))


def _draw_grid(axes: Axes, low: FloatArray, high: FloatArray) -> None:
    """Squares as long as the scale bar, which is below the map."""
    step = _round_length(_BAR * float(high[0] - low[0]))
    columns, rows = (step * np.arange(np.ceil(low[n] / step), np.floor(high[n] / step) + 1) for n in (0, 1))
    lines = [[(x, low[1]), (x, high[1])] for x in columns] + [[(low[0], y), (high[0], y)] for y in rows]
    draw_lines(axes, np.array(lines).reshape(-1, 2, 2), style.FAINT, 0.6, 0.5)
    below = float(low[1]) - 0.16 * _inch(axes)
    ends = [float(low[0]), float(low[0]) + step]
    look: dict[str, Any] = {"color": style.INK, "clip_on": False}
    axes.plot(ends, [below, below], linewidth=2.2, solid_capstyle="butt", gid="scale-bar", **look)
    axes.plot(ends, [below, below], linestyle="none", marker="|", markersize=7, markeredgewidth=1.2, **look)
    axes.text(ends[1] + 0.08 * _inch(axes), below, f"{step:g} m (grid)", va="center", size=style.TEXT_SIZE, **look)


def _round_length(most: float) -> float:
    """The largest of 1, 2, 5, 10, … m, or of parts of a metre, that is no longer."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(share * power for share in (1.0, 2.0, 5.0) if share * power <= most))


def _draw_people(axes: Axes, answer: Estimate, places: FloatArray, dt: float) -> None:
    """Everybody's path, a point at its end, and the ellipse there."""
    known = np.isfinite(places[..., 0])
    columns = np.flatnonzero(known.any(axis=0))
    if not len(columns):
        return
    last = len(known) - 1 - known[::-1, columns].argmax(axis=0)
    colours = np.array([to_rgba(PEOPLE_ON_LIGHT[n % len(PEOPLE_ON_LIGHT)]) for n in range(len(columns))])
    frames = [np.flatnonzero(known[:, column]) for column in columns]
    parts = [np.split(seen, np.flatnonzero(np.diff(seen) * dt > _UNSEEN) + 1) for seen in frames]
    paths = [places[part, column] for column, own in zip(columns, parts, strict=True) for part in own]
    drawn = draw_lines(axes, paths, np.repeat(colours, [len(own) for own in parts], axis=0), 0.9, 2.0)
    drawn.set_gid("people")
    drawn.set_alpha(0.6 if len(columns) < _CROWD else 0.4)
    ends = places[last, columns]
    draw_points(axes, ends, "places", s=11.0 if len(columns) < _CROWD else 6.0, c=colours, linewidths=0, zorder=3.0)
    if answer.position_covariances is not None:
        _draw_ellipses(axes, ends, answer.position_covariances[last, columns], colours, "people-ellipses")


def _draw_ellipses(axes: Axes, places: FloatArray, covariances: FloatArray, colours: FloatArray, gid: str) -> None:
    """The 2σ ellipses of places [N, 2] in m, filled if small; none that would cover the map, and none of NaN."""
    known = np.flatnonzero(np.isfinite(covariances).all(axis=(1, 2)) & np.isfinite(places[:, 0]))
    values, vectors = np.linalg.eigh(covariances[known])
    size = 2.0 * _SIGMAS * np.sqrt(np.maximum(values, 0.0))
    angles = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))
    span = min(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()))
    shown = size[:, 1] < _SHOWN * span
    fill, edge = colours[known][shown], colours[known][shown]
    crowd = len(places) >= _CROWD
    fill[:, 3] = np.where(size[shown, 1] < _FILLED * span, 0.04 if crowd else 0.07, 0.0)
    edge[:, 3] = 0.25 if crowd else 0.4
    look: dict[str, Any] = {"facecolors": fill, "edgecolors": edge, "linewidths": 0.6, "zorder": 1.5, "gid": gid}
    (width, height), angles = size[shown, ::-1].T, angles[shown]
    look |= {"units": "xy", "offsets": places[known][shown], "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(width, height, angles, **look), autolim=False)


def _draw_camera(axes: Axes, answer: Estimate, dt: float, lost: BoolArray) -> None:
    """The path, dotted where it is not usable, with start, times, ellipses, and the view at the end."""
    path = answer.poses[:, :2]
    halo = [withStroke(linewidth=4.0, foreground="white"), Normal()]
    for mask, dashes, gid in ((~lost, "-", "path"), (lost, _DOTS, "lost-path")):
        runs = [path[max(begin - 1, 0) : end] for begin, end in runs_of_true(mask)]
        if runs:
            drawn = draw_lines(axes, runs, _CAMERA, 2.2, 5.0, dashes)
            drawn.set_path_effects(halo)
            drawn.set_gid(gid)
    marks = _marks(len(path), dt)
    colours = np.tile(to_rgba(_CAMERA), (len(marks), 1))
    if answer.pose_covariances is not None:
        _draw_ellipses(axes, path[marks], answer.pose_covariances[marks, :2, :2], colours, "camera-ellipses")
    dots: dict[str, Any] = {"c": "white", "edgecolors": _CAMERA, "linewidths": 1.2}
    draw_points(axes, path[marks[1:]], "times", s=16.0, zorder=6.0, **dots)
    draw_points(axes, path[:1], "start", s=42.0, zorder=6.2, **dots)
    known = np.flatnonzero(np.isfinite(answer.poses).all(axis=1))
    if len(known):
        _draw_end(axes, answer.poses[known[-1]])
    _label_times(axes, path, marks, dt)


def _draw_end(axes: Axes, pose: FloatArray) -> None:
    """A place, and an arrow of .3 inches where the camera looks."""
    ahead = pose[:2] + 0.3 * _inch(axes) * np.array([np.cos(pose[2]), np.sin(pose[2])])
    head = {"arrowstyle": "-|>,head_width=0.28,head_length=0.5", "mutation_scale": 11, "shrinkA": 0, "shrinkB": 0}
    look: dict[str, Any] = {"arrowprops": {**head, "color": _CAMERA, "linewidth": 2.0}, "zorder": 6.3}
    axes.annotate("", xy=tuple(ahead), xytext=tuple(pose[:2]), **look)
    draw_points(axes, pose[None, :2], "end", s=50.0, c=_CAMERA, edgecolors="white", linewidths=1.0, zorder=6.5)


def _inch(axes: Axes) -> float:
    """Metres of the map in an inch of the picture."""
    return float(axes.figure.dpi * np.ptp(axes.get_xlim()) / axes.get_window_extent().width)


def _marks(frames: int, dt: float) -> NDArray[np.int64]:
    """Frames at which the path is marked: the first, and then every so many seconds; the last has its own mark."""
    step = next((seconds for seconds in _ROUND if frames * dt / seconds <= _MOST_MARKS), frames * dt / _MOST_MARKS)
    return np.unique(np.round(np.arange(0.0, frames - 0.5, step / dt)).astype(np.int64)).clip(max=frames - 1)


def _label_times(axes: Axes, path: FloatArray, marks: NDArray[np.int64], dt: float) -> None:
    """Seconds next to the marks, where there is room."""
    texts = [f"{frame * dt:.0f} s" for frame in marks]
    points = axes.transData.transform(path[marks]) * 72.0 / axes.figure.dpi
    dense, frames = np.linspace(0.0, len(path) - 1.0, 500), np.arange(len(path))
    line = np.column_stack([np.interp(dense, frames, along) for along in path.T])
    along = axes.transData.transform(line) * 72.0 / axes.figure.dpi
    offsets = style.free_offsets(points, style.text_extent(texts, style.TEXT_SIZE), along, clearance=4.0)
    halo = [withStroke(linewidth=2.5, foreground="white")]
    look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": style.TEXT_SIZE, "color": style.INK}
    for text, place, (right, up) in zip(texts, path[marks], offsets, strict=True):
        if np.isfinite(right):
            axes.annotate(text, place, (right, up), textcoords="offset points", path_effects=halo, zorder=7, **look)


def _draw_words(figure: Figure, title: str, lines: Several[str]) -> None:
    left, height = _LEFT / figure.get_figwidth(), figure.get_figheight()
    figure.text(left, 1.0 - 0.3 / height, title, fontsize=12.5, weight="bold", color=style.INK)
    for n, line in enumerate(lines):
        figure.text(left, 1.0 - (0.5 + _LINE * n) / height, line, fontsize=style.TEXT_SIZE, color=style.INK)


def _entries(answer: Estimate, lost: BoolArray) -> list[tuple[str, dict[str, Any]]]:
    """Label and look of each mark that is there."""
    ring: dict[str, Any] = {"marker": "o", "linestyle": "none", "markeredgecolor": _CAMERA, "markerfacecolor": "white"}
    entries: list[tuple[str, dict[str, Any]]] = [("camera", {"color": _CAMERA, "linewidth": 2.2})]
    if lost.any():
        entries += [("not usable", {"color": _CAMERA, "linewidth": 2.2, "linestyle": _DOTS})]
    entries += [
        ("start", {**ring, "markersize": 6.5}),
        ("end", {**ring, "markersize": 7, "markerfacecolor": _CAMERA}),
        ("people, to their last box", {"color": style.TRUTH, "linewidth": 1.0, "marker": "o", "markersize": 3}),
    ]
    for reported, colour, label in (
        (answer.pose_covariances, _CAMERA, "2σ of the camera, up to half the map"),
        (answer.position_covariances, style.TRUTH, "2σ of people there, likewise"),
    ):
        disc = {"markersize": 9, "markeredgewidth": 0.8, "markerfacecolor": to_rgba(colour, 0.12)}
        entries += [(label, {**ring, **disc, "markeredgecolor": colour})] if reported is not None else []
    return entries


def _draw_legend(figure: Figure, entries: Several[tuple[str, dict[str, Any]]], rows: int) -> None:
    """Between the words and the map."""
    handles = [Line2D([], [], label=label, **look) for label, look in entries]
    box = figure.axes[0].get_position()
    place = (box.x0, box.y1 + 0.05 / figure.get_figheight())
    tight: dict[str, Any] = {"borderpad": 0.0, "borderaxespad": 0.0, "columnspacing": 1.5, "handletextpad": 0.6}
    look: dict[str, Any] = {"fontsize": style.TEXT_SIZE, "labelcolor": style.INK, "frameon": False, **tight}
    figure.legend(handles=handles, loc="lower left", bbox_to_anchor=place, ncols=-(-len(handles) // rows), **look)
