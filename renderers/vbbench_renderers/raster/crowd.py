"""The people of a frame in one table, with every level of detail in one library."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Protocol

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.drawing import Limbs
from vbbench_renderers.mesh import Mesh


class People(Protocol):
    """Who is drawn: `vbbench_renderers.people.Walkers`."""

    @property
    def levels(self) -> int:
        """Number of levels of detail."""

    def library(self, level: int) -> tuple[Mesh, ...]:
        """Limb meshes of a level; an index means the same limb at every level."""

    def limbs(
        self, frame: int, eye: FloatArray, focal: float, *, without: int | None = None
    ) -> Sequence[tuple[int, Limbs]]:
        """Limbs of a frame by level, as a camera at ``eye`` [2] sees them, except the person in column ``without``."""


def joined_library(people: People) -> list[Mesh]:
    """Limb meshes of all levels, level after level."""
    return [mesh for level in range(people.levels) for mesh in people.library(level)]


def joined_limbs(people: People, frame: int, eye: FloatArray, focal: float, without: int | None = None) -> Limbs:
    """Limbs of a frame in one table, ordered by person, with meshes counted in `joined_library`."""
    count = len(people.library(0))
    found = [
        replace(limbs, mesh=limbs.mesh + level * count)
        for level, limbs in people.limbs(frame, eye, focal, without=without)
    ]
    if not found:
        return no_limbs()
    order = np.argsort(np.concatenate([limbs.person for limbs in found]), kind="stable")
    return Limbs(
        **{
            field.name: np.concatenate([getattr(limbs, field.name) for limbs in found])[order]
            for field in fields(Limbs)
        }
    )


def no_limbs() -> Limbs:
    """Nobody."""
    colour, number = np.empty((0, 3), np.float32), np.empty(0, np.int32)
    return Limbs(
        mesh=number,
        transform=np.empty((0, 3, 4), np.float32),
        colour=colour,
        second_colour=colour,
        pattern=number,
        gloss=np.empty(0, np.float32),
        person=number,
    )
