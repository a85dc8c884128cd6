"""The elements of streets: round objects, quadrilaterals and boxes as meshes, and how they are moved to their place.

Objects are built in their own frame (x to the right and y away as seen from the front, z up) and then placed.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.toml_text import bundled_table
from vbbench_renderers.meshes import PLAIN, Mesh

STREET: dict[str, Any] = bundled_table(__package__, "street.toml")


def one_of(colours: list[list[float]], rng: np.random.Generator) -> FloatArray:
    """One of the colours."""
    return np.array(colours[rng.integers(len(colours))])


def place(mesh: Mesh, x: float, y: float, yaw: float = 0.0) -> Mesh:
    """The mesh turned about z by `yaw`, rad, and moved."""
    vertices = turned(mesh.vertices, yaw) + np.array([x, y, 0.0])
    return replace(mesh, vertices=vertices.astype(np.float32), normals=turned(mesh.normals, yaw).astype(np.float32))


def turned(vectors: ArrayLike, yaw: float) -> FloatArray:
    """Vectors [..., 3] turned about z, rad."""
    cosine, sine = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(np.asarray(vectors, dtype=np.float64) @ turn.T)


def tube(profile: ArrayLike, colours: ArrayLike, *, sides: int = 8) -> Mesh:
    """A surface of revolution about z.

    Parameters
    ----------
    profile : [P, 2] radius and height, m, going up on the outside.
    colours : broadcast to [P, 3].
    sides : number of facets around, shaded smoothly.
    """
    radius, height = np.asarray(profile, dtype=np.float64).T
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides + 1)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    vertices = radius[:, None, None] * around + height[:, None, None] * up
    normals = np.gradient(height)[:, None, None] * around - np.gradient(radius)[:, None, None] * up
    tints = np.broadcast_to(np.atleast_2d(np.asarray(colours, dtype=np.float64)), (len(radius), 3))
    first = (np.arange(len(radius) - 1)[:, None] * (sides + 1) + np.arange(sides)).reshape(-1, 1, 1)
    triangles = first + np.array([[0, 1, sides + 2], [0, sides + 2, sides + 1]])
    return smooth_mesh(vertices, normals, np.repeat(tints, sides + 1, axis=0), triangles)


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
        triangles=triangles.reshape(-1, 3).astype(np.int32),
    )


@lru_cache(maxsize=4)
def icosphere(subdivisions: int) -> tuple[FloatArray, IntArray]:
    """Vertices [V, 3] and triangles [F, 3] of a sphere of radius 1."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    return np.asarray(ball.vertices, dtype=np.float64), np.asarray(ball.faces, dtype=np.int64)


FACES = {
    "left": (2, 0, 4, 6),
    "right": (1, 3, 7, 5),
    "front": (0, 1, 5, 4),
    "back": (3, 2, 6, 7),
    "bottom": (2, 3, 1, 0),
    "top": (4, 5, 7, 6),
}
"""Corners of the faces of a box, counter-clockwise seen from outside; bit 0 of a corner is x, bit 1 y, bit 2 z."""
SEEN = ("left", "right", "front", "back", "top")
"""The faces of an object that stands on the ground."""


def quads(
    corners: ArrayLike, colours: ArrayLike, *, layer: int = PLAIN, uv: ArrayLike | None = None, tile: float = 1.0
) -> Mesh:
    """Quadrilaterals of one layer with flat shading, by default with the texture projected along the main axis.

    Parameters
    ----------
    corners : [N, 4, 3] in m, counter-clockwise seen from outside.
    colours : linear RGB, broadcast to [N, 4, 3].
    layer : texture layer.
    uv : [N, 4, 2]; by default two of the coordinates over `tile`.
    tile : width of a texture layer, m.
    """
    points = np.asarray(corners, dtype=np.float64).reshape(-1, 4, 3)
    normals = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    if uv is None:
        kept = np.array([[1, 2], [0, 2], [0, 1]])[np.argmax(np.abs(normals), axis=1)]
        uv = np.take_along_axis(points, kept[:, None, :].repeat(4, axis=1), axis=2) / tile
    return smooth_mesh(
        points,
        np.repeat(normals, 4, axis=0),
        np.broadcast_to(np.asarray(colours, dtype=np.float64), points.shape),
        4 * np.arange(len(points))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]]),
        uv=np.broadcast_to(np.asarray(uv, dtype=np.float64), (*points.shape[:2], 2)),
        layer=layer,
    )


def points(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> FloatArray:
    """[N, 3] points of coordinates [N] or of numbers that are the same for all."""
    return np.column_stack(np.broadcast_arrays(*(np.atleast_1d(np.asarray(one, np.float64)) for one in (x, y, z))))


def boxes(
    low: ArrayLike,
    high: ArrayLike,
    colours: ArrayLike,
    *,
    layer: int = PLAIN,
    tile: float = 1.0,
    faces: Sequence[str] = SEEN,
    foot: float = 1.0,
) -> Mesh:
    """Upright boxes between the corners low and high, [N, 3] or [3]; `foot` darkens the lower edge of the sides."""
    ends = np.stack(np.broadcast_arrays(np.atleast_2d(low), np.atleast_2d(high)), axis=1).astype(np.float64)
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    corners = ends[:, bits, np.arange(3)][:, [FACES[face] for face in faces]]
    shades = np.where(np.asarray([FACES[face] for face in faces])[..., None] < 4, foot, 1.0)
    tints = np.broadcast_to(np.asarray(colours, dtype=np.float64), (len(ends), 3))[:, None, None, :] * shades
    return quads(corners.reshape(-1, 4, 3), tints.reshape(-1, 4, 3), layer=layer, tile=tile)
