"""The whole figure: map, ego view, legend, and a title that states what is shown."""

import io
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from vbbench.camera import PanoramaCamera
from vbbench.errors import FileError
from vbbench.files.dataset import Dataset
from vbbench.files.submission_rows import SubmittedEstimates
from vbbench.folders.replacing import write_bytes_atomically
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.bird import draw_bird
from vbbench.pictures.plotting.captions import draw_facts, draw_legend, draw_scale, draw_title
from vbbench.pictures.plotting.ego import STRIP_ASPECT, draw_ego
from vbbench.pictures.plotting.moment import Moment, gather
from vbbench.solver import Estimate

_DPI = 150

Rectangles = dict[str, tuple[float, float, float, float]]
"""Left, bottom, width and height in inches of every part of a figure, by its label."""

_PANORAMA_SIZE = (11.0, 9.3)
_PANORAMA: Rectangles = {
    "ego": (0.6, 0.55, 10.2, STRIP_ASPECT * 10.2),
    "bird": (0.6, 3.65, 7.3, 4.95),
    "scale": (8.25, 8.1, 2.5, 0.14),
    "legend": (8.15, 5.3, 2.7, 2.4),
    "facts": (8.15, 3.65, 2.7, 1.75),
}
_PERSPECTIVE_SIZE = (13.0, 6.3)
_PERSPECTIVE: Rectangles = {
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
    """Draw one frame of a sequence from above, with all tracks, beside what the camera saw.

    Parameters
    ----------
    dataset : where the sequence lies; without truth, what is given and estimated is drawn.
    index : number of the sequence.
    estimate : a solver's answer for the whole sequence.
    frame : frame of the sequence, from 0; by default the fullest of the middle third.
    solver : name to put on the picture.
    protocol : what the solver was given; that is marked, and not counted in the errors of the frame.

    Raises
    ------
    VbbenchError
        If there is no such sequence, frame or protocol, or the estimate has another shape.
    """
    moment = gather(dataset, index, estimate, frame=frame, solver=solver, protocol=protocol)
    colours = person_colours(moment)
    panorama = isinstance(dataset.info.camera, PanoramaCamera)
    figure = lay_out(_PANORAMA_SIZE, _PANORAMA) if panorama else lay_out(_PERSPECTIVE_SIZE, _PERSPECTIVE)
    parts = {axes.get_label(): axes for axes in figure.axes}
    draw_bird(parts["bird"], moment, colours)
    draw_ego(parts["ego"], moment, colours)
    draw_scale(parts["scale"], colours)
    draw_legend(parts["legend"], moment)
    draw_facts(parts["facts"], moment)
    draw_title(figure, moment)
    return figure


def person_colours(moment: Moment) -> ScalarMappable:
    """The colour that every view gives a person, by distance in m."""
    farthest = np.ceil(np.nanmax(moment.distances, initial=1.0))
    return ScalarMappable(Normalize(0.0, farthest), style.distance_colours())


def lay_out(size: tuple[float, float], rectangles: Rectangles) -> Figure:
    """An empty figure of that size in inches, with labelled axes in the rectangles."""
    figure = Figure(size, dpi=_DPI, facecolor="white")
    for name, (left, bottom, width, height) in rectangles.items():
        axes = figure.add_axes((left / size[0], bottom / size[1], width / size[0], height / size[1]), label=name)
        axes.tick_params(labelsize=style.TEXT_SIZE)
    return figure


def plot_to_file(
    dataset: Dataset, index: int, out: Path | str, *, submission: Path | str | None = None, frame: int | None = None
) -> Path:
    """Draw a sequence, and a submission's answer to it, into a PNG file; see `plot_sequence` and `save_png`.

    Raises
    ------
    VbbenchError
        If the submission cannot be read or answers another dataset, besides what `plot_sequence` raises.
    """
    if submission is None:
        figure = plot_sequence(dataset, index, frame=frame)
    else:
        submitted = SubmittedEstimates(dataset, submission)
        estimate, info = submitted.of(dataset.sequence(index)), submitted.info
        figure = plot_sequence(dataset, index, estimate, frame=frame, solver=info.solver, protocol=info.protocol)
    save_png(figure, out)
    return Path(out)


def save_png(figure: Figure, path: Path | str) -> None:
    """Write a figure as PNG; the file is there whole or not at all.

    Raises
    ------
    FileError
        If the name does not end in ``.png``.
    """
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise FileError(path, "pictures are written as PNG; give a name that ends in .png")
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=_DPI, metadata={"Software": None})
    write_bytes_atomically(path, picture.getvalue())
