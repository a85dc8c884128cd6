"""The ego view: the panorama strip or perspective image with its boxes, as the camera saw them."""

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
from vbbench.pictures.plotting import style as labels
from vbbench.pictures.replay import Replay

STRIP_ASPECT = 0.22
"""Height of the panorama strip as a fraction of its width."""
_HORIZON_POINTS = 361


def draw_ego(axes: Axes, replay: Replay, frame: int, colours: ScalarMappable, backdrop: Backdrop) -> None:
    """Draw the boxes of one frame, over its picture if there is one.

    A box that crosses the seam of a panorama is drawn at both ends.
    """
    camera, picture = replay.camera, backdrop.recorded(frame)
    columns = np.linspace(0.0, camera.picture_size[0], _HORIZON_POINTS)
    rows = camera.horizon(columns)
    if picture is not None:
        place = (0.0, backdrop.width / backdrop.zoom, backdrop.height / backdrop.zoom, 0.0)
        axes.imshow(picture, extent=place, zorder=0.2, gid="picture")
    _set_window(axes, replay, rows, backdrop)
    effects = [] if picture is None else [withStroke(linewidth=2.6, foreground="white")]
    axes.plot(columns, rows, color="#9a9a9a", linewidth=0.8, linestyle=(0, (6, 3)), zorder=1, gid="horizon")
    # Boxes have almost no fill, and small ones lie on top, so that no box hides another.
    seen, observations = replay.sequence.observed[frame], replay.sequence.observations[frame]
    near_to_far = np.flatnonzero(seen)[np.argsort(-observations[seen, 2])]
    hues = colours.to_rgba(replay.distances[frame])[:, :3]
    for box, order in zip(*with_seam_copies(rectangles(observations[near_to_far]), camera.period), strict=True):
        track = near_to_far[order]
        look: dict[str, Any] = {"facecolor": (*hues[track], 0.10), "edgecolor": hues[track], "linewidth": 1.2}
        look["path_effects"] = effects
        patch = Rectangle(box[:2], box[2], box[3], gid=f"box-{replay.sequence.tracks[track]}", **look)
        axes.add_patch(patch).set_zorder(2.0 + order / 1000.0)
    _draw_labels(axes, replay, frame, near_to_far, effects)


def _set_window(axes: Axes, replay: Replay, horizon: FloatArray, backdrop: Backdrop) -> None:
    """The picture; where it closes on itself, as many rows around the horizon as the strip has."""
    camera = replay.camera
    width, height = camera.picture_size
    top, bottom = 0.0, float(height)
    if camera.period is not None:
        top, bottom = horizon.min() - 0.28 * STRIP_ASPECT * width, horizon.max() + 0.72 * STRIP_ASPECT * width
        _draw_bearings(axes, replay.bearings, camera.period)
    if backdrop.is_recorded:
        top, bottom = 0.0, backdrop.height / backdrop.zoom
    axes.set(xlim=(0, width), ylim=(bottom, top), xlabel="u (px)", ylabel="v (px)")
    axes.set_aspect("equal")
    axes.apply_aspect()  # labels are placed by the size that the axes have from here on


def _draw_bearings(axes: Axes, bearings: dict[str, float], period: float) -> None:
    turns = [(column + turn, text) for text, column in bearings.items() for turn in (-period, 0.0, period)]
    ticks = sorted((column, text) for column, text in turns if 0.0 <= column <= period)
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
    widths = labels.text_extent(texts, style.LABEL_SIZE)[:, 0] + 2.0
    width = axes.get_xlim()[1]
    per_point = 72.0 / axes.figure.dpi * axes.transData.get_matrix()[0, 0]
    in_line = widths.sum() < 0.9 * width * per_point
    gap = (widths.max(initial=0.0) if in_line else 1.2 * style.LABEL_SIZE) / per_point
    u, v, lengths = replay.sequence.observations[frame, people].T
    tops = v - 0.5 * lengths
    places = labels.spread(u, gap, 0.7 * gap, width - 0.7 * gap)
    low, high = sorted(axes.get_ylim())
    pad = 0.05 * (high - low)
    above = np.min(np.append(tops, replay.camera.horizon(u)), initial=high) - pad
    row = float(np.clip(above, low + 2.0 * pad, high))
    leader = {"arrowstyle": "-", "color": "#b0b0b0", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0}
    look: dict[str, Any] = {"ha": "center", "va": "bottom", "arrowprops": leader, "annotation_clip": False}
    for text, place, column, top in zip(texts, places, u, tops, strict=True):
        label = axes.annotate(text, (column, top), (place, row), **look)
        rotation = 0 if in_line else 90
        label.set(fontsize=style.LABEL_SIZE, color=style.INK, rotation=rotation, zorder=4, gid=f"id-{text}")
        label.set_path_effects(effects)
