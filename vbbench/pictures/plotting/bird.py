"""The bird's-eye view: observer, people, truth, estimate and what was given, in metres."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.patches import Wedge
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator, MultipleLocator

from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import draw_lines, draw_points
from vbbench.pictures.replay import Replay

_MARGIN = 1.0  # m around everything drawn
_ARROW = 0.11  # of the height of the map
_OUTLIER = 2.0  # m beyond the truth that an estimate may widen the view
_FEW_TICKS = 700  # px of a map's width, up to which it has half as many ticks
_REACH = 30.0  # m from the observer; what is farther away may be outside


def draw_bird(axes: Axes, replay: Replay, frame: int, colours: ScalarMappable) -> None:
    """Draw the map of one frame; ``colours`` maps distance in m to the colour a person has in both views."""
    _set_window(axes, replay, frame)
    _draw_field_of_view(axes, replay, frame)
    _draw_tracks(axes, replay, frame, colours)
    _draw_given(axes, replay, frame)
    _draw_people(axes, replay, frame, colours)
    _draw_observer(axes, replay, frame)
    _draw_labels(axes, replay, frame)


def _set_window(axes: Axes, replay: Replay, frame: int) -> None:
    """The people seen now with their last steps, and all that is known of the observer."""
    seen, recent = replay.sequence.observed[frame], slice(max(0, frame + 1 - style.TAIL_FRAMES), frame + 1)
    known = replay.known
    here = replay.viewpoints[frame, :2]
    near = np.nan_to_num(here - _REACH, nan=-np.inf), np.nan_to_num(here + _REACH, nan=np.inf)
    paths = np.vstack([replay.given.poses[:, :2], replay.viewpoints[:, :2]]).clip(*near)
    real = np.vstack([known.positions[recent, seen].reshape(-1, 2), paths])
    if replay.places_known:
        near = np.nanmin(real, axis=0) - _OUTLIER, np.nanmax(real, axis=0) + _OUTLIER
    points = np.vstack([real, replay.estimated[recent, seen].reshape(-1, 2).clip(*near)])
    low, high = np.nanmin(points, axis=0) - _MARGIN, np.nanmax(points, axis=0) + _MARGIN
    fill_map(axes, low, high)


def fill_map(axes: Axes, low: FloatArray, high: FloatArray) -> None:
    """Show the ground from ``low`` to ``high`` (x, y) in m, and as much more as the shape of the axes takes.

    The window fills the axes at equal scale, so that places in points are known before anything is drawn.
    """
    spans = style.fit(axes, low, high)
    axes.set(xlabel="x (m)", ylabel="y (m)")
    most = 12 if axes.get_window_extent().width > _FEW_TICKS else 6
    step = float(np.diff(MaxNLocator(most, steps=[1, 2, 5, 10]).tick_values(0.0, spans.max()))[0])
    axes.yaxis.labelpad = 1.0
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(step))
    style.draw_grid(axes)


def _draw_field_of_view(axes: Axes, replay: Replay, frame: int) -> None:
    camera, pose = replay.camera, replay.viewpoints[frame]
    if camera.view is None or np.isnan(pose).any():
        return
    left, right = np.degrees(camera.view)
    yaw, reach = np.degrees(pose[2]), float(np.nanmax(replay.distances[frame], initial=5.0)) + _MARGIN
    look: dict[str, Any] = {"facecolor": style.FIELD, "edgecolor": style.FIELD_EDGE, "zorder": 0.5}
    wedge = Wedge((pose[0], pose[1]), reach, yaw - right, yaw - left, **look)
    axes.add_patch(wedge).set_gid("field-of-view")


def _draw_tracks(axes: Axes, replay: Replay, frame: int, colours: ScalarMappable) -> None:
    now, seen = frame + 1, replay.sequence.observed[frame]
    recent = slice(max(0, now - style.TAIL_FRAMES), now)
    if replay.truth is not None:
        paths = np.swapaxes(replay.truth.positions, 0, 1)
        draw_lines(axes, paths, style.TRUTH_FAINT, 0.7, 2.0)
        draw_lines(axes, paths[seen, recent], style.TRUTH_TAIL, 0.9, 2.1)
        axes.plot(*replay.truth.poses[:, :2].T, color=style.TRUTH, linewidth=1.4, zorder=2.5)
    if replay.answer is not None:
        hues = colours.to_rgba(replay.distances[frame, seen])
        draw_lines(axes, np.swapaxes(replay.estimated, 0, 1)[seen, recent], hues, 1.0, 2.6)
        axes.plot(*replay.answer.estimate.poses[:now, :2].T, color=style.ESTIMATE, linewidth=1.4, zorder=2.7)


def _draw_given(axes: Axes, replay: Replay, frame: int) -> None:
    given = replay.given
    points = np.vstack([given.positions[:, replay.sequence.observed[frame]].reshape(-1, 2), given.poses[:, :2]])
    look = {"s": 9, "marker": "D", "facecolors": "none", "edgecolors": style.GIVEN, "linewidths": 0.6, "zorder": 2.4}
    draw_points(axes, points, "given", **look)


def _draw_people(axes: Axes, replay: Replay, frame: int, colours: ScalarMappable) -> None:
    seen, known = replay.sequence.observed[frame], replay.known.positions[frame]
    hues = colours.to_rgba(replay.distances[frame, seen])
    draw_points(axes, known[~seen], "unseen", s=12, c="white", edgecolors=style.UNSEEN, linewidths=0.8, zorder=3)
    if replay.answer is None:
        draw_points(axes, known[seen], "truth", s=26, c=hues, edgecolors=style.TRUTH, linewidths=0.6, zorder=4)
        return
    draw_points(axes, known[seen], "truth", s=34, c="white", edgecolors=style.TRUTH, linewidths=1.0, zorder=3.5)
    guessed = replay.estimated[frame, seen]
    draw_lines(axes, np.stack([known[seen], guessed], axis=1), style.INK, 1.1, 3.8).set_gid("errors")
    draw_points(axes, guessed, "estimate", s=16, c=hues, linewidths=0, zorder=4)


def _draw_observer(axes: Axes, replay: Replay, frame: int) -> None:
    draw_pose(axes, (replay.known.poses if replay.answer else replay.viewpoints)[frame], style.TRUTH, "observer-truth")
    if replay.answer is not None:
        pose = replay.answer.estimate.poses[frame]
        ends = np.stack([replay.known.poses[frame][:2], pose[:2]])
        axes.plot(*ends.T, color=style.INK, linewidth=1.1, zorder=5)
        draw_pose(axes, pose, style.ESTIMATE, "observer-estimate")


def draw_pose(axes: Axes, pose: FloatArray, colour: str, gid: str) -> None:
    """Mark a place, and by an arrow where the camera looks."""
    if np.isnan(pose).any():
        return
    x, y = float(pose[0]), float(pose[1])
    ahead = _arrow(axes, pose)
    head = {"arrowstyle": "-|>,head_width=0.28,head_length=0.5", "mutation_scale": 14, "shrinkA": 0, "shrinkB": 0}
    arrow = {**head, "color": colour, "linewidth": 2.0}
    axes.annotate("", xy=(x + ahead[0], y + ahead[1]), xytext=(x, y), arrowprops=arrow, zorder=6)
    axes.plot(x, y, marker="o", markersize=7.5, color=colour, markeredgecolor="white", zorder=6.5, gid=gid)


def _arrow(axes: Axes, pose: FloatArray) -> FloatArray:
    """Viewing direction, long enough to see."""
    return np.asarray(_ARROW * np.ptp(axes.get_ylim()) * np.array([np.cos(pose[2]), np.sin(pose[2])]))


def _draw_labels(axes: Axes, replay: Replay, frame: int) -> None:
    known, estimated = replay.known.positions[frame], replay.estimated[frame]
    places = np.where(np.isnan(estimated), known, estimated)
    inside = [axes.viewLim.contains(x, y) for x, y in places]
    shown = np.flatnonzero(replay.sequence.observed[frame] & np.array(inside, bool))
    order = shown[np.argsort(replay.distances[frame, shown])][: style.MOST_LABELS]
    texts = [str(track) for track in replay.sequence.tracks[order]]
    pose = (replay.viewpoints if replay.answer is None else replay.answer.estimate.poses)[frame]
    along_arrow = pose[:2] + np.linspace(0.0, 1.0, 6)[:, None] * _arrow(axes, pose)
    offsets = style.free_offsets(
        _in_points(axes, places[order]),
        style.text_extent(texts, style.LABEL_SIZE),
        _in_points(axes, np.vstack([places[order], known[order], along_arrow])),
        clearance=3.5,
    )
    halo = [withStroke(linewidth=1.6, foreground="white")]
    look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": style.LABEL_SIZE, "path_effects": halo}
    for text, (x, y), (right, up) in zip(texts, places[order], offsets, strict=True):
        if np.isfinite(right):
            axes.annotate(text, (x, y), (right, up), textcoords="offset points", gid=f"id-{text}", zorder=7, **look)


def _in_points(axes: Axes, places: FloatArray) -> FloatArray:
    return np.asarray(axes.transData.transform(places)) * 72.0 / axes.figure.dpi
