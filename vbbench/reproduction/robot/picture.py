"""One recording as a picture: maps of the camera's way and people, drift over distance, and boxes at five instants."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator, NullFormatter

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.camera import Camera
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.reproduction.robot.measuring import Course, Example
from vbbench.reproduction.robot.study import RobotStudy

INSTANTS = 5
_HUES = (style.ESTIMATE, style.GIVEN, "#009e73", "#e69f00", "#56b4e9")
"""Of solvers in their order; the reference is purple (Okabe and Ito)."""
_REFERENCE = "#a4508b"

MOST_MAPS = 3
"""Solvers that have a map: the first of the study."""
MOST_STEPS = 500
"""Steps of people on a map; with more than that nobody finds anything."""
_LEFT, _MAP, _GAP, _DRIFT, _HEAD, _BETWEEN = 0.55, 4.0, 0.2, 3.0, 1.1, 0.12  # inches


def plot_course(course: Course, study: RobotStudy) -> Figure:
    """Draw the sequence in which the camera went farthest, and the drift over all sequences."""
    example = course.example
    camera, frames = example.dataset.camera(example.sequence), instants(example)
    hues, shown = _hues(course), list(example.people)[:MOST_MAPS]
    drawn = lay_out(*_layout(camera, shown))
    parts = {axes.get_label(): axes for axes in drawn.axes}
    around = steps_around(example, int(frames[len(frames) // 2]))
    for title in shown:
        _draw_map(parts[title], example, title, hues, frames, around)
        parts[title].tick_params(labelleft=title == shown[0])
    if course.recording.reference in example.ways:
        for title in shown:
            _draw_reference(parts[title], example, example.ways[course.recording.reference])
    _draw_drift(parts["drift"], course, study, hues)
    backdrop = Backdrop(example.dataset, example.sequence, frames.tolist())
    for number, frame in enumerate(frames.tolist(), 1):
        _draw_boxes(parts[f"instant {number}"], example, number, frame, backdrop)
    _name_directions(parts[f"instant {INSTANTS}"], camera)
    dt = example.dataset.info.dt
    facts = (
        f"maps: {study.protocols[0]}, sequence {example.sequence.index}, {course.metres.max():.0f} m in "
        f"{example.sequence.frames * dt:.0f} s; people for {(around.stop - around.start) * dt:.0f} s about place 3, "
        "grey where they truly were.  Below: the boxes that the camera sees at the numbered places, dark = near"
    )
    draw_heading(drawn, _LEFT, course.recording.title, facts, parts["drift"])
    return drawn


def instants(example: Example) -> IntArray:
    """[5] frames in which people are seen, evenly over the sequence."""
    seen = np.flatnonzero(example.sequence.observed.any(axis=1))
    chosen: IntArray = seen[np.rint(np.linspace(0.06, 0.94, INSTANTS) * (len(seen) - 1)).astype(int)]
    return chosen


def steps_around(example: Example, frame: int) -> slice:
    """The frames about a frame in which people make `MOST_STEPS` steps, or all of them."""
    people = example.sequence.observed.sum(axis=1)
    reach = 1
    while people[max(frame - reach, 0) : frame + reach + 1].sum() < MOST_STEPS and reach < len(people):
        reach += 1
    return slice(max(frame - reach, 0), min(frame + reach + 1, len(people)))


def _hues(course: Course) -> dict[str, str]:
    titles = list(dict.fromkeys(row.title for row in course.rows if row.protocol))
    hues = {title: _HUES[n % len(_HUES)] for n, title in enumerate(titles)}
    return {**hues, course.recording.reference: _REFERENCE}


def _layout(camera: Camera, shown: list[str]) -> tuple[tuple[float, float], Rectangles]:
    """Maps and drift in a row; below them boxes, in a row or, of pictures that see all around, one over the other."""
    width = _LEFT + len(shown) * (_MAP + _GAP) + 0.4 + _DRIFT + 0.3
    wide, (columns, rows) = width - _LEFT - 0.3, camera.picture_size
    stacked = camera.period is not None
    own = wide if stacked else (wide - (INSTANTS - 1) * _BETWEEN) / INSTANTS
    tall = own * rows / columns
    right, down = (0.0, tall + _BETWEEN) if stacked else (own + _BETWEEN, 0.0)
    panels: Rectangles = {
        f"instant {n + 1}": (_LEFT + n * right, 0.4 + (INSTANTS - 1 - n) * down, own, tall) for n in range(INSTANTS)
    }
    top = 0.4 + (INSTANTS - 1) * down + tall + 0.75
    panels |= {title: (_LEFT + n * (_MAP + _GAP), top, _MAP, _MAP) for n, title in enumerate(shown)}
    panels["drift"] = (width - _DRIFT - 0.3, top, _DRIFT, _MAP)
    return (width, top + _MAP + _HEAD), panels


def _draw_map(axes: Axes, example: Example, title: str, hues: dict[str, str], frames: IntArray, around: slice) -> None:
    """One solver's map, in m from where the camera truly began."""
    truth, hue, start = example.truth, hues[title], example.truth.poses[0, :2]
    _set_window(axes, example)
    seen = example.sequence.observed[around, :, None]
    for positions, colour, width in ((truth.positions, style.TRUTH_TAIL, 1.6), (example.people[title], hue, 0.8)):
        _draw_tracks(axes, np.where(seen, positions[around], np.nan) - start, colour, width)
    axes.plot(*(truth.poses[:, :2] - start).T, color=style.INK, linewidth=2.4, zorder=3.0)
    way = example.ways[title][:, :2] - start
    axes.plot(*way[np.isfinite(way).all(axis=1)].T, color=hue, linewidth=1.8, zorder=3.2)
    for number, frame in enumerate(frames.tolist(), 1):
        x, y = truth.poses[frame, :2] - start
        axes.plot(x, y, marker="o", markersize=11, color=style.INK, markeredgecolor="white", zorder=4.0)
        look: dict[str, Any] = {"fontsize": 7.5, "weight": "bold", "ha": "center", "va": "center_baseline"}
        axes.text(x, y, str(number), color="white", zorder=4.1, **look)
    axes.set_title(title, fontsize=10.0, loc="left", color=hue, weight="bold")


def _draw_reference(axes: Axes, example: Example, way: FloatArray) -> None:
    moved = (way[:, :2] - example.truth.poses[0, :2]).T
    axes.plot(*moved, color=_REFERENCE, linewidth=1.3, linestyle=(0, (3, 2)), zorder=3.4)


def _set_window(axes: Axes, example: Example) -> None:
    """What is true, within what lies 25 m from the camera's way at most, at equal scale."""
    poses, people = example.truth.poses[:, :2], example.truth.positions[example.sequence.observed]
    near = people.clip(poses.min(axis=0) - 25.0, poses.max(axis=0) + 25.0)
    points = np.concatenate([poses, near]) - poses[0]
    low, high = np.nanmin(points, axis=0) - 1.0, np.nanmax(points, axis=0) + 1.0
    middle, half = 0.5 * (low + high), 0.5 * float((high - low).max())
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    axes.set_aspect("equal")
    axes.set_xlabel("m", fontsize=style.TEXT_SIZE)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def _draw_tracks(axes: Axes, positions: FloatArray, colour: str, width: float) -> None:
    """People's ways, positions [T, K, 2]."""
    lines = LineCollection(list(np.swapaxes(positions, 0, 1)), colors=colour, linewidths=width, zorder=2.0)
    axes.add_collection(lines, autolim=False)


def _draw_drift(axes: Axes, course: Course, study: RobotStudy, hues: dict[str, str]) -> None:
    """Mean drift of every way; dotted under all protocols but the first."""
    for row in course.rows:
        known = [one for one in row.drifts if len(one.shift)]
        first = row.protocol in ("", study.protocols[0])
        look: dict[str, Any] = {"linewidth": 2.0} if first else {"linewidth": 1.4, "linestyle": (0, (1, 1.4))}
        if not row.protocol:
            look["linestyle"] = (0, (3, 2))
        axes.plot(
            [one.length for one in known],
            [100.0 * one.mean for one in known],
            color=hues[row.title],
            marker="o" if first else None,
            markersize=3.5,
            label=row.title if first else None,
            **look,
        )
    axes.plot([], [], color=style.INK, linewidth=2.2, label="the true way")
    for protocol in study.protocols[1:]:
        axes.plot([], [], color=style.TRUTH, linewidth=1.4, linestyle=(0, (1, 1.4)), label=f"{protocol} (right)")
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(FixedLocator([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0]))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("distance gone (m)", fontsize=style.TEXT_SIZE)
    axes.set_title("drift, % of the distance", fontsize=10.0, loc="left", color=style.INK, weight="bold")


def _draw_boxes(axes: Axes, example: Example, number: int, frame: int, backdrop: Backdrop) -> None:
    """The image plane of one frame with its boxes, over its picture if there is one."""
    camera, picture = example.dataset.camera(example.sequence), backdrop.recorded(frame)
    width, height = camera.picture_size
    if picture is not None:
        place = (0.0, backdrop.width / backdrop.zoom, backdrop.height / backdrop.zoom, 0.0)
        axes.imshow(picture, extent=place, zorder=0.2)
    columns = np.linspace(0.0, width, 200)
    axes.plot(columns, camera.horizon(columns), color="#b0b0b0", linewidth=0.7, linestyle=(0, (6, 3)), zorder=0.5)
    boxes = example.sequence.observations[frame]
    boxes = boxes[~np.isnan(boxes[:, 2])]
    boxes = boxes[np.argsort(-boxes[:, 2])]  # small ones lie on top
    hues = style.distance_colours()(1.0 - np.clip(2.0 * boxes[:, 2] / height, 0.0, 1.0))[:, :3]
    for box, row in zip(*with_seam_copies(rectangles(boxes), camera.period), strict=True):
        look: dict[str, Any] = {"facecolor": (*hues[row], 0.07), "edgecolor": hues[row], "linewidth": 1.1}
        axes.add_patch(Rectangle(box[:2], box[2], box[3], zorder=2.0 + row / 1000.0, **look))
    axes.set(xlim=(0, width), ylim=(height, 0), xticks=[], yticks=[])
    axes.set_aspect("equal")
    look = {"textcoords": "offset points", "fontsize": 8.0, "weight": "bold", "va": "top", "zorder": 5.0}
    box_of_text = {"boxstyle": "round,pad=0.25", "facecolor": style.INK, "edgecolor": "none"}
    corner = {"xycoords": "axes fraction", **look}
    axes.annotate(str(number), (0.0, 1.0), (6.0, -6.0), color="white", bbox=box_of_text, **corner)
    axes.annotate(f"{frame * example.dataset.info.dt:.1f} s", (0.0, 1.0), (20.0, -6.0), color=style.INK, **corner)


def _name_directions(axes: Axes, camera: Camera) -> None:
    """Under a picture that sees all around, where it looks."""
    if camera.period is not None:
        azimuth = np.radians([-179.999, -90.0, 0.0, 90.0, 179.999])
        level = np.stack([np.sin(azimuth), np.zeros(5), np.cos(azimuth)], axis=-1)
        columns = camera.pixels(camera.to_camera(level))[:, 0]
        axes.set_xticks(columns, ["behind", "left", "ahead", "right", "behind"], fontsize=style.TEXT_SIZE)
