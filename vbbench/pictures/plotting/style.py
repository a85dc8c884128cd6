"""Colours and sizes shared by both views, safe for colour-blind readers (Okabe and Ito; viridis)."""

from matplotlib import colormaps
from matplotlib.colors import Colormap, ListedColormap

INK = "#222222"
TRUTH = "#6f6f6f"
TRUTH_FAINT = "#dcdcdc"
TRUTH_TAIL = "#a8a8a8"
ESTIMATE = "#d55e00"
GIVEN = "#0072b2"
FAINT = "#ededed"
CAUTION = "#9c2a00"

LABEL_SIZE = 6.5
TEXT_SIZE = 8.5
MOST_LABELS = 60
"""In larger crowds only so many of the nearest people bear their ids."""
TAIL_FRAMES = 8
"""Frames of the past drawn darker than the rest of a track."""


def distance_colours() -> Colormap:
    """Near is dark, far is light; the palest end is left out because it does not show on white."""
    return ListedColormap(colormaps["viridis"](range(225)), "distance")
