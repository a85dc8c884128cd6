"""Pictures of the five-point study: boxes over distance with lines of view birdification, and all readings."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from vbbench.paper import the_paper
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import draw_heading, lay_out, spread
from vbbench.reproduction.keypoints.people import KITTI, Line
from vbbench.reproduction.keypoints.study import FIVE_POINT, FROM_TRUTH, GOOD, LEAST_SQUARES, Keypoints

PAPER, OURS, CAR = style.ESTIMATE, style.GIVEN, "#009e73"
"""Colours of the lines: the paper's, ours, and ours on KITTI."""
_SQUARES = "#aa4499"
_DRAWN_ROWS = (("hotel", "ideal"), ("eth", "ideal"), ("students", "ideal"), ("street", "tracked"))
"""Split and tier of the paper's rows in the picture; the table has all of them."""
_SIZE, _LEFT, _WIDTH = (12.4, 9.6), 0.85, 8.1
_TRANSLATION, _ROTATION = (3.7, 4.85), (0.6, 2.65)
"""Bottom and height in inches of the panels."""
_GAP = 0.185
"""Inches from one label to the next."""
_LOWEST = {"translation": 3e-3, "rotation": 3e-4}
_HIGHEST = {"translation": 3.0, "rotation": 4.0}


@dataclass(frozen=True)
class _Label:
    """A line of a panel: its height in the panel's unit, what it says, colour and dashes."""

    height: float
    text: str
    colour: str
    dashes: str


def plot_keypoints(found: Keypoints) -> Figure:
    """Draw the errors of translation and rotation over distance, and the lines of the first solver and of the paper."""
    panels = {
        "translation": (_LEFT, _TRANSLATION[0], _WIDTH, _TRANSLATION[1]),
        "rotation": (_LEFT, _ROTATION[0], _WIDTH, _ROTATION[1]),
    }
    drawn = lay_out(_SIZE, panels)
    for axes, kind in zip(drawn.axes, panels, strict=True):
        _draw_errors(axes, found, kind)
        _draw_lines(axes, _labels(found, kind), kind)
    upper, lower = drawn.axes
    _mark_crossings(upper, found)
    upper.set_ylabel("error of translation (m)", fontsize=style.TEXT_SIZE)
    lower.set_ylabel("error of rotation (rad)", fontsize=style.TEXT_SIZE)
    lower.set_xlabel("distance of the static points (m)", fontsize=style.TEXT_SIZE)
    for colour, name in ((PAPER, "the paper"), (OURS, f"here, {found.study.people.solvers[0]}"), (CAR, "same, KITTI")):
        upper.plot([], [], color=colour, linewidth=1.6, label=name)
    setting = found.study.setting
    facts = (
        f"{found.study.trials} trials at each distance, 100 points, ±1 px, {setting.camera.width} × "
        f"{setting.camera.height} px, f {setting.camera.focal:g} px, length of translation true; boxes: quartiles, "
        "whiskers: 1.5 times their distance; dashed: sequential"
    )
    title = "How far off is the camera? Static points at a distance, and people around it"
    draw_heading(drawn, _LEFT, title, facts, upper)
    return drawn


def _draw_errors(axes: Axes, found: Keypoints, kind: str) -> None:
    distances = found.distances
    errors = {name: getattr(own, kind) for name, own in found.errors.items()}
    look: dict[str, Any] = {"color": style.TRUTH, "linewidth": 0.8}
    axes.boxplot(
        list(np.maximum(errors[FIVE_POINT], _LOWEST[kind])),
        positions=distances,
        widths=0.55 * float(np.min(np.diff(distances))),
        manage_ticks=False,
        patch_artist=True,
        boxprops={"facecolor": style.TRUTH_FAINT, "edgecolor": style.TRUTH, "linewidth": 0.8},
        medianprops={"color": style.INK, "linewidth": 1.4},
        whiskerprops=look,
        capprops=look,
        flierprops={"marker": ".", "markersize": 2.5, "markeredgecolor": style.TRUTH_TAIL},
    )
    axes.plot([], [], color=style.INK, linewidth=1.4, label="five points: median")
    if kind == "translation":
        means = errors[FIVE_POINT].mean(axis=1)
        axes.plot(distances, means, color=style.INK, linewidth=1.0, marker="D", markersize=3.5, label="mean")
        squares = [errors[name].mean(axis=1) for name in (LEAST_SQUARES, FROM_TRUTH)]
        axes.plot(distances, squares[0], color=_SQUARES, linewidth=1.6, label="least squares: mean")
        axes.plot(distances, squares[1], color=_SQUARES, linewidth=1.2, linestyle=":", label="next to the truth")
    else:
        axes.plot(distances, np.median(errors[LEAST_SQUARES], axis=1), color=_SQUARES, linewidth=1.6)
    axes.set_yscale("log")
    axes.set_ylim(_LOWEST[kind], _HIGHEST[kind])
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    step = float(distances[1] - distances[0])
    axes.set_xlim(distances[0] - 0.7 * step, distances[-1] + 0.7 * step)
    axes.set_xticks(distances)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(axis="y", color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def drawn_lines(found: Keypoints) -> list[Line]:
    """The lines in the picture: some of the paper's rows, and of ours those of the first solver."""
    return [
        line
        for line in found.lines
        if ((line.split, line.tier) in _DRAWN_ROWS if line.is_papers else line.solver == found.study.people.solvers[0])
    ]


def _labels(found: Keypoints, kind: str) -> list[_Label]:
    labels, curve = [], found.curves[FIVE_POINT]
    for line in drawn_lines(found):
        level = getattr(line, kind)
        place = f"{line.split}, {line.tier}" if line.tier not in ("ideal", "footage") else line.split
        text = f"{place}{'' if line.is_papers else f', {line.protocol}'} {level.value:.3f}"
        if kind == "translation":
            distance = curve.rises_over(level.value)
            last = curve.distances[-1]
            reached = f"from {distance:.0f} m on" if distance > curve.distances[0] else "everywhere"
            text += f": better {reached}" if np.isfinite(distance) else f": not up to {last:g} m"
        colour = PAPER if line.is_papers else CAR if line.split == KITTI else OURS
        labels.append(_Label(level.value, text, colour, "--" if line.protocol == "sequential" else "-"))
    return labels


def _draw_lines(axes: Axes, labels: list[_Label], kind: str) -> None:
    inches = _TRANSLATION[1] if kind == "translation" else _ROTATION[1]
    span = np.log(_HIGHEST[kind] / _LOWEST[kind])
    wanted = inches * np.log(np.array([one.height for one in labels]) / _LOWEST[kind]) / span
    heights = spread(wanted, _GAP, 0.1, inches - 0.1) / inches
    for one, place in zip(labels, heights.tolist(), strict=True):
        axes.axhline(one.height, color=one.colour, linewidth=1.1, linestyle=one.dashes, alpha=0.85, zorder=1.5)
        axes.annotate(
            one.text,
            xy=(1.0, one.height),
            xycoords=("axes fraction", "data"),
            xytext=(1.04, place),
            textcoords="axes fraction",
            va="center",
            fontsize=7.6,
            color=one.colour,
            arrowprops={
                "arrowstyle": "-",
                "color": one.colour,
                "linewidth": 0.6,
                "shrinkA": 2,
                "shrinkB": 0,
                "relpos": (0.0, 0.5),
            },
        )


def _mark_crossings(axes: Axes, found: Keypoints) -> None:
    """A point where each line meets the mean of the five-point method."""
    curve = found.curves[FIVE_POINT]
    for line, label in zip(drawn_lines(found), _labels(found, "translation"), strict=True):
        distance = curve.rises_over(line.translation.value)
        if curve.distances[0] < distance < np.inf:
            axes.plot(
                distance, label.height, "o", color=label.colour, markersize=5.5, markeredgecolor="white", zorder=4
            )


_NAMES, _PANEL, _ROW, _HEAD, _FOOT = 3.6, 6.4, 0.235, 1.15, 0.65
"""Inches: names, width of the panel, height of a row, over and under the panel."""


def plot_readings(found: Keypoints) -> Figure:
    """Draw mean errors of every reading at the paper's distances, beside what the paper says of them."""
    paper, rows = the_paper().keypoints, np.arange(len(found.readings))
    height = _ROW * len(rows)
    size = (_NAMES + _PANEL + 0.35, _FOOT + height + _HEAD)
    drawn = lay_out(size, {"readings": (_NAMES, _FOOT, _PANEL, height)})
    (axes,) = drawn.axes
    near, far = f"{paper.good_to:g} m", f"{paper.poor_from:g} m"
    marks: list[tuple[str, str, str, list[float]]] = [
        (f"at {near}", OURS, "o", [one.mean_at(paper.good_to) for one in found.readings]),
        (f"at {far}", PAPER, "o", [one.mean_at(paper.poor_from) for one in found.readings]),
        (f"from {far} on", CAR, "D", [one.mean_from(paper.poor_from) for one in found.readings]),
    ]
    for name, colour, marker, values in marks:
        axes.plot(values, rows, marker, color=colour, markersize=5.5, label=f"mean error {name}")
    axes.axvline(GOOD, color=OURS, linewidth=1.1, label=f"{GOOD:g} m: good")
    axes.axvline(
        paper.poor_error, color=PAPER, linewidth=1.1, label=f"the paper's {paper.poor_error:.2f} m from {far} on"
    )
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(rows, [one.reading.name for one in found.readings])
    axes.set_xlabel("mean error of translation (m)", fontsize=style.TEXT_SIZE)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    trials = f"{found.study.trials_of_reading} trials at every second distance"
    facts = f"five-point method, {trials}; one thing of the figure is changed in a row, in the last three several"
    draw_heading(drawn, 0.3, "What the text leaves open", facts, axes)
    return drawn
