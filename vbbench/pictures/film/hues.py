"""Colours of a film, those of the plots, as OpenCV wants them."""

from functools import cache

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.pictures.film.paint import Colour, rgb
from vbbench.pictures.plotting import style

INK, WHITE = rgb(style.INK), (255, 255, 255)
TRUTH, TRUTH_FAINT, TRUTH_TAIL = rgb(style.TRUTH), rgb(style.TRUTH_FAINT), rgb(style.TRUTH_TAIL)
ESTIMATE, CAUTION, GRID = rgb(style.ESTIMATE), rgb(style.CAUTION), rgb(style.FAINT)
UNSEEN, FIELD, FIELD_EDGE = rgb("#b5b5b5"), rgb("#f3efe2"), rgb("#cbbf98")


def distance_hues(distances: FloatArray, farthest: float) -> list[Colour]:
    """Colours of people at distances [K] in m, from dark near to light at ``farthest``; ink where NaN."""
    place = np.clip(np.asarray(distances) / farthest, 0.0, 1.0)
    steps = np.where(np.isnan(place), 0.0, np.round(255.0 * place)).astype(int)
    return [INK if np.isnan(p) else _ramp()[step] for p, step in zip(place, steps, strict=True)]


def contrast(colour: Colour) -> Colour:
    """White or ink, whichever shows beside ``colour`` (luminance as in Rec. 601)."""
    red, green, blue = colour
    return WHITE if 0.299 * red + 0.587 * green + 0.114 * blue < 140.0 else INK


@cache
def _ramp() -> list[Colour]:
    colours = style.distance_colours()(np.linspace(0.0, 1.0, 256))[:, :3]
    return [(int(r), int(g), int(b)) for r, g, b in np.round(255.0 * colours)]
