"""The limb meshes by name and by level of detail."""

from functools import cache

from vbbench_renderers.mesh import Mesh
from vbbench_renderers.people.body import body_meshes
from vbbench_renderers.people.garments import garment_meshes
from vbbench_renderers.people.head import head_meshes

_MAKERS = body_meshes() | head_meshes() | garment_meshes()
NAMES = tuple(_MAKERS)
"""What each mesh of the library is."""


@cache
def library(level: int) -> tuple[Mesh, ...]:
    """The meshes of a level, in the order of `NAMES`."""
    return tuple(make(level) for make in _MAKERS.values())


@cache
def top_of(name: str) -> float:
    """Height in m of the highest point of a mesh in its own frame."""
    return float(library(0)[NAMES.index(name)].vertices[:, 2].max())
