"""The z-buffer: which triangle is seen through each pixel, and how far away it is.

A triangle with corners a, b, c in eye coordinates is met by the ray d where d·(b×c), d·(c×a) and d·(a×b) are not
negative; its inverse depth there is their sum over a·(b×c) (Olano and Greer 1997, "Triangle scan conversion using 2D
homogeneous coordinates"). Nothing has to be clipped, and the same test serves both cameras. In one column it leaves
an interval of rows. Neighbours share their edges to the last bit: no pixel between them is missed or drawn twice.
"""

import math

import numpy as np
from numba import prange

from vbbench.kernels import kernel, parallel_kernel
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.raster.placing import Placed
from vbbench_renderers.rays import NEAR, Rays

STRIP = 32
"""Columns that one thread draws at a time; the picture does not depend on it."""
MARGIN = 1e-2
"""Columns (px) by which bounds are widened because of rounding."""


@parallel_kernel
def fill(
    parts: Parts, mesh: Int32, order: Int32, placed: Placed, rays: Rays, nearness: Float32, limbs: Int32, faces: Int32
) -> None:
    """Draw limbs.

    Parameters
    ----------
    parts, mesh, placed : the limbs, see `place`.
    order : [N] the order in which they are drawn; fastest when near ones come first.
    rays : of the camera.
    nearness : [W, H] 1 / depth; 0 where nothing is seen.
    limbs : [W, H] limb; N where nothing is seen.
    faces : [W, H] triangle within its mesh; written where something is seen.
    """
    width = len(rays.side)
    for strip in prange((width + STRIP - 1) // STRIP):
        begin, end = strip * STRIP, min(width, (strip + 1) * STRIP)
        nearness[begin:end] = 0.0
        limbs[begin:end] = len(mesh)
        for limb in order:
            if reaches(placed.low[limb], placed.high[limb], begin, end, width, rays.closed):
                _fill_limb(parts, mesh[limb], limb, placed, rays, begin, end, nearness, limbs, faces)


@kernel
def reaches(low: float, high: float, begin: int, end: int, width: int, closed: bool) -> bool:
    """Whether columns low … high touch begin … end."""
    if low > high:
        return False
    if low <= end and high >= begin:
        return True
    return closed and ((low - width <= end and high - width >= begin) or (low + width <= end and high + width >= begin))


@kernel
def _fill_limb(
    parts: Parts,
    part: int,
    limb: int,
    placed: Placed,
    rays: Rays,
    begin: int,
    end: int,
    nearness: Float32,
    limbs: Int32,
    faces: Int32,
) -> None:
    width = len(rays.side)
    side = placed.side[limb]
    shift = placed.first[limb] - parts.first_vertex[part]
    for row in range(parts.first_triangle[part], parts.first_triangle[part + 1]):
        a, b, c = parts.triangles[row, 0] + shift, parts.triangles[row, 1] + shift, parts.triangles[row, 2] + shift
        low, high = face_columns(placed.points, placed.columns, a, b, c, rays)
        if low > high:
            continue
        first, last = int(max(np.ceil(low - 0.5 - MARGIN), begin)), int(min(np.floor(high - 0.5 + MARGIN), end - 1))
        face = row - parts.first_triangle[part]
        if rays.closed:
            for turn in (-width, width):
                left = int(max(np.ceil(low - 0.5 - MARGIN) + turn, begin))
                right = int(min(np.floor(high - 0.5 + MARGIN) + turn, end - 1))
                if left <= right:
                    _fill_face(placed.points, a, b, c, side, rays, left, right, limb, face, nearness, limbs, faces)
        if first <= last:
            _fill_face(placed.points, a, b, c, side, rays, first, last, limb, face, nearness, limbs, faces)


@kernel
def face_columns(points: Float32, columns: Float32, a: int, b: int, c: int, rays: Rays) -> tuple[float, float]:
    """The columns (px) between which a triangle lies; low > high if it is behind the camera."""
    if rays.closed:
        return _columns_round(columns[a], columns[b], columns[c], len(rays.side))
    if points[a, 2] >= NEAR and points[b, 2] >= NEAR and points[c, 2] >= NEAR:
        return min(columns[a], columns[b], columns[c]), max(columns[a], columns[b], columns[c])
    low, high = np.inf, -np.inf
    for start, stop in ((a, b), (b, c), (c, a)):
        if points[start, 2] >= NEAR:
            low, high = min(low, columns[start]), max(high, columns[start])
        if (points[start, 2] >= NEAR) != (points[stop, 2] >= NEAR):
            share = (NEAR - points[start, 2]) / (points[stop, 2] - points[start, 2])
            side = points[start, 0] + share * (points[stop, 0] - points[start, 0])
            column = rays.centre + rays.across * side / NEAR
            low, high = min(low, column), max(high, column)
    return low, high


@kernel
def _columns_round(a: float, b: float, c: float, width: int) -> tuple[float, float]:
    """The same in a closed picture, where an edge takes the shorter way around."""
    to_b = b - a - width * math.floor((b - a) / width + 0.5)
    to_c = c - a - width * math.floor((c - a) / width + 0.5)
    across = c - b - width * math.floor((c - b) / width + 0.5)
    if abs(to_b + across - to_c) > 0.5 * width:  # the triangle lies under or over the camera
        return 0.0, float(width)
    return a + min(0.0, to_b, to_c), a + max(0.0, to_b, to_c)


Triple = tuple[float, float, float]
Edges = tuple[Triple, Triple, Triple]
Plane = tuple[float, float, float, float]


@kernel
def cross(points: Float32, a: int, b: int) -> Triple:
    """The normal of the plane through the eye and two points, in float64; for (b, a) its exact negative."""
    ax, ay, az = np.float64(points[a, 0]), np.float64(points[a, 1]), np.float64(points[a, 2])
    bx, by, bz = np.float64(points[b, 0]), np.float64(points[b, 1]), np.float64(points[b, 2])
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel
def _fill_face(
    points: Float32,
    a: int,
    b: int,
    c: int,
    side: int,
    rays: Rays,
    first: int,
    last: int,
    limb: int,
    face: int,
    nearness: Float32,
    limbs: Int32,
    faces: Int32,
) -> None:
    seen, edges, scales, plane = plane_of(points, a, b, c, side, rays.focal)
    if not seen:
        return
    for column in range(first, last + 1):
        top, bottom, level, fall = rows_of(edges, scales, plane, rays, column)
        if top < bottom:
            for row in range(int(top), int(bottom)):
                near = np.float32(level + fall * row)
                if near > nearness[column, row] and near <= 1.0 / NEAR:
                    nearness[column, row] = near
                    limbs[column, row] = limb
                    faces[column, row] = face


@kernel
def plane_of(points: Float32, a: int, b: int, c: int, side: int, focal: float) -> tuple[bool, Edges, Triple, Plane]:
    """Whether a triangle shows its ``side`` (0: either), the normals of its edges with focal / up of each, its plane.

    The plane is (across, ahead, volume, fall): on the horizon 1 / depth of the ray (x, z) is
    (across·x + ahead·z) / volume, and each row further down adds ``fall``.
    """
    e0, e1, e2 = cross(points, b, c), cross(points, c, a), cross(points, a, b)
    volume = points[a, 0] * e0[0] + points[a, 1] * e0[1] + points[a, 2] * e0[2]
    seen = volume * side >= 0.0 and volume != 0.0
    if volume < 0.0:
        e0, e1, e2, volume = (-e0[0], -e0[1], -e0[2]), (-e1[0], -e1[1], -e1[2]), (-e2[0], -e2[1], -e2[2]), -volume
    across, up, ahead = e0[0] + e1[0] + e2[0], e0[1] + e1[1] + e2[1], e0[2] + e1[2] + e2[2]
    scales = focal / e0[1], focal / e1[1], focal / e2[1]
    return seen, (e0, e1, e2), scales, (across, ahead, volume, -up / (focal * volume))


@kernel
def rows_of(edges: Edges, scales: Triple, plane: Plane, rays: Rays, column: int) -> tuple[float, float, float, float]:
    """Rows top … bottom − 1 of a triangle in a column, and 1 / depth: its value in row 0 and what each row adds."""
    x, z = rays.side[column], rays.ahead[column]
    (e0, e1, e2), (s0, s1, s2), (across, ahead, volume, fall) = edges, scales, plane
    top, bottom = 0.0, float(rays.height)
    top, bottom = _trim(e0[0] * x + e0[2] * z, e0[1], s0, rays.horizon, top, bottom)
    top, bottom = _trim(e1[0] * x + e1[2] * z, e1[1], s1, rays.horizon, top, bottom)
    top, bottom = _trim(e2[0] * x + e2[2] * z, e2[1], s2, rays.horizon, top, bottom)
    return top, bottom, (across * x + ahead * z) / volume - fall * rays.horizon, fall


@kernel
def _trim(value: float, up: float, scale: float, horizon: float, top: float, bottom: float) -> tuple[float, float]:
    """Rows top … bottom − 1 cut to those on the inner side of an edge, in one column.

    Parameters
    ----------
    value : the edge function at the horizon.
    up : the vertical part of the edge's normal.
    scale : focal / up.
    horizon : row of the horizon.
    top, bottom : rows so far.
    """
    if up < 0.0:
        return max(top, np.ceil(value * scale + horizon)), bottom
    if up > 0.0:
        return top, min(bottom, np.ceil(value * scale + horizon))
    return top, (bottom if value >= 0.0 else top)
