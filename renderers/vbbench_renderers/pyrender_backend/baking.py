"""Limbs baked into one mesh per person: one node per limb would cost pyrender ten times the draw calls."""

import math
from typing import NamedTuple

import numpy as np

from vbbench.geometry import IntArray
from vbbench.kernels import kernel
from vbbench_renderers.drawing import Limbs
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.raster.shading import Looks, dye_of, looks_of


class Baked(NamedTuple):
    """The vertices of all limbs in the world, limb after limb.

    Parameters
    ----------
    points, normals, colours : [P, 3]; linear RGB.
    triangles : [F, 3] rows of ``points``.
    first_point, first_triangle : [N + 1] where each limb starts.
    """

    points: Float32
    normals: Float32
    colours: Float32
    triangles: Int32
    first_point: IntArray
    first_triangle: IntArray


def bake(parts: Parts, limbs: Limbs) -> Baked:
    """The limbs' vertices in the world, dyed vertex by vertex."""
    points, triangles = np.diff(parts.first_vertex)[limbs.mesh], np.diff(parts.first_triangle)[limbs.mesh]
    first_point, first_triangle = np.append(0, np.cumsum(points)), np.append(0, np.cumsum(triangles))
    total = int(first_point[-1])
    placed, normals, colours = (np.empty((total, 3), np.float32) for _ in range(3))
    baked = Baked(
        placed, normals, colours, np.empty((int(first_triangle[-1]), 3), np.int32), first_point, first_triangle
    )
    _bake(parts, limbs.mesh, limbs.transform, looks_of(limbs), baked)
    return baked


@kernel
def _bake(parts: Parts, mesh: Int32, transform: Float32, looks: Looks, baked: Baked) -> None:
    for limb in range(len(mesh)):
        first = baked.first_point[limb] - parts.first_vertex[mesh[limb]]
        for vertex in range(parts.first_vertex[mesh[limb]], parts.first_vertex[mesh[limb] + 1]):
            _bake_vertex(parts, transform, looks, limb, vertex, first + vertex, baked)
        begin = parts.first_triangle[mesh[limb]]
        for row in range(parts.first_triangle[mesh[limb] + 1] - begin):
            for corner in range(3):
                baked.triangles[baked.first_triangle[limb] + row, corner] = parts.triangles[begin + row, corner] + first


@kernel
def _bake_vertex(
    parts: Parts, transform: Float32, looks: Looks, limb: int, vertex: int, point: int, baked: Baked
) -> None:
    dye = dye_of(looks, limb, parts.vertices, vertex, vertex, vertex, 1.0, 0.0, 0.0)
    length = 0.0
    for row in range(3):
        place, normal = transform[limb, row, 3], 0.0
        for axis in range(3):
            place += transform[limb, row, axis] * parts.vertices[vertex, axis]
            normal += looks.normal[limb, row, axis] * parts.normals[vertex, axis]
        baked.points[point, row], baked.normals[point, row] = place, normal
        baked.colours[point, row] = dye[row] * parts.colours[vertex, row]
        length += normal * normal
    for row in range(3):
        baked.normals[point, row] /= math.sqrt(length) + 1e-20
