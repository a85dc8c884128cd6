"""Limbs brought into eye coordinates, with the columns that they may cover."""

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel, parallel_kernel
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.rays import NEAR, Rays


class Placed(NamedTuple):
    """The parts of N limbs that are in front of the camera.

    Parameters
    ----------
    points : [P, 3] vertices in eye coordinates, limb after limb.
    columns : [P] their columns in the picture, in px; anything where they are not in front of the camera.
    first : [N] first point of each limb.
    low, high : [N] the columns that a limb may cover; low > high for a limb out of sight.
        In a closed picture they may leave [0, W).
    side : [N] the side of the triangles that is drawn: 1, −1 where they are clockwise, 0 for both.
    """

    points: Float32
    columns: Float32
    first: IntArray
    low: FloatArray
    high: FloatArray
    side: Int32


def place(parts: Parts, mesh: Int32, transform: Float32, both: BoolArray, eye: FloatArray, rays: Rays) -> Placed:
    """Limbs in eye coordinates.

    Parameters
    ----------
    parts : meshes.
    mesh : [N] which of them.
    transform : [N, 3, 4] from the limb's frame to the world.
    both : [N] whether triangles are drawn from behind, too.
    eye : [3, 4] from the world to eye coordinates.
    rays : of the camera.
    """
    joined = np.matmul(eye[:, :3], transform.astype(np.float64))
    joined[:, :, 3] += eye[:, 3]
    counts = np.diff(parts.first_vertex)[mesh]
    first = np.cumsum(counts) - counts
    total = int(counts.sum())
    placed = Placed(
        np.empty((total, 3), np.float32),
        np.empty(total, np.float32),
        first,
        np.empty(len(mesh)),
        np.empty(len(mesh)),
        np.where(both, 0, -np.sign(np.linalg.det(joined[:, :, :3]))).astype(np.int32),  # the eye's are left-handed
    )
    _place(parts, mesh, joined, rays, placed)
    return placed


@parallel_kernel
def _place(parts: Parts, mesh: Int32, joined: FloatArray, rays: Rays, placed: Placed) -> None:
    for limb in prange(len(mesh)):
        number = int(np.int64(limb))  # numba counts in uint64 here
        _place_limb(parts, mesh[limb], joined[limb], rays, placed, number)


@kernel
def _place_limb(parts: Parts, part: int, joined: FloatArray, rays: Rays, placed: Placed, limb: int) -> None:
    low, high = 1.0, 0.0
    if _in_sight(parts.spheres[part], joined, rays):
        begin, end = parts.first_vertex[part], parts.first_vertex[part + 1]
        first = placed.first[limb]
        points = placed.points[first : first + end - begin]
        columns = placed.columns[first : first + end - begin]
        _move(parts.vertices[begin:end], joined, points)
        if rays.closed:
            low, high = _columns_around(points, columns, len(rays.side))
        else:
            low, high = _columns_ahead(points, columns, rays)
    placed.low[limb], placed.high[limb] = low, high


@kernel
def _in_sight(sphere: Float32, joined: FloatArray, rays: Rays) -> bool:
    """Whether the sphere around a mesh touches the space between the planes of the picture's left and right border."""
    if rays.closed:
        return True
    centre = joined[:, 3].copy()
    stretch = 0.0
    for row in range(3):
        for axis in range(3):
            centre[row] += joined[row, axis] * sphere[axis]
            stretch += joined[row, axis] ** 2
    radius = sphere[3] * math.sqrt(stretch)
    right, left = len(rays.side) - rays.centre, rays.centre
    if centre[2] + radius < NEAR:
        return False
    if rays.across * centre[0] + left * centre[2] < -radius * math.hypot(rays.across, left):
        return False
    return bool(right * centre[2] - rays.across * centre[0] >= -radius * math.hypot(rays.across, right))


@kernel
def _move(vertices: Float32, joined: FloatArray, points: Float32) -> None:
    for vertex in range(len(vertices)):
        x, y, z = vertices[vertex, 0], vertices[vertex, 1], vertices[vertex, 2]
        for row in range(3):
            points[vertex, row] = joined[row, 0] * x + joined[row, 1] * y + joined[row, 2] * z + joined[row, 3]


@kernel
def _columns_ahead(points: Float32, columns: Float32, rays: Rays) -> tuple[float, float]:
    """Columns in a perspective picture; a limb that reaches behind the camera may cover all of them."""
    low, high, behind = np.inf, -np.inf, False
    for point in range(len(points)):
        if points[point, 2] < NEAR:
            behind = True
        else:
            columns[point] = rays.centre + rays.across * (points[point, 0] / points[point, 2])
            low, high = min(low, columns[point]), max(high, columns[point])
    if behind and low <= high:
        return 0.0, float(len(rays.side))
    return low, high


@kernel
def _columns_around(points: Float32, columns: Float32, width: int) -> tuple[float, float]:
    """Columns in a closed picture; a limb that may reach around the camera covers all of them."""
    start, low, high = 0.0, 0.0, 0.0
    for point in range(len(points)):
        column = (math.atan2(points[point, 0], points[point, 2]) / (2.0 * math.pi) + 0.5) * width
        columns[point] = column
        if point == 0:
            start = column
        offset = column - start - width * math.floor((column - start) / width + 0.5)
        low, high = min(low, offset), max(high, offset)
    if high - low > 0.45 * width:
        return 0.0, float(width)
    return start + low, start + high
