"""The whole figure: map, ego view, legend, and a title that states what is shown."""

from collections.abc import Sequence as Several
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from vbbench.errors import SubmissionError, VbbenchError
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.plotting.answers import plot_answers
from vbbench.pictures.plotting.bird import draw_bird
from vbbench.pictures.plotting.captions import cautions, draw_facts, draw_legend, draw_scale, draw_title
from vbbench.pictures.plotting.ego import draw_ego, shown_columns, strip_aspect
from vbbench.pictures.plotting.style import Rectangles, check_ending, distance_colours, lay_out, save_picture
from vbbench.pictures.replay import Replay, load_replay
from vbbench.protocol import START_FRAMES
from vbbench.scoring.error_tables import ErrorsInTime, errors_in_time
from vbbench.sequence import Sequence

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

    Parameters
    ----------
    dataset : the dataset; without truth, what is given and estimated is drawn.
    index : number of the sequence.
    estimate : a solver's answer for the whole sequence.
    frame : frame of the sequence, from 0; by default the fullest of the middle third.
    solver : name to show on the picture.
    protocol : what the solver was given; that is marked, and not counted in the errors of the frame.

    Raises
    ------
    VbbenchError
        If there is no such sequence, frame or protocol, or the estimate has another shape.
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
        return lay_out(_ABREAST_SIZE, _ABREAST, cautions(replay))
    height = _STACKED["ego"][2] * strip_aspect(replay, backdrop, columns)
    raised: Rectangles = {
        name: (left, bottom, width, height) if name == "ego" else (left, bottom + height, width, high)
        for name, (left, bottom, width, high) in _STACKED.items()
    }
    return lay_out((_STACKED_SIZE[0], _STACKED_SIZE[1] + height), raised, cautions(replay))


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

    Raises
    ------
    VbbenchError
        If a submission cannot be read or answers another dataset, besides what `plot_sequence` raises.
    """
    check_ending(out)
    replay = load_replay(dataset, index, submissions)
    save_picture(plot_replay(replay, frame) if len(submissions) < 2 else _compared(replay, submissions, frame), out)
    return Path(out)


def _compared(replay: Replay, submissions: Several[Path | str], frame: int | None) -> Figure:
    errors: list[ErrorsInTime | None] = []
    notes = []
    for answer, folder in zip(replay.answers, submissions, strict=True):
        try:
            scored = replay.truth is not None and bool(answer.errors)
            errors.append(errors_in_time(folder, replay.dataset, replay.sequence.index) if scored else None)
        except SubmissionError as error:
            errors.append(None)
            notes.append(f"{answer.name} is not scored: {error.faults[0]}" + _more(len(error.faults) - 1))
    solvers = [SubmissionInfo.read(folder).solver for folder in submissions]
    return plot_answers(replay, solvers, errors, _checked(replay, frame), notes)


def _more(faults: int) -> str:
    return f" (and {faults} more)" if faults else ""
