"""How the lines of several answers are drawn in one picture: each solver's colour, and dashes where two share one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from vbbench.pictures.solver_colours import solver_colour

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
