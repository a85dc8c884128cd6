"""Pictures of a sequence: the map next to what the camera saw, a legend, and a title. Nothing here touches pyplot."""

from collections.abc import Sequence as Several
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vbbench.errors import SubmissionError, VbbenchError
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.geometry import FloatArray
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.colours import Look, solver_looks
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.bird import draw_bird, draw_pose, fill_map
from vbbench.pictures.plotting.captions import ROW, draw_facts, draw_legend, draw_scale, draw_table, draw_title
from vbbench.pictures.plotting.ego import draw_ego, shown_columns, strip_aspect
from vbbench.pictures.plotting.style import (
    Rectangles,
    check_ending,
    distance_colours,
    draw_lines,
    draw_points,
    lay_out,
    save_picture,
)
from vbbench.pictures.replay import Answer, Replay, load_replay
from vbbench.protocol import START_FRAMES
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import PerSequence
from vbbench.scoring.scores import score_sequence
from vbbench.sequence import Sequence

_MOST_PATHS = 16  # of people in all answers together that one map can hold
_WIDTH = {1: 7.4, 2: 6.2, 3: 4.3, 4: 3.5}
"""Inches of a map, by how many are side by side."""
_COLUMNS = {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3}
_SHAPES = 0.5, 0.95  # least and greatest height of a map over its width
_MARGIN, _OUTLIER, _REACH = 0.8, 2.0, 30.0  # m around what is drawn, around the truth, and from the observer
_LEFT, _BOTTOM, _GAP, _ABOVE = 0.65, 0.5, (0.68, 0.75), 0.25  # inches
_TITLE = 0.72


def plot_answers(
    replay: Replay, solvers: Several[str], errors: Several[PerSequence | None], frame: int, notes: Several[str] = ()
) -> Figure:
    """Draw the whole paths of several answers, and one frame's places.

    Parameters
    ----------
    replay : the sequence with the answers.
    solvers : name of the solver of each answer, which decides its colour.
    errors : of each answer in this sequence; ``None`` where there is nothing to compare with.
    frame : which frame's places are marked.
    notes : further things that a reader must know.
    """
    looks = solver_looks(solvers)
    together = replay.sequence.observed.any(axis=0).sum() * len(looks) <= _MOST_PATHS
    low, high = _window(replay, people=True)
    count = 1 if together else len(looks) + 1
    figure = _answers_laid_out(count, len(looks), np.ptp([low, high], axis=0), [*notes, *replay.cautions])
    parts = {axes.get_label(): axes for axes in figure.axes}
    for n in range(count):
        axes = parts[f"map-{n}"]
        fill_map(axes, *((low, high) if together or n else _window(replay, people=False)))
        shown = range(len(looks)) if n == 0 else [n - 1]
        _draw_truth(axes, replay, replay.answers[shown[0]], frame, people=together or n > 0)
        for a in shown:
            _draw_answer(axes, replay, replay.answers[a], looks[a], frame, people=together or n > 0)
        name = replay.answers[n - 1].name if n else "the observer and people" if together else "the observer"
        colour = looks[n - 1].colour if n else style.INK
        axes.set_title(name, fontsize=style.TEXT_SIZE + 1, loc="left", color=colour, weight="bold", pad=4)
    head, rows = table_of(replay, errors)
    draw_table(parts["table"], head, rows, looks)
    _draw_words(figure, replay, frame)
    _draw_legend(figure, parts["legend"])
    return figure


def table_of(replay: Replay, errors: Several[PerSequence | None]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table: each answer's means over the sequence, as a score has them, and its coverage."""
    metrics = {key: metric for key, metric in section("metrics").items() if replay.info.truth in metric.known}
    if replay.truth is None:
        metrics = {}
    rows = []
    for answer, own in zip(replay.answers, errors, strict=True):
        figures = ["–"] * len(metrics) if own is None else [_text(own.figures[key]) for key in metrics]
        rows.append([answer.name, answer.protocol.name, *figures, "–" if own is None else f"{own.total_coverage:.1%}"])
    return ["", "protocol", *(metric.label for metric in metrics.values()), "answered"], rows


def _text(figures: FloatArray) -> str:
    return "–" if np.isnan(figures[0]) else f"{figures[0]:.3f}"


def _answers_laid_out(count: int, answers: int, spans: FloatArray, notes: list[str]) -> Figure:
    columns = _COLUMNS.get(count, 4)
    rows = -(-count // columns)
    width = _WIDTH[columns]
    height = width * float(np.clip(spans[1] / spans[0], *_SHAPES))
    table = ROW * (answers + 1) + 0.1
    legend = 0.25
    parts: Rectangles = {}
    for n in range(count):
        row, column = divmod(n, columns)
        left, bottom = _LEFT + column * (width + _GAP[0]), _BOTTOM + (rows - 1 - row) * (height + _GAP[1])
        parts[f"map-{n}"] = left, bottom, width, height
    above = _BOTTOM + rows * height + (rows - 1) * _GAP[1] + _ABOVE
    across = max(columns * (width + _GAP[0]) - _GAP[0], _WIDTH[1])
    parts["legend"] = _LEFT, above, across, legend
    parts["table"] = _LEFT, above + legend, across, table
    return lay_out((across + _LEFT + 0.2, above + legend + table + _TITLE), parts, notes, _LEFT)


def _window(replay: Replay, *, people: bool) -> tuple[FloatArray, FloatArray]:
    """The ground (low, high) that holds the truth near the observer, and the answers that stay near it."""
    poses = replay.viewpoints[:, :2]
    near = np.nanmin(poses, axis=0) - _REACH, np.nanmax(poses, axis=0) + _REACH
    seen = replay.sequence.observed & people
    real = np.vstack([poses, replay.known.positions[seen].clip(*near)])
    around = np.nanmin(real, axis=0) - _OUTLIER, np.nanmax(real, axis=0) + _OUTLIER
    answers = [np.vstack([own.estimate.poses[:, :2], own.estimate.positions[seen]]) for own in replay.answers]
    points = np.vstack([real, *(places.clip(*around) for places in answers)])
    return np.nanmin(points, axis=0) - _MARGIN, np.nanmax(points, axis=0) + _MARGIN


def _draw_truth(axes: Axes, replay: Replay, answer: Answer, frame: int, *, people: bool) -> None:
    truth = replay.truth if answer.truth is None else answer.truth
    if truth is None:
        return
    if people:
        draw_lines(axes, np.swapaxes(truth.positions, 0, 1), style.TRUTH_TAIL, 1.1, 2.0).set_gid("true-people")
        seen = replay.sequence.observed[frame]
        look: dict[str, Any] = {"s": 24, "c": "white", "edgecolors": style.TRUTH, "linewidths": 0.9, "zorder": 3.0}
        draw_points(axes, truth.positions[frame, seen], "true-places", **look)
    axes.plot(*truth.poses[:, :2].T, color=style.TRUTH, linewidth=3.0, zorder=2.4, gid="true-path")
    draw_pose(axes, truth.poses[frame], style.TRUTH, "true-pose")


def _draw_answer(axes: Axes, replay: Replay, answer: Answer, look: Look, frame: int, *, people: bool) -> None:
    estimate, name = answer.estimate, answer.name
    if people:
        seen = replay.sequence.observed
        paths = np.where(seen[..., None], estimate.positions, np.nan)
        drawn = draw_lines(axes, np.swapaxes(paths, 0, 1), look.colour, 1.0, 2.6, look.dashes)
        drawn.set_gid(f"people-{name}")
        drawn.set_alpha(0.8)
        places = paths[frame, seen[frame]]
        draw_points(axes, places, f"places-{name}", s=11, c=look.colour, linewidths=0, zorder=4.0)
        if answer.truth is not None:
            errors = np.stack([answer.truth.positions[frame, seen[frame]], places], axis=1)
            draw_lines(axes, errors, style.INK, 0.8, 3.6).set_gid(f"errors-{name}")
        given = answer.given.positions.reshape(-1, 2)
        draw_points(axes, given, "given", s=7, marker="D", c="none", edgecolors=style.GIVEN, linewidths=0.5, zorder=2.5)
    line: dict[str, Any] = {"color": look.colour, "linestyle": look.dashes, "linewidth": 1.7, "zorder": 4.5}
    axes.plot(*estimate.poses[:, :2].T, gid=f"path-{name}", **line)
    draw_pose(axes, estimate.poses[frame], look.colour, f"pose-{name}")
    _mark_exit(axes, estimate.poses[:, :2], look.colour, f"exit-{name}")


def _mark_exit(axes: Axes, path: FloatArray, colour: str, gid: str) -> None:
    """Where a path first leaves the map, a triangle at its edge."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    low, high = np.array([left, bottom]), np.array([right, top])
    outside = np.flatnonzero(np.any((path < low) | (path > high), axis=1))
    if not len(outside):
        return
    place = path[outside[0]].clip(low, high)
    away = path[outside[0]] - (low + high) / 2.0
    angle = float(np.degrees(np.arctan2(away[1], away[0]))) - 90.0
    look: dict[str, Any] = {
        "markersize": 12,
        "color": colour,
        "markeredgecolor": "white",
        "clip_on": False,
        "zorder": 8,
    }
    axes.plot(*place, marker=(3, 0, angle), gid=gid, linestyle="none", **look)


def _draw_words(figure: Figure, replay: Replay, frame: int) -> None:
    info, sequence = replay.info, replay.sequence
    people = int(sequence.observed.any(axis=0).sum())
    facts = [f"{people} people seen, dt = {info.dt:g} s", f"places marked in frame {frame}"]
    facts += [replay.caveat] if replay.caveat else ["errors: means over the scored frames of this sequence"]
    style.write_heading(figure, _LEFT, replay.heading(f"{sequence.frames} frames"), ";  ".join(facts))


def _draw_legend(figure: Figure, legend: Axes) -> None:
    legend.set_axis_off()
    tight: dict[str, Any] = {"borderpad": 0.0, "borderaxespad": 0.0, "columnspacing": 1.4, "handletextpad": 0.6}
    look: dict[str, Any] = {"loc": "center left", "ncols": 8, "frameon": False, "fontsize": style.TEXT_SIZE}
    legend.legend(handles=_handles(figure), **look, **tight)


def _handles(figure: Figure) -> list[Line2D]:
    drawn = {artist.get_gid() or "" for axes in figure.axes for artist in axes.get_children()}
    point: dict[str, Any] = {"linestyle": "none", "marker": "o"}
    handles = []
    if "true-path" in drawn:
        handles.append(Line2D([], [], color=style.TRUTH, linewidth=3.0, label="truth"))
    if "true-places" in drawn:
        hollow: dict[str, Any] = {"markerfacecolor": "none", "color": style.TRUTH, "markersize": 5}
        handles.append(Line2D([], [], label="true place", **point, **hollow))
        handles.append(Line2D([], [], label="estimate", color=style.INK, markersize=3.5, **point))
    if any(gid.startswith("errors-") for gid in drawn):
        handles.append(Line2D([], [], color=style.INK, linewidth=0.8, label="error"))
    if "given" in drawn:
        diamond: dict[str, Any] = {
            "marker": "D",
            "linestyle": "none",
            "markerfacecolor": "none",
            "color": style.GIVEN,
            "markersize": 3,
        }
        handles.append(Line2D([], [], label="given", **diamond))
    if any(gid.startswith("exit-") for gid in drawn):
        handles.append(Line2D([], [], marker="^", linestyle="none", color=style.INK, label="leaves the map"))
    return handles


_STACKED_SIZE = (11.0, 7.056)
_STACKED: Rectangles = {
    "ego": (0.6, 0.55, 10.2, 0.0),
    "bird": (0.6, 1.406, 7.3, 4.95),
    "scale": (8.25, 5.856, 2.5, 0.14),
    "legend": (8.15, 3.056, 2.7, 2.4),
    "facts": (8.15, 1.406, 2.7, 1.75),
}
"""The map over a wide picture, which has no height yet."""
_WIDE = 2.0  # width of a picture over its height from which on it is wide
_ABREAST_SIZE = (13.0, 6.3)
_ABREAST: Rectangles = {
    "bird": (0.6, 0.55, 5.6, 5.1),
    "ego": (6.9, 2.3, 5.95, 3.35),
    "scale": (6.9, 1.4, 2.4, 0.14),
    "legend": (9.45, 0.1, 3.45, 1.75),
    "facts": (6.8, 0.1, 2.6, 0.85),
}


def plot_sequence(
    dataset: Dataset,
    index: int,
    estimate: Estimate | None = None,
    *,
    frame: int | None = None,
    solver: str = "",
    protocol: str = "sequential",
) -> Figure:
    """Draw one frame of a sequence from above, with all tracks, next to what the camera saw.

    Raises VbbenchError if there is no such sequence, frame or protocol, or the estimate has another shape.

    Parameters
    ----------
    dataset : the dataset; without truth, what is given and estimated is drawn.
    index : number of the sequence.
    estimate : a solver's answer for the whole sequence.
    frame : frame of the sequence, from 0; by default the fullest of the middle third.
    solver : name to show on the picture.
    protocol : what the solver was given; that is marked, and not counted in the errors of the frame.
    """
    replay = load_replay(dataset, index)
    if estimate is not None:
        replay = replay.with_answer(solver or "estimate", protocol, estimate)
    return plot_replay(replay, frame)


def plot_replay(replay: Replay, frame: int | None = None) -> Figure:
    """Draw one frame of a replay; see `plot_sequence`."""
    frame = _checked(replay, frame)
    colours = person_colours(replay, frame)
    backdrop = Backdrop(replay.dataset, replay.sequence, [frame], window=replay.window)
    columns = shown_columns(replay, frame)
    figure = _laid_out(replay, backdrop, columns)
    parts = {axes.get_label(): axes for axes in figure.axes}
    draw_bird(parts["bird"], replay, frame, colours)
    draw_ego(parts["ego"], replay, frame, colours, backdrop, columns)
    draw_scale(parts["scale"], colours)
    draw_legend(parts["legend"], replay, frame)
    draw_facts(parts["facts"], replay, frame, columns)
    draw_title(figure, replay, frame)
    return figure


def _laid_out(replay: Replay, backdrop: Backdrop, columns: tuple[float, float]) -> Figure:
    """The map over a wide picture and next to another."""
    if replay.camera.period is None and backdrop.width < _WIDE * backdrop.height:
        return lay_out(_ABREAST_SIZE, _ABREAST, replay.cautions)
    height = _STACKED["ego"][2] * strip_aspect(replay, backdrop, columns)
    raised: Rectangles = {
        name: (left, bottom, width, height) if name == "ego" else (left, bottom + height, width, high)
        for name, (left, bottom, width, high) in _STACKED.items()
    }
    return lay_out((_STACKED_SIZE[0], _STACKED_SIZE[1] + height), raised, replay.cautions)


def _checked(replay: Replay, frame: int | None) -> int:
    """The frame to draw; by default the fullest of the middle third, or without truth and answers the last given."""
    sequence = replay.sequence
    if frame is None:
        bare = replay.truth is None and not replay.answers and np.isfinite(replay.given.positions).any()
        return min(START_FRAMES, sequence.frames) - 1 if bare else middle_frame(sequence)
    if not 0 <= frame < sequence.frames:
        raise VbbenchError(f"sequence {sequence.index} has frames 0 to {sequence.frames - 1}, not {frame}")
    return frame


def middle_frame(sequence: Sequence) -> int:
    """The fullest frame of the middle third."""
    first = sequence.frames // 3
    people = sequence.observed.sum(axis=1)[first : max(first + 1, 2 * sequence.frames // 3)]
    return first + int(people.argmax())


def person_colours(replay: Replay, frame: int) -> ScalarMappable:
    """The colour of a person in every view, by distance in m."""
    farthest = np.ceil(np.nanmax(replay.distances[frame], initial=1.0))
    return ScalarMappable(Normalize(0.0, farthest), distance_colours())


def plot_to_file(
    dataset: Dataset, index: int, out: Path | str, *, submissions: Several[Path | str] = (), frame: int | None = None
) -> Path:
    """Draw a sequence, and submissions' answers to it, into a PNG, PDF or SVG file.

    Of one answer it is the picture of `plot_sequence`, of several that of `plot_answers`. An answer with faults is
    drawn as far as it goes, and its faults stand on the picture.

    Raises VbbenchError if a submission cannot be read or answers another dataset, besides what `plot_sequence` raises.
    """
    check_ending(out)
    replay = load_replay(dataset, index, submissions)
    save_picture(plot_replay(replay, frame) if len(submissions) < 2 else _compared(replay, submissions, frame), out)
    return Path(out)


def _compared(replay: Replay, submissions: Several[Path | str], frame: int | None) -> Figure:
    errors: list[PerSequence | None] = []
    notes = []
    for answer, folder in zip(replay.answers, submissions, strict=True):
        try:
            scored = replay.truth is not None and bool(answer.errors)
            errors.append(score_sequence(folder, replay.dataset, replay.sequence.index) if scored else None)
        except SubmissionError as error:
            errors.append(None)
            notes.append(f"{answer.name} is not scored: {error.faults[0]}" + _more(len(error.faults) - 1))
    solvers = [SubmissionInfo.read(folder).solver for folder in submissions]
    return plot_answers(replay, solvers, errors, _checked(replay, frame), notes)


def _more(faults: int) -> str:
    return f" (and {faults} more)" if faults else ""
