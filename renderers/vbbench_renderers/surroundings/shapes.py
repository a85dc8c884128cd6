"""Round things as meshes, and how anything is moved to its place."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray, IntArray
from vbbench_renderers.mesh import PLAIN, Mesh


def place(mesh: Mesh, x: float, y: float, yaw: float = 0.0, z: float = 0.0) -> Mesh:
    """The mesh turned about z by `yaw`, rad, and moved."""
    vertices = turned(mesh.vertices, yaw) + np.array([x, y, z])
    return replace(mesh, vertices=vertices.astype(np.float32), normals=turned(mesh.normals, yaw).astype(np.float32))


def turned(vectors: ArrayLike, yaw: float) -> FloatArray:
    """Vectors [..., 3] turned about z, rad."""
    cosine, sine = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(np.asarray(vectors, dtype=np.float64) @ turn.T)


def tube(profile: ArrayLike, colours: ArrayLike, *, sides: int = 8, layer: int = PLAIN, tile: float = 1.0) -> Mesh:
    """A surface of revolution about z.

    Parameters
    ----------
    profile : [P, 2] radius and height, m, going up on the outside.
    colours : broadcast to [P, 3].
    sides : number of facets around, shaded smoothly.
    layer, tile : texture layer and its width, m.
    """
    radius, height = np.asarray(profile, dtype=np.float64).T
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rise, widen = np.gradient(height), np.gradient(radius)
    normals = np.concatenate(
        [rise[:, None, None] * around, np.broadcast_to(-widen[:, None, None], (len(radius), sides + 1, 1))], axis=2
    )
    vertices = np.concatenate(
        [radius[:, None, None] * around, np.broadcast_to(height[:, None, None], (len(radius), sides + 1, 1))], axis=2
    )
    uv = np.stack(np.broadcast_arrays(angle * max(radius.max(), 0.05), height[:, None]), axis=2) / tile
    tints = np.broadcast_to(np.atleast_2d(np.asarray(colours, dtype=np.float64)), (len(radius), 3))
    return smooth_mesh(
        vertices, normals, np.repeat(tints, sides + 1, axis=0), lattice(len(radius), sides + 1), uv=uv, layer=layer
    )


def smooth_mesh(
    vertices: FloatArray,
    normals: FloatArray,
    colours: FloatArray,
    triangles: IntArray,
    *,
    uv: FloatArray | None = None,
    layer: int = PLAIN,
) -> Mesh:
    """A mesh of one layer; normals need not have length 1."""
    flat = vertices.reshape(-1, 3)
    directions = normals.reshape(-1, 3)
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    return Mesh(
        vertices=flat.astype(np.float32),
        normals=(directions / np.maximum(lengths, 1e-12)).astype(np.float32),
        colours=np.clip(colours, 0.0, 1.0).reshape(-1, 3).astype(np.float32),
        uv=np.zeros((len(flat), 2), np.float32) if uv is None else uv.reshape(-1, 2).astype(np.float32),
        layers=np.full(len(flat), layer, np.int32),
        triangles=triangles.astype(np.int32),
    )


def lattice(rows: int, columns: int) -> IntArray:
    """[F, 3] triangles of a lattice of vertices; counter-clockwise where columns go right and rows up."""
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    cell = np.array([[0, 1, columns + 1], [0, columns + 1, columns]])
    return np.asarray((first[:, None, None] + cell).reshape(-1, 3))


@lru_cache(maxsize=4)
def icosphere(subdivisions: int) -> tuple[FloatArray, IntArray]:
    """Vertices [V, 3] and triangles [F, 3] of a sphere of radius 1."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    return np.asarray(ball.vertices, dtype=np.float64), np.asarray(ball.faces, dtype=np.int64)
