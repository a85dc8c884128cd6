"""Lofting: closed surfaces through a stack of superelliptic cross-sections."""

from collections.abc import Callable

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import PLAIN, Mesh

LEVELS = 3
"""Levels of detail, the finest first."""
ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""Lays a loft along x: its axis becomes x, its front becomes up."""

FLAT = 0.011
"""Caps up to this height in m are plain cones."""
Section = tuple[float, float, float, float, float]
Detail = tuple[tuple[int, int], tuple[int, int], tuple[int, int]]
Paint = Callable[[FloatArray], FloatArray]


def loft(
    sections: list[Section],
    grid: tuple[int, int],
    *,
    caps: tuple[float, float] = (0.02, 0.02),
    power: float = 2.2,
    ripple: float = 0.0,
) -> trimesh.Trimesh:
    """A closed surface along z; monotone cubic interpolation between the sections.

    Parameters
    ----------
    sections : rows (z, centre x, front, back, half-width) in m, z strictly monotone upwards.
    grid : vertices around, and rings along; the first vertex is at the left, so that the width is exact.
    caps : height in m of the rounded bottom and top.
    power : exponent of the superellipse; 2 is an ellipse, 4 nearly a box.
    ripple : relative depth of folds in the cloth.
    """
    sides, rings = grid
    table = np.array(sections)
    steps = PchipInterpolator(np.arange(len(table)), table)(np.linspace(0.0, len(table) - 1.0, rings))
    if rings > 3:
        steps = _with_caps(steps, caps)
    around = np.pi / 2 + 2.0 * np.pi * np.arange(sides) / sides
    ring = np.stack([_power(np.cos(around), 2.0 / power), _power(np.sin(around), 2.0 / power)], axis=-1)
    ring[np.abs(ring) < 1e-9] = 0.0
    fade = np.sin(np.pi * np.linspace(0.0, 1.0, len(steps)))[:, None]
    folds = 1.0 + ripple * fade * np.sin(2.0 * around + 90.0 * steps[:, :1]) * np.sin(
        3.0 * around - 55.0 * steps[:, :1]
    )
    depth = np.where(ring[:, 0] > 0, steps[:, 2:3], steps[:, 3:4])
    points = np.stack(
        [steps[:, 1:2] + folds * depth * ring[:, 0], folds * steps[:, 4:5] * ring[:, 1], steps[:, :1] + 0.0 * depth],
        axis=-1,
    )
    ends = steps[[0, -1], :][:, [1, 1, 0]] * (1.0, 0.0, 1.0) + np.outer([-caps[0], caps[1]], (0.0, 0.0, 1.0))
    return close_grid(points, ends[0], ends[1])


def close_grid(points: FloatArray, bottom: FloatArray, top: FloatArray) -> trimesh.Trimesh:
    """A closed surface of rings [R, S, 3] (counter-clockwise seen from the top) and a pole [3] at either end."""
    rings, sides = points.shape[:2]
    index = np.arange(rings * sides).reshape(rings, sides)
    right = np.roll(index, -1, axis=1)
    lower, upper = (index[:-1], right[:-1]), (index[1:], right[1:])
    walls = [np.stack([lower[0], lower[1], upper[1]], -1), np.stack([lower[0], upper[1], upper[0]], -1)]
    south, north = rings * sides, rings * sides + 1
    floor = np.stack([right[0], index[0], np.full(sides, south)], -1)
    roof = np.stack([index[-1], right[-1], np.full(sides, north)], -1)
    faces = np.concatenate([part.reshape(-1, 3) for part in (*walls, floor, roof)])
    vertices = np.concatenate([points.reshape(-1, 3), bottom[None], top[None]])
    return trimesh.Trimesh(vertices, faces, process=False)


def finish(*solids: trimesh.Trimesh, paint: Paint | None = None) -> Mesh:
    """The solids as one limb mesh with smooth normals, painted by a function of the vertices [V, 3] → [V, 3]."""
    vertices = np.concatenate([solid.vertices for solid in solids])
    normals = np.concatenate([solid.vertex_normals for solid in solids])
    starts = np.cumsum([0, *(len(solid.vertices) for solid in solids)])
    faces = np.concatenate([solid.faces + start for solid, start in zip(solids, starts, strict=False)])
    colours = np.ones_like(vertices) if paint is None else paint(vertices)
    return Mesh(
        vertices=vertices.astype(np.float32),
        normals=normals.astype(np.float32),
        colours=colours.astype(np.float32),
        uv=np.zeros((len(vertices), 2), dtype=np.float32),
        layers=np.full(len(vertices), PLAIN, dtype=np.int32),
        triangles=faces.astype(np.int32),
    )


def turned(solid: trimesh.Trimesh, rotation: FloatArray, shift: tuple[float, float, float]) -> trimesh.Trimesh:
    """The solid turned by a rotation [3, 3] and then shifted by m."""
    return trimesh.Trimesh(solid.vertices @ rotation.T + shift, solid.faces, process=False)


def _with_caps(steps: FloatArray, caps: tuple[float, float]) -> FloatArray:
    """Adds a ring at each end that is not flat, so that it is round."""
    bottom, top = steps[:1].copy(), steps[-1:].copy()
    bottom[:, 0], top[:, 0] = bottom[:, 0] - 0.68 * caps[0], top[:, 0] + 0.68 * caps[1]
    bottom[:, 2:], top[:, 2:] = 0.74 * bottom[:, 2:], 0.74 * top[:, 2:]
    return np.concatenate([*([bottom] if caps[0] > FLAT else []), steps, *([top] if caps[1] > FLAT else [])])


def _power(values: FloatArray, exponent: float) -> FloatArray:
    return np.asarray(np.sign(values) * np.abs(values) ** exponent)
