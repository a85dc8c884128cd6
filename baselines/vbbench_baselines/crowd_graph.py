"""Who feels whom: the edges of the crowd graph, each person's nearest neighbours within reach."""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel


@kernel
def link(positions: FloatArray, reach: float, most: int) -> IntArray:
    """Edges [E, 2], i < j, where j is among i's ``most`` nearest within ``reach`` m, or i among j's.

    Positions [K, 2] in m; NaN has no neighbours. At most K·``most`` edges, so that what follows is linear in K.
    """
    people = len(positions)
    linked = np.empty((people, people), np.bool_)
    near, ids = np.empty(most), np.empty(most, np.int64)
    for i in range(people):
        for j in range(people):
            linked[i, j] = False
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
    return _pairs(linked)


@kernel
def _pairs(linked: BoolArray) -> IntArray:
    """Edges [E, 2] for which ``linked`` [K, K] is true, in its order."""
    count = 0
    for i in range(len(linked)):
        for j in range(len(linked)):
            count += linked[i, j]
    edges, e = np.empty((count, 2), np.int64), 0
    for i in range(len(linked)):
        for j in range(len(linked)):
            if linked[i, j]:
                edges[e, 0], edges[e, 1] = i, j
                e += 1
    return edges
