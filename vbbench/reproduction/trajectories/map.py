"""The map of one example: true and estimated ways of people and observer, a scale bar, and nothing else."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.plotting import style
from vbbench.pictures.replay import Replay

MOST_PEOPLE = 20
"""In larger crowds only so many are drawn: those who come nearest to the observer."""
_MARGIN = 0.06
"""Free space on each side of a map, in parts of it."""
_BARS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
"""Lengths of scale bars in m."""
_BAR_SPACE = (0.4, 0.2)
"""Of a map's width and height."""
_PERSON, _TRUE_PERSON = style.distance_colours()(0.35), "#c9c9c9"


def draw_map(axes: Axes, replay: Replay) -> None:
    """Draw the sequence, turned so that the observer gets from left to right."""
    turn = _turn(replay.viewpoints)
    shown = _nearest(replay)
    truth = np.where(replay.sequence.observed[..., None], replay.known.positions, np.nan)
    truth, estimated = _turned(truth[:, shown], turn), _turned(replay.estimated[:, shown], turn)
    path = _turned(replay.viewpoints[:, :2], turn)
    thin = float(np.clip(np.sqrt(15.0 / max(len(shown), 1)), 0.5, 1.0))
    _draw_ways(axes, truth, _TRUE_PERSON, 3.6 * thin, 1.0)
    _draw_ways(axes, estimated, _PERSON, 1.1 * thin, 2.0)
    x, y = _ends(estimated)
    axes.scatter(x, y, s=10.0 * thin, color=_PERSON, linewidths=0.0, zorder=2.5)
    axes.plot(*_turned(replay.known.poses[:, :2], turn).T, color=style.TRUTH, linewidth=3.4, zorder=3.0)
    if replay.answer is not None:
        found = _turned(replay.answer.estimate.poses[:, :2], turn)
        axes.plot(*found.T, color=style.ESTIMATE, linewidth=1.5, zorder=4.0)
        end = _ends(found[:, None])
        axes.plot(*end, marker="o", markersize=5.5, color=style.ESTIMATE, markeredgecolor="white", zorder=5.0)
    places = np.vstack([truth.reshape(-1, 2), path])
    _set_window(axes, places)
    _draw_bar(axes, np.vstack([places, estimated.reshape(-1, 2)]))


def map_legend(answered: str) -> list[Line2D]:
    """What every line means; ``answered`` says by whom and under which protocol."""
    person: dict[str, Any] = {"color": _PERSON, "linewidth": 1.0, "marker": "o", "markersize": 3.0}
    return [
        Line2D([], [], color=style.TRUTH, linewidth=3.4, label="observer, truth"),
        Line2D([], [], color=style.ESTIMATE, linewidth=1.5, label=f"observer, estimate of {answered}"),
        Line2D([], [], color=_TRUE_PERSON, linewidth=3.0, label="people, truth"),
        Line2D([], [], label="people, estimate; a dot where each is last", **person),
    ]


def _turn(poses: FloatArray) -> float:
    """The angle in rad by which a map is turned so that ``poses`` [T, 3] get from left to right."""
    known = poses[np.isfinite(poses[:, 0]), :2]
    way = known[-1] - known[0] if len(known) else np.zeros(2)
    return -float(np.arctan2(way[1], way[0]))


def _turned(places: FloatArray, turn: float) -> FloatArray:
    """Places [..., 2] turned counter-clockwise."""
    cos, sin = np.cos(turn), np.sin(turn)
    return np.asarray(places @ np.array([[cos, sin], [-sin, cos]]))


def _nearest(replay: Replay) -> IntArray:
    """Columns of the people who are drawn."""
    distance = np.where(np.isfinite(replay.distances), replay.distances, np.inf).min(axis=0)
    order = np.argsort(distance, kind="stable")
    return order[: min(MOST_PEOPLE, int(np.isfinite(distance).sum()))]


def _draw_ways(axes: Axes, places: FloatArray, colour: Any, width: float, zorder: float) -> None:
    """Lines through places [T, K, 2], interrupted where they are not known."""
    ways = LineCollection(list(np.swapaxes(places, 0, 1)), colors=[colour], linewidths=width, zorder=zorder)
    ways.set_capstyle("round")
    axes.add_collection(ways, autolim=False)


def _ends(places: FloatArray) -> FloatArray:
    """[2, N] the last known place of everybody who has any in ``places`` [T, K, 2]."""
    known = np.isfinite(places[..., 0])
    last = len(known) - 1 - known[::-1].argmax(axis=0)
    ever = np.flatnonzero(known.any(axis=0))
    return np.asarray(places[last[ever], ever].T)


def _set_window(axes: Axes, places: FloatArray) -> None:
    """Show all known ``places`` [N, 2] at equal scale; estimates may leave the map."""
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    box = axes.get_window_extent()
    aspect = box.width / box.height
    half = max((high - low)[0] / aspect, (high - low)[1], 2.0) * (0.5 + _MARGIN) * np.array([aspect, 1.0])
    low, high = (low + high) / 2.0 - half, (low + high) / 2.0 + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xticks=[], yticks=[])
    axes.set_aspect("equal")
    for spine in axes.spines.values():
        spine.set_color(style.TRUTH_FAINT)


def _draw_bar(axes: Axes, places: FloatArray) -> None:
    """A scale bar, in the corner where fewest of the ``places`` [N, 2] are."""
    parts = axes.transLimits.transform(places[np.isfinite(places[:, 0])])
    corners = [(x, y) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    right, top = min(corners, key=lambda corner: int(np.all(np.abs(parts - corner) < _BAR_SPACE, axis=1).sum()))
    width = float(np.ptp(axes.get_xlim()))
    length = max((one for one in _BARS if one <= 0.3 * width), default=_BARS[0]) / width
    left, height = (0.96 - length if right else 0.04), (0.88 if top else 0.06)
    place: dict[str, Any] = {"transform": axes.transAxes, "zorder": 6.0}
    axes.plot([left, left + length], [height, height], color=style.INK, linewidth=2.0, solid_capstyle="butt", **place)
    halo = [withStroke(linewidth=2.0, foreground="white")]
    look: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": style.LABEL_SIZE, "path_effects": halo}
    axes.text(left + length / 2.0, height + 0.015, f"{length * width:g} m", color=style.INK, **look, **place)
