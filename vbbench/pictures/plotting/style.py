"""Shared by figures: colours safe for colour-blind readers (Okabe and Ito; viridis), sizes, layout and PNG files."""

import io
from pathlib import Path
from typing import Any

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure

from vbbench.errors import FileError
from vbbench.folders.replacing import write_bytes_atomically

INK = "#222222"
TRUTH = "#6f6f6f"
TRUTH_FAINT = "#dcdcdc"
TRUTH_TAIL = "#a8a8a8"
ESTIMATE = "#d55e00"
GIVEN = "#0072b2"
UNSEEN = "#b5b5b5"
FIELD = "#f3efe2"
FIELD_EDGE = "#cbbf98"
FAINT = "#ededed"
CAUTION = "#9c2a00"

LABEL_SIZE = 6.5
TEXT_SIZE = 8.5
MOST_LABELS = 60
"""In larger crowds, only so many of the nearest people are labelled."""
TAIL_FRAMES = 8
"""Frames of the past drawn darker than the rest of a track."""
_DPI = 150

Rectangles = dict[str, tuple[float, float, float, float]]
"""Left, bottom, width and height in inches of every part of a figure, by its label."""


def distance_colours() -> Colormap:
    """Near is dark, far is light; the palest end is left out because it does not show on white."""
    return ListedColormap(colormaps["viridis"](range(225)), "distance")


def lay_out(size: tuple[float, float], rectangles: Rectangles) -> Figure:
    """An empty figure of that size in inches, with labelled axes in the rectangles."""
    figure = Figure(size, dpi=_DPI, facecolor="white")
    for name, (left, bottom, width, height) in rectangles.items():
        axes = figure.add_axes((left / size[0], bottom / size[1], width / size[0], height / size[1]), label=name)
        axes.tick_params(labelsize=TEXT_SIZE)
    return figure


def draw_heading(figure: Figure, left: float, title: str, facts: str, axes: Axes) -> None:
    """Over panels of one kind, from ``left`` inches on: a title, a line of facts, and the legend of ``axes``."""
    x, height = left / figure.get_figwidth(), figure.get_figheight()
    figure.text(x, 1.0 - 0.34 / height, title, fontsize=12.5, weight="bold", color=INK)
    figure.text(x, 1.0 - 0.58 / height, facts, fontsize=TEXT_SIZE, color=INK)
    handles, labels = axes.get_legend_handles_labels()
    look: dict[str, Any] = {"borderaxespad": 0.0, "borderpad": 0.2, "frameon": False, "fontsize": TEXT_SIZE}
    place = (x, 1.0 - 0.66 / height)
    figure.legend(handles, labels, loc="upper left", bbox_to_anchor=place, ncols=len(labels), **look)


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
