"""Colours that distinguish people, and solvers: few enough to stay different for colour-blind eyes.

People's were found by exchange: no two of a palette come closer than `LEAST_APART` in Oklab (Ottosson 2020), for eyes
that see all colours and for those without red, green or blue cones (Machado, Oliveira and Fernandes 2009), and each has
a contrast of 3 to its paper. People who come near one another have different ones, as far as there are enough.

A solver has one colour, the same in every picture and on every page, whatever is shown with it. Those for white have a
contrast of 3 to it (WCAG 2.2, 1.4.11). The nearest two of the bundled solvers stay apart for readers who see no red, no
green or no blue (by 0.06 of OKLab on white and 0.09 on dark paper), and all from the grey of truth.
"""

from collections.abc import Sequence as Several
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.sequence import Sequence, Truth

PEOPLE_ON_LIGHT = (
    *("#0099ee", "#880000", "#889977", "#553355", "#dd7711"),
    *("#5555bb", "#aa66aa", "#223399", "#bb4422", "#775577"),
)
PEOPLE_ON_DARK = (
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


def colour_slots(positions: FloatArray, count: int = len(PEOPLE_ON_LIGHT)) -> IntArray:
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


SOLVERS_ON_LIGHT = (
    *("#6b4300", "#da66c2", "#0072b2", "#009e73", "#6592ef", "#d55e00", "#4c0787"),
    *("#6b3860", "#3ca741", "#4694b4", "#b5439f", "#f15f7a"),
)
SOLVERS_ON_DARK = (
    *("#a8692c", "#f4cdf4", "#4b9df5", "#55e6a0", "#6460ea", "#ffa03c", "#8a6ab8"),
    *("#d83a80", "#74cc3a", "#58c4e0", "#d080f0", "#f8b0b8"),
)
"""Colours for white and for dark paper: the first are those of `_BUNDLED`."""

_BUNDLED = ("cv", "sf", "vb-cv", "vb-sf", "vb-sf-literal", "map-causal", "map-batch")
_LATER = {"vb-former": 7, "ground-plane": 10}
_SHARED = (8, 9, 11)
"""Places of colours: of bundled solvers, in order and by name, and of all others."""


def solver_number(name: str) -> int:
    """The place of a solver's colour in a palette: its own if it is bundled, else one that follows from its name."""
    if name in _BUNDLED:
        return _BUNDLED.index(name)
    return _LATER.get(name, _SHARED[crc32(name.encode()) % len(_SHARED)])


def solver_colour(name: str) -> str:
    """The colour of a solver on white, as ``#rrggbb``."""
    return SOLVERS_ON_LIGHT[solver_number(name)]


def numbers_apart(names: Several[str]) -> list[int]:
    """Places of different colours, as far as there are enough: of an answer whose solver's is taken, the next free."""
    found: list[int] = []
    for name in names:
        own = solver_number(name)
        order = [(own + step) % len(SOLVERS_ON_LIGHT) for step in range(len(SOLVERS_ON_LIGHT))]
        found.append(next((number for number in order if number not in found), own))
    return found


_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))


@dataclass(frozen=True, kw_only=True)
class Look:
    """How a solver's lines are drawn: their colour, and their dashes as matplotlib has them."""

    colour: str
    dashes: Any


def solver_looks(solvers: Several[str]) -> list[Look]:
    """The looks of several answers in one picture; answers that share a colour differ by dashes."""
    colours = [solver_colour(name) for name in solvers]
    return [
        Look(colour=colour, dashes=_DASHES[colours[:n].count(colour) % len(_DASHES)])
        for n, colour in enumerate(colours)
    ]
