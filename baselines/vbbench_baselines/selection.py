"""Crowds too large to be reasoned about whole: the people who are nearest in the picture."""

import numpy as np

from vbbench.arrays import BoolArray, FloatArray


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
