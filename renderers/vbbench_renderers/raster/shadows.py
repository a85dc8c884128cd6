"""Shadow maps along the sun, and how much light reaches the ground under feet.

A map is a grid on the ground. A point is entered where the sun's ray through it meets the ground, with its height;
a texel keeps the greatest height, and what lies deeper on the same ray is in the shade.
"""

from typing import NamedTuple

import numpy as np
from numba import prange

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel, parallel_kernel
from vbbench_renderers.drawing import FOOT_HEIGHT, Limbs
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.parts import Parts

NOTHING = -1e9
"""Height in a map where nothing blocks the sun."""
BAND = 32
"""Rows of a map that one thread draws at a time."""


class ShadowMap(NamedTuple):
    """Heights along the sun's rays.

    Parameters
    ----------
    heights : [S, S] in m; row is y, column is x.
    open : [S, S] share of the sky that the ground sees, 0 … 1.
    x, y : the ground point at the outer corner of texel (0, 0), in m.
    scale : texels a metre.
    slope_x, slope_y : ground metres a metre of height, away from the sun.
    """

    heights: Float32
    open: Float32
    x: float
    y: float
    scale: float
    slope_x: float
    slope_y: float


def draw_map(
    parts: Parts, limbs: Limbs, mesh: Int32, sun: FloatArray, centre: FloatArray, half: float, texels: int
) -> ShadowMap:
    """The map of some limbs around a ground point.

    Parameters
    ----------
    parts : meshes.
    limbs : what throws shadows.
    mesh : [N] which meshes throw the limbs' shadows: coarse ones will do.
    sun : [3] towards the sun.
    centre : [2] middle of the map; taken to whole texels, so that shadows do not crawl.
    half : half the width of the map in m.
    texels : S.
    """
    scale = texels / (2.0 * half)
    x, y = np.round(np.asarray(centre) * scale) / scale - half
    shear = np.array([[1.0, 0.0, -sun[0] / sun[2]], [0.0, 1.0, -sun[1] / sun[2]], [0.0, 0.0, 1.0]])
    joined = np.matmul(shear, limbs.transform.astype(np.float64))
    joined[:, 0, 3] -= x
    joined[:, 1, 3] -= y
    joined[:, :2] *= scale
    counts = np.diff(parts.first_vertex)[mesh]
    points = np.empty((int(counts.sum()), 3), np.float32)
    heights, bounds = np.full((texels, texels), NOTHING, np.float32), np.empty((len(mesh), 4))
    _cast(parts, mesh, joined, np.cumsum(counts) - counts, points, bounds, heights)
    openness = np.ones((texels // 4, texels // 4), np.float32)
    return ShadowMap(heights, openness, float(x), float(y), scale, float(shear[0, 2]), float(shear[1, 2]))


def darken_contacts(shadows: ShadowMap, limbs: Limbs) -> None:
    """Spots in ``shadows.open``: one under each foot, a wide one under each body."""
    if len(limbs.person):
        centres = limbs.transform[:, :, 3]
        feet = centres[centres[:, 2] < FOOT_HEIGHT]
        starts = np.flatnonzero(np.diff(limbs.person, prepend=-1))
        bodies = np.add.reduceat(centres, starts) / np.diff(starts, append=len(centres))[:, None]
        near = np.column_stack((feet[:, :2], np.full(len(feet), 0.22), 0.55 - feet[:, 2]))
        wide = np.column_stack((bodies[:, :2], np.full(len(bodies), 0.6), np.full(len(bodies), 0.45)))
        _stain(np.concatenate([near, wide]), shadows.x, shadows.y, shadows.scale / 4, shadows.open)


@kernel
def _stain(spots: FloatArray, x: float, y: float, scale: float, openness: Float32) -> None:
    size = len(openness)
    for spot in range(len(spots)):
        u, v, radius = (spots[spot, 0] - x) * scale, (spots[spot, 1] - y) * scale, spots[spot, 2] * scale
        for row in range(int(max(0.0, v - radius)), int(min(size - 1.0, v + radius)) + 1):
            for column in range(int(max(0.0, u - radius)), int(min(size - 1.0, u + radius)) + 1):
                fall = max(0.0, 1.0 - ((column + 0.5 - u) ** 2 + (row + 0.5 - v) ** 2) / radius**2)
                openness[row, column] *= 1.0 - spots[spot, 3] * fall * fall


@parallel_kernel
def _cast(
    parts: Parts,
    mesh: Int32,
    joined: FloatArray,
    first: IntArray,
    points: Float32,
    bounds: FloatArray,
    heights: Float32,
) -> None:
    for limb in prange(len(mesh)):
        number = int(np.int64(limb))  # numba counts in uint64 here
        _cast_points(parts, mesh[limb], joined, first, points, bounds, number)
    size = len(heights)
    for band in prange((size + BAND - 1) // BAND):
        begin, end = band * BAND, min(size, (band + 1) * BAND)
        for limb in range(len(mesh)):
            if bounds[limb, 0] < end and bounds[limb, 1] > begin and bounds[limb, 2] < size and bounds[limb, 3] > 0.0:
                shift = first[limb] - parts.first_vertex[mesh[limb]]
                for row in range(parts.first_triangle[mesh[limb]], parts.first_triangle[mesh[limb] + 1]):
                    _cast_face(parts.triangles, row, shift, points, begin, end, heights)


@kernel
def _cast_points(
    parts: Parts, part: int, joined: FloatArray, first: IntArray, points: Float32, bounds: FloatArray, limb: int
) -> None:
    """Texel columns, rows and heights of a limb's vertices, and the rows and columns between which they lie."""
    low_y, high_y, low_x, high_x = np.inf, -np.inf, np.inf, -np.inf
    point = first[limb]
    for vertex in range(parts.first_vertex[part], parts.first_vertex[part + 1]):
        x, y, z = parts.vertices[vertex, 0], parts.vertices[vertex, 1], parts.vertices[vertex, 2]
        for row in range(3):
            points[point, row] = (
                joined[limb, row, 0] * x + joined[limb, row, 1] * y + joined[limb, row, 2] * z + joined[limb, row, 3]
            )
        low_x, high_x = min(low_x, points[point, 0]), max(high_x, points[point, 0])
        low_y, high_y = min(low_y, points[point, 1]), max(high_y, points[point, 1])
        point += 1
    bounds[limb, 0], bounds[limb, 1], bounds[limb, 2], bounds[limb, 3] = low_y, high_y, low_x, high_x


@kernel
def _cast_face(triangles: Int32, row: int, shift: int, points: Float32, begin: int, end: int, heights: Float32) -> None:
    """Enter a triangle, facing either way, at the centres of the texels that it covers."""
    a, b, c = triangles[row, 0] + shift, triangles[row, 1] + shift, triangles[row, 2] + shift
    ax, ay = points[a, 0], points[a, 1]
    bx, by, cx, cy = points[b, 0] - ax, points[b, 1] - ay, points[c, 0] - ax, points[c, 1] - ay
    area = bx * cy - by * cx
    top = max(begin, int(np.ceil(max(ay + min(0.0, by, cy), -1.0) - 0.5)))
    bottom = min(end - 1, int(np.floor(min(ay + max(0.0, by, cy), 1e6) - 0.5)))
    if area == 0.0 or top > bottom:
        return
    first = max(0, int(np.ceil(max(ax + min(0.0, bx, cx), -1.0) - 0.5)))
    last = min(len(heights) - 1, int(np.floor(min(ax + max(0.0, bx, cx), 1e6) - 0.5)))
    rise_b, rise_c = (points[b, 2] - points[a, 2]) / area, (points[c, 2] - points[a, 2]) / area
    sign = 1.0 if area > 0.0 else -1.0
    for v in range(top, bottom + 1):
        y = v + 0.5 - ay
        for u in range(first, last + 1):
            x = u + 0.5 - ax
            share_b, share_c = x * cy - y * cx, y * bx - x * by
            if share_b * sign >= 0.0 and share_c * sign >= 0.0 and (area - share_b - share_c) * sign >= 0.0:
                height = points[a, 2] + share_b * rise_b + share_c * rise_c
                heights[v, u] = max(heights[v, u], height)


@kernel
def sun_share(heights: Float32, u: float, v: float, height: float) -> float:
    """Share of the sun at texel coordinates (u, v) and a height in m, between the nearest 2 x 2 texels; 1 outside."""
    x, y = u - 0.5, v - 0.5
    if not (0.0 <= x < len(heights) - 1.0 and 0.0 <= y < len(heights) - 1.0):
        return 1.0
    column, row = int(x), int(y)
    fx, fy = x - column, y - row
    lit = 0.0
    if heights[row, column] <= height:
        lit += (1.0 - fx) * (1.0 - fy)
    if heights[row, column + 1] <= height:
        lit += fx * (1.0 - fy)
    if heights[row + 1, column] <= height:
        lit += (1.0 - fx) * fy
    if heights[row + 1, column + 1] <= height:
        lit += fx * fy
    return lit


@kernel
def smooth_value(values: Float32, u: float, v: float) -> float:
    """``values`` at texel coordinates (u, v), bilinear; 1 outside."""
    x, y = u - 0.5, v - 0.5
    if not (0.0 <= x < len(values) - 1.0 and 0.0 <= y < len(values) - 1.0):
        return 1.0
    column, row = int(x), int(y)
    fx, fy = x - column, y - row
    upper = (1.0 - fx) * values[row, column] + fx * values[row, column + 1]
    lower = (1.0 - fx) * values[row + 1, column] + fx * values[row + 1, column + 1]
    return float((1.0 - fy) * upper + fy * lower)
