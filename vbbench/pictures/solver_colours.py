"""One colour per solver, the same in every picture and on every page, whatever is shown with it.

Those for white have a contrast of 3 to it (WCAG 2.2, 1.4.11). The nearest two of the bundled solvers stay
apart for readers who see no red, no green or no blue (by 0.06 of OKLab on white and 0.09 on dark paper, after Machado
et al., IEEE TVCG 15, 2009), and all from the grey of truth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from zlib import crc32

ON_LIGHT = (
    *("#6b4300", "#da66c2", "#0072b2", "#009e73", "#6592ef", "#d55e00", "#4c0787"),
    *("#6b3860", "#3ca741", "#4694b4", "#b5439f", "#f15f7a"),
)
ON_DARK = (
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
    return ON_LIGHT[solver_number(name)]


def numbers_apart(names: Sequence[str]) -> list[int]:
    """Places of different colours, as far as there are enough: of an answer whose solver's is taken, the next free."""
    found: list[int] = []
    for name in names:
        own = solver_number(name)
        order = [(own + step) % len(ON_LIGHT) for step in range(len(ON_LIGHT))]
        found.append(next((number for number in order if number not in found), own))
    return found


_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))


@dataclass(frozen=True, kw_only=True)
class Look:
    """How a solver's lines are drawn: their colour, and their dashes as matplotlib has them."""

    colour: str
    dashes: Any


def solver_looks(solvers: Sequence[str]) -> list[Look]:
    """The looks of several answers in one picture; answers that share a colour differ by dashes."""
    colours = [solver_colour(name) for name in solvers]
    return [
        Look(colour=colour, dashes=_DASHES[colours[:n].count(colour) % len(_DASHES)])
        for n, colour in enumerate(colours)
    ]
