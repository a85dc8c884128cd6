"""What is drawn: triangle meshes, the limbs of people that place them, and what does not move.

World and limb frames are right-handed, z up, metres. A limb is a mesh of a library, placed by a transform and dyed by
its own colours; a person is some twenty of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import BoolArray, IntArray

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
PLAIN = -1
"""The texture layer of vertices without a texture."""
CHUNK = 256
"""The largest number of triangles in one piece of the surroundings."""
_VERTEX_ARRAYS = ("vertices", "normals", "colours", "uv", "layers")


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A triangle mesh; triangles are counter-clockwise seen from outside.

    Parameters
    ----------
    vertices, normals : [V, 3] in m, and of length 1.
    colours : [V, 3] linear RGB in 0 … 1; multiplied with the texture where there is one.
    uv : [V, 2] texture coordinates; 1 is the width of a layer, and layers repeat.
    layers : [V] texture layer, `PLAIN` for none; the same at the three corners of a triangle.
    triangles : [F, 3] vertex indices.
    """

    vertices: Float32
    normals: Float32
    colours: Float32
    uv: Float32
    layers: Int32
    triangles: Int32

    def piece(self, rows: IntArray) -> "Mesh":
        """The mesh of some of the triangles."""
        used, triangles = np.unique(self.triangles[rows], return_inverse=True)
        arrays = {name: getattr(self, name)[used] for name in _VERTEX_ARRAYS}
        return Mesh(**arrays, triangles=triangles.reshape(-1, 3).astype(np.int32))


def join_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh of several."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    arrays = {name: np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in _VERTEX_ARRAYS}
    return Mesh(**arrays, triangles=np.concatenate(triangles).astype(np.int32))


def split_mesh(mesh: Mesh) -> list[Mesh]:
    """The mesh in pieces of neighbouring triangles, so that pieces out of view can be skipped together."""
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    return [mesh.piece(rows) for rows in _halves(centres, np.arange(len(centres)))]


def _halves(centres: Float32, rows: IntArray) -> list[IntArray]:
    """Rows halved along their longer side until few are left."""
    if len(rows) <= CHUNK:
        return [rows]
    axis = int(np.ptp(centres[rows], axis=0).argmax())
    ordered = rows[np.argsort(centres[rows, axis], kind="stable")]
    middle = len(rows) // 2
    return _halves(centres, ordered[:middle]) + _halves(centres, ordered[middle:])


class Pattern(IntEnum):
    """Where a limb shows its second colour, by the point (x, y, z) of the limb's own frame; see ``meshes.hpp``."""

    PLAIN = 0
    RINGS = 1
    CHECKS = 2


@dataclass(frozen=True, kw_only=True)
class Limbs:
    """The limbs of all people who are drawn in a frame, one row per limb, ordered by person.

    Parameters
    ----------
    mesh : [N] index in the library.
    transform : [N, 3, 4] from the limb's frame to the world: x_world = A x_limb + b; A may scale and shear.
    colour, second_colour : [N, 3] linear RGB in 0 … 1, multiplied with the mesh's own colours.
    pattern : [N] `Pattern`.
    gloss : [N] strength of the highlight, 0 … 1.
    person : [N] column of the person in the scene.
    """

    mesh: Int32
    transform: Float32
    colour: Float32
    second_colour: Float32
    pattern: Int32
    gloss: Float32
    person: Int32

    def of(self, rows: BoolArray | IntArray) -> "Limbs":
        """Some of the limbs."""
        return Limbs(**{name: values[rows] for name, values in vars(self).items()})


@dataclass(frozen=True, kw_only=True)
class Sky:
    """Light and air, linear RGB.

    Parameters
    ----------
    sun_direction : [3] unit vector towards the sun.
    sun_colour : [3] irradiance of a surface that faces the sun.
    zenith, horizon : [3] colours of the sky; in between they mix by the square root of the sine of the elevation.
    ground_glow : [3] light from below, from the ground.
    haze_distance : m at which the air has taken 63 % of the contrast.
    """

    sun_direction: Float32
    sun_colour: Float32
    zenith: Float32
    horizon: Float32
    ground_glow: Float32
    haze_distance: float


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """Everything that does not move.

    Parameters
    ----------
    mesh : ground, houses, trees and lamps as one mesh.
    textures : [L, S, S, 3] uint8 sRGB layers, which repeat.
    sky : light and air.
    """

    mesh: Mesh
    textures: NDArray[np.uint8]
    sky: Sky


def srgb_to_linear(values: Float32) -> Float32:
    """Linear values of sRGB values in 0 … 1 (IEC 61966-2-1)."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(np.float32)


def linear_to_srgb(values: Float32) -> Float32:
    """The inverse of `srgb_to_linear`."""
    curve = 1.055 * np.maximum(values, 0.0) ** (1 / 2.4) - 0.055
    return np.where(values <= 0.0031308, 12.92 * values, curve).astype(np.float32)
