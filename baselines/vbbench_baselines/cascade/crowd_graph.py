"""The crowd graph: who takes part, who interacts with whom, and how strongly.

Edges join each person with its nearest neighbours within reach. Two people at distance d feel the pairwise potential of
arXiv 2111.05060, eq. 12 (σ² = 1 m²),

    V_ik = ‖∇ exp(−d²/2σ²)‖ = (d/σ²) exp(−d²/2σ²),

in m/s², like D_k: greatest at d = σ, zero for people far apart. In very large crowds only the nearest people take part.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel


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


@kernel
def link(positions: FloatArray, reach: float, most: int) -> IntArray:
    """Edges [E, 2], i < j, where j is among i's ``most`` nearest within ``reach`` m, or i among j's.

    Positions [K, 2] in m; NaN has no neighbours. At most K·``most`` edges, so that what follows is linear in K.
    """
    people = len(positions)
    linked = np.zeros((people, people), np.bool_)
    near, ids = np.empty(most), np.empty(most, np.int64)
    for i in range(people):
        count = 0
        for j in range(people):
            dx, dy = positions[j, 0] - positions[i, 0], positions[j, 1] - positions[i, 1]
            squared = dx * dx + dy * dy
            if i == j or not squared < reach * reach or (count == most and squared >= near[most - 1]):
                continue
            slot = min(count, most - 1)
            while slot > 0 and near[slot - 1] > squared:
                near[slot], ids[slot] = near[slot - 1], ids[slot - 1]
                slot -= 1
            near[slot], ids[slot] = squared, j
            count = min(count + 1, most)
        for slot in range(count):
            linked[min(i, ids[slot]), max(i, ids[slot])] = True
    edges, e = np.empty((people * most, 2), np.int64), 0
    for i in range(people):
        for j in range(people):
            if linked[i, j]:
                edges[e, 0], edges[e, 1] = i, j
                e += 1
    return edges[:e]


@kernel
def potential(squared: float, sigma: float) -> float:
    """V at the squared distance d² in m²."""
    return float(np.sqrt(squared) / sigma**2 * np.exp(-0.5 * squared / sigma**2))


@kernel
def pull(positions: FloatArray, graph: CrowdGraph) -> FloatArray:
    """Gradient [K, 2] in 1/m of λ Σ V over the edges, at positions [K, 2] in m."""
    edges, strength, sigma = graph
    gradient = np.zeros(positions.shape)
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        dx, dy = positions[i, 0] - positions[j, 0], positions[i, 1] - positions[j, 1]
        squared = dx * dx + dy * dy
        distance = max(np.sqrt(squared), 1e-9)
        slope = strength * (1.0 - squared / sigma**2) / sigma**2 * np.exp(-0.5 * squared / sigma**2) / distance
        gradient[i, 0] += slope * dx
        gradient[i, 1] += slope * dy
        gradient[j, 0] -= slope * dx
        gradient[j, 1] -= slope * dy
    return gradient
