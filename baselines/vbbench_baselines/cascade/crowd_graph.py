"""The crowd graph: who takes part, who interacts with whom, and how strongly.

Edges join each person with its nearest neighbours within reach. Two people at distance d feel the pairwise potential of
arXiv 2111.05060, eq. 12 (σ² = 1 m²),

    V_ik = ‖∇ exp(−d²/2σ²)‖ = (d/σ²) exp(−d²/2σ²),

in m/s², like D_k: greatest at d = σ, zero for people far apart. In very large crowds only the nearest people take part.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray


class CrowdGraph(NamedTuple):
    """The interacting pairs and the strength of their potential.

    Attributes
    ----------
    edges : [E, 2] people (i, j).
    strength, sigma : λ, and σ in m, of λV.
    """

    edges: IntArray
    strength: float
    sigma: float


def select(observations: FloatArray, most: int, smallest: float) -> BoolArray:
    """Which people [K] take part: all if at most ``most`` are seen, else the ``most`` of greatest box height.

    Parameters
    ----------
    observations : [K, 3] boxes in px, NaN = not observed; in a large crowd these people take no part.
    smallest : ε, the box height in px above which people are selected from a large crowd.
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
