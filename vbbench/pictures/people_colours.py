"""Colours that distinguish people: a few that stay different for colour-blind eyes, and who has which of them.

Found by exchange: no two of a palette come closer than `LEAST_APART` in Oklab (Ottosson 2020), for eyes that see all
colours and for those without red, green or blue cones (Machado, Oliveira and Fernandes 2009), and each has a contrast
of 3 to its paper. People who come near one another have different ones, as far as there are enough.
"""

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.sequence import Sequence, Truth

ON_LIGHT = (
    *("#0099ee", "#880000", "#889977", "#553355", "#dd7711"),
    *("#5555bb", "#aa66aa", "#223399", "#bb4422", "#775577"),
)
ON_DARK = (
    *("#4488ee", "#ffaa11", "#007766", "#ddbbff", "#aa4400"),
    *("#66dd99", "#8844aa", "#99aabb", "#dd7722", "#9977aa"),
)
"""Colours for white and for dark paper; a person has the same place in both."""

LEAST_APART = 0.09
"""Least distance in Oklab between two colours of a palette, in whosever eyes."""

_TALL = 1.7  # m; how far somebody is whose place is not known, by the box
_NEAR = 4.0  # m from which on two people may be taken for one another
_FRAMES = 40  # as many moments are looked at, however long the sequence is
_ROUNDS = 6


def person_slots(camera: Camera, sequence: Sequence, truth: Truth | None) -> IntArray:
    """[K] which colour of a palette each track of a sequence has, by where it is seen."""
    boxes = sequence.observations
    places = camera.unproject(boxes, np.full(boxes.shape[:-1], _TALL))
    if truth is not None:
        known = world_to_relative(truth.positions, truth.poses)
        places = np.where(np.isnan(known), places, known)
    return colour_slots(np.where(sequence.observed[..., None], places, np.nan))


def colour_slots(positions: FloatArray, count: int = len(ON_LIGHT)) -> IntArray:
    """[K] which of ``count`` colours each person has throughout, from positions [T, K, 2] in m, NaN = absent.

    Whoever comes near most others chooses first, then everybody again, until nobody finds a better colour.
    """
    near = _nearness(positions)
    slots = np.full(near.shape[0], -1, np.int64)
    order = np.argsort(-near.sum(axis=1), kind="stable")
    for _ in range(_ROUNDS):
        before = slots.copy()
        for k in order:
            others = (np.arange(len(slots)) != k) & (slots >= 0)
            cost = np.bincount(slots[others], near[k, others], count)
            used = np.bincount(slots[others], minlength=count)
            slots[k] = np.lexsort((np.arange(count), used, cost))[0]
        if np.array_equal(before, slots):
            break
    return slots


def _nearness(positions: FloatArray) -> FloatArray:
    """[K, K] how near two people come and for how long: the sum over moments of 1 where they touch to 0 at `_NEAR`."""
    near = np.zeros((positions.shape[1],) * 2)
    for places in positions[:: max(1, len(positions) // _FRAMES)]:
        apart = np.linalg.norm(places[:, None] - places[None], axis=-1)
        near += np.clip(1.0 - np.nan_to_num(apart, nan=_NEAR) / _NEAR, 0.0, None) ** 2
    np.fill_diagonal(near, 0.0)
    return near
