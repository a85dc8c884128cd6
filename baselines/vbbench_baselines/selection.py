"""Crowds too large to be reasoned about whole: the people who are nearest."""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray


def select(observations: FloatArray, most: int, smallest: float) -> BoolArray:
    """Which people [K] take part: all if at most ``most`` are seen, else the ``most`` of greatest box height.

    Parameters
    ----------
    observations : [K, 3] boxes in px, NaN = not observed. Who is not observed takes no part in a large crowd.
    smallest : ε, the box height in px which it takes to be selected from a large crowd.
    """
    size = np.nan_to_num(observations[:, 2])
    if np.count_nonzero(size) <= most:
        return np.ones(len(size), np.bool_)
    chosen: BoolArray = (size >= np.partition(size, -most)[-most]) & (size > smallest)
    return chosen


def nearest(rays: FloatArray, most: int) -> BoolArray:
    """Which people [K] are the ``most`` nearest by their rays [K, 2] (see `Sightings`), all if there are no more."""
    distance = np.hypot(rays[:, 0], rays[:, 1])
    if np.count_nonzero(~np.isnan(distance)) <= most:
        return np.ones(len(rays), np.bool_)
    near: BoolArray = distance <= np.partition(distance, most - 1)[most - 1]
    return near
