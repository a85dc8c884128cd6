"""Colours of a recording, which show on rerun's dark ground; RGBA, 0 to 255."""

import colorsys
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

Colours = NDArray[np.uint8]
"""[N, 4]"""
Colour = tuple[int, int, int, int]

TRUTH, TRAIL, UNSEEN = (214, 214, 214, 255), (150, 150, 150, 255), (110, 110, 110, 255)
GIVEN, ALARM, FRAME = (64, 156, 255, 255), (255, 80, 60, 255), (90, 90, 90, 255)
ERROR = (255, 90, 90, 255)

SOLVERS = (
    (230, 97, 0, 255),
    (86, 180, 233, 255),
    (0, 178, 130, 255),
    (240, 228, 66, 255),
    (204, 121, 167, 255),
    (148, 103, 255, 255),
)
"""One a submission, in order, told apart by colour-blind eyes (after Okabe and Ito); a seventh begins again."""

_GOLDEN = 0.6180339887


def id_colours(ids: Iterable[int]) -> Colours:
    """The colour [N, 4] that belongs to each id, in every recording; neighbouring ids look different."""
    return np.array([_id_colour(int(number)) for number in ids], np.uint8).reshape(-1, 4)


def solver_colour(number: int) -> Colour:
    """The colour of submission ``number``."""
    return SOLVERS[number % len(SOLVERS)]


def _id_colour(number: int) -> Colour:
    hue, light = (number * _GOLDEN) % 1.0, 0.8 + 0.1 * (number % 3)
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.5, light)
    return round(255 * red), round(255 * green), round(255 * blue), 255
