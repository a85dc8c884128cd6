"""Triangles with everything that is needed to shade them. World and limb frames are right-handed, z up, metres."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
PLAIN = -1
"""The texture layer of vertices without a texture."""


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


def join_meshes(meshes: list[Mesh]) -> Mesh:
    """One mesh of several."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])[:-1]
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    joined = {
        name: np.concatenate([getattr(mesh, name) for mesh in meshes])
        for name in ("vertices", "normals", "colours", "uv", "layers")
    }
    return Mesh(**joined, triangles=np.concatenate(triangles).astype(np.int32))
