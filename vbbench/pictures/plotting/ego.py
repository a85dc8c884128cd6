"""The ego view: the panorama strip or perspective image with its boxes, as the camera saw them.

Of a picture that closes on itself it shows the columns where people are. They count on beyond the seam: with a turn of
``period`` px, column ``period`` + 10 is column 10 again.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.plotting import style
from vbbench.pictures.replay import Replay

_STRIP_ASPECT = 0.22
"""Height of the strip that shows a whole panorama as a fraction of its width."""
_HIGHEST = 0.34  # of a strip's width, where a part of the panorama fills it
_HORIZON_POINTS = 361
_STEPS = (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)  # px from tick to tick of a panorama
_TICKS = 8  # at most


_MARGIN = 0.03  # of a turn, on both sides of the people
_LEAST = 0.4  # of a turn: nearer than that nothing is gained, and left and right are forgotten
_MOST = 0.85  # of a turn, from which on all of it is shown


def shown_columns(replay: Replay, frame: int) -> tuple[float, float]:
    """The columns in px that a frame shows: those of the window, of a panorama those where people are."""
    period = replay.camera.period
    if period is None:
        return replay.window[0], replay.window[2]
    boxes = rectangles(replay.sequence.observations[frame, replay.sequence.observed[frame]])
    return people_window(boxes[:, 0], boxes[:, 2], period)


def strip_aspect(replay: Replay, backdrop: Backdrop, columns: tuple[float, float]) -> float:
    """Height over width of a wide picture, of which these columns are shown."""
    period, shown = replay.camera.period, columns[1] - columns[0]
    if period is None or backdrop.is_recorded:
        return backdrop.height / backdrop.zoom / shown
    return min(_STRIP_ASPECT * period / shown, max(_STRIP_ASPECT, _HIGHEST))


def draw_ego(
    axes: Axes,
    replay: Replay,
    frame: int,
    colours: ScalarMappable,
    backdrop: Backdrop,
    columns: tuple[float, float],
) -> None:
    """Draw the boxes of one frame in these columns of the picture, over the picture itself if there is one.

    A box that crosses the ends of a whole panorama is drawn at both.
    """
    camera, picture = replay.camera, backdrop.recorded(frame)
    across = np.linspace(*columns, _HORIZON_POINTS)
    rows = camera.horizon(across if camera.period is None else np.mod(across, camera.period))
    if picture is not None:
        _draw_picture(axes, picture, backdrop, camera.period)
    _set_window(axes, replay, rows, backdrop, columns)
    effects = [] if picture is None else [withStroke(linewidth=2.6, foreground="white")]
    axes.plot(across, rows, color="#9a9a9a", linewidth=0.8, linestyle=(0, (6, 3)), zorder=1, gid="horizon")
    # Boxes have almost no fill, and small ones lie on top, so that no box hides another.
    seen, observations = replay.sequence.observed[frame], replay.sequence.observations[frame]
    near_to_far = np.flatnonzero(seen)[np.argsort(-observations[seen, 2])]
    hues = colours.to_rgba(replay.distances[frame])[:, :3]
    for box, order in zip(*_placed(rectangles(observations[near_to_far]), columns, camera.period), strict=True):
        track = near_to_far[order]
        look: dict[str, Any] = {"facecolor": (*hues[track], 0.10), "edgecolor": hues[track], "linewidth": 1.2}
        look["path_effects"] = effects
        patch = Rectangle(box[:2], box[2], box[3], gid=f"box-{replay.sequence.tracks[track]}", **look)
        axes.add_patch(patch).set_zorder(2.0 + order / 1000.0)
    _draw_labels(axes, replay, frame, near_to_far, effects)


def _draw_picture(axes: Axes, picture: Any, backdrop: Backdrop, period: float | None) -> None:
    """The camera's picture; of a panorama a second time, beyond its seam."""
    width, height = backdrop.width / backdrop.zoom, backdrop.height / backdrop.zoom
    left, top = backdrop.corner
    for turn in (0.0,) if period is None else (0.0, period):
        place = (left + turn, left + turn + width, top + height, top)
        axes.imshow(picture, extent=place, zorder=0.2, gid="picture" if turn == 0.0 else "picture-again")


def _placed(boxes: FloatArray, columns: tuple[float, float], period: float | None) -> tuple[FloatArray, IntArray]:
    """Boxes [N, 4] where they are drawn, and the index of each one's box."""
    if period is None or columns == (0.0, period):
        return with_seam_copies(boxes, period)
    left = unrolled(boxes[:, :1], columns[0], period)
    return np.hstack([left, boxes[:, 1:]]), np.arange(len(boxes))


def _set_window(
    axes: Axes, replay: Replay, horizon: FloatArray, backdrop: Backdrop, columns: tuple[float, float]
) -> None:
    """The picture; where it closes on itself, as many rows around the horizon as the strip has."""
    camera, shown = replay.camera, columns[1] - columns[0]
    _, top, _, bottom = replay.window
    if camera.period is not None:
        rows = strip_aspect(replay, backdrop, columns) * shown
        top, bottom = horizon.min() - 0.28 * rows, horizon.max() + 0.72 * rows
        _draw_bearings(axes, replay.bearings, columns, camera.period)
        step = next((step for step in _STEPS if shown / step <= _TICKS), _STEPS[-1])
        ticks = column_ticks(*columns, camera.period, step)
        whole = columns == (0.0, camera.period)
        axes.set_xticks(ticks, [f"{tick if whole else tick % camera.period:g}" for tick in ticks])
    if backdrop.is_recorded:
        top = backdrop.corner[1]
        bottom = top + backdrop.height / backdrop.zoom
    axes.set(xlim=columns, ylim=(bottom, top), xlabel="u (px)", ylabel="v (px)")
    axes.set_aspect("equal")
    axes.apply_aspect()  # labels are placed by the size that the axes have from here on


def _draw_bearings(axes: Axes, bearings: dict[str, float], columns: tuple[float, float], period: float) -> None:
    turns = [(column + turn, text) for text, column in bearings.items() for turn in (-period, 0.0, period)]
    ticks = sorted((column, text) for column, text in turns if columns[0] <= column <= columns[1])
    scale = axes.secondary_xaxis("top")
    scale.set_xticks([column for column, _ in ticks], [text for _, text in ticks])
    scale.tick_params(labelsize=style.TEXT_SIZE, length=3)
    for column, text in ticks:
        if text != "behind":
            axes.axvline(column, color=style.FAINT, linewidth=0.8, zorder=0.5)


def _draw_labels(axes: Axes, replay: Replay, frame: int, people: IntArray, effects: list[Any]) -> None:
    """One row of ids over the heads, each joined to its box; set upright where they would not fit in a line."""
    people = people[: style.MOST_LABELS]
    texts = [str(track) for track in replay.sequence.tracks[people]]
    widths = style.text_extent(texts, style.LABEL_SIZE)[:, 0] + 2.0
    left, right = axes.get_xlim()
    per_point = 72.0 / axes.figure.dpi * axes.transData.get_matrix()[0, 0]
    in_line = widths.sum() < 0.9 * (right - left) * per_point
    gap = (widths.max(initial=0.0) if in_line else 1.2 * style.LABEL_SIZE) / per_point
    u, v, lengths = replay.sequence.observations[frame, people].T
    tops, period = v - 0.5 * lengths, replay.camera.period
    above = np.min(np.append(tops, replay.camera.horizon(u)), initial=max(axes.get_ylim()))
    if period is not None and right - left < period:
        u = unrolled(u, left, period)
    places = style.spread(u, gap, left + 0.7 * gap, right - 0.7 * gap)
    low, high = sorted(axes.get_ylim())
    pad = 0.05 * (high - low)
    row = float(np.clip(above - pad, low + 2.0 * pad, high))
    leader = {"arrowstyle": "-", "color": "#b0b0b0", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0}
    look: dict[str, Any] = {"ha": "center", "va": "bottom", "arrowprops": leader, "annotation_clip": False}
    for text, place, column, top in zip(texts, places, u, tops, strict=True):
        label = axes.annotate(text, (column, top), (place, row), **look)
        rotation = 0 if in_line else 90
        label.set(fontsize=style.LABEL_SIZE, color=style.INK, rotation=rotation, zorder=4, gid=f"id-{text}")
        label.set_path_effects(effects)


def people_window(left: FloatArray, width: FloatArray, period: float) -> tuple[float, float]:
    """The narrowest columns (low, high) that hold all boxes with left sides [N] and widths [N] in px.

    All of the turn, (0, period), where that omits little. ``low`` is in [0, period), ``high`` may be beyond it.
    """
    if not len(left):
        return 0.0, period
    order = np.argsort(np.mod(left, period), kind="stable")
    begin = np.mod(left, period)[order]
    end = begin + width[order]
    reach = np.maximum(np.maximum.accumulate(end), end.max() - period)
    gaps = np.append(begin[1:], begin[0] + period) - reach
    widest = int(gaps.argmax())
    seen = period - float(gaps[widest]) + 2.0 * _MARGIN * period
    if seen > _MOST * period:
        return 0.0, period
    middle = float(reach[widest] + gaps[widest]) - _MARGIN * period + 0.5 * seen
    seen = max(seen, _LEAST * period)
    low = float(np.mod(middle - 0.5 * seen, period))
    low = 0.0 if low >= period else low
    return low, low + seen


def unrolled(columns: FloatArray, low: float, period: float) -> FloatArray:
    """The same columns [...] within the turn that begins at ``low``."""
    return low + np.mod(columns - low, period)


def column_ticks(low: float, high: float, period: float, step: float) -> list[float]:
    """Where a window has ticks: at every multiple of ``step`` px and at the seam, except where two would touch."""
    marks = np.append(np.arange(0.0, period, step), period)
    if period - marks[-2] < 0.5 * step:
        marks = np.delete(marks, -2)
    every = np.unique(np.concatenate([marks, marks + period]))
    return [float(mark) for mark in every if low - 1e-9 <= mark <= high + 1e-9]
