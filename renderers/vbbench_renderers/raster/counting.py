"""How many pixels each person would cover if nobody and nothing else were there."""

import numpy as np
from numba import prange

from vbbench.geometry import IntArray
from vbbench.kernels import kernel, parallel_kernel
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.filling import MARGIN, STRIP, cross, face_columns, reaches, trim
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.raster.placing import Placed
from vbbench_renderers.raster.rays import NEAR, Rays

ALL, INSIDE, ON_BORDER = range(3)
"""Columns of the counts: pixels, those inside the window, those on its border."""


def count_alone(
    parts: Parts, mesh: Int32, person: Int32, people: int, placed: Placed, rays: Rays, window: Int32
) -> IntArray:
    """[K, 3] pixels that each person covers alone.

    Parameters
    ----------
    parts, mesh, placed : limbs, see `vbbench_renderers.raster.placing.place`.
    person : [N] ascending, 0 … K − 1.
    people : K.
    rays : of the camera.
    window : [4] first column and row, and last column and row, of the part of the picture that counts as inside.
    """
    strips = (len(rays.side) + STRIP - 1) // STRIP
    counts = np.zeros((strips, people, 3), np.int64)
    _count(parts, mesh, person, placed, rays, window, counts)
    return np.asarray(counts.sum(axis=0))


@parallel_kernel
def _count(
    parts: Parts, mesh: Int32, person: Int32, placed: Placed, rays: Rays, window: Int32, counts: IntArray
) -> None:
    width = len(rays.side)
    for strip in prange((width + STRIP - 1) // STRIP):
        begin, end = strip * STRIP, min(width, (strip + 1) * STRIP)
        stamps = np.full((end - begin, rays.height), -1, np.int32)
        for limb in range(len(mesh)):
            if reaches(placed.low[limb], placed.high[limb], begin, end, width, rays.closed):
                _count_limb(
                    parts, mesh[limb], limb, person[limb], placed, rays, begin, end, window, stamps, counts[strip]
                )


@kernel
def _count_limb(
    parts: Parts,
    part: int,
    limb: int,
    person: int,
    placed: Placed,
    rays: Rays,
    begin: int,
    end: int,
    window: Int32,
    stamps: Int32,
    counts: IntArray,
) -> None:
    width, points = len(rays.side), placed.points
    shift = placed.first[limb] - parts.first_vertex[part]
    turns = (-width, 0, width) if rays.closed else (0, width, width)
    for row in range(parts.first_triangle[part], parts.first_triangle[part + 1]):
        a, b, c = parts.triangles[row, 0] + shift, parts.triangles[row, 1] + shift, parts.triangles[row, 2] + shift
        low, high = face_columns(points, placed.columns, a, b, c, rays)
        if low <= high:
            for turn in turns:
                first = int(max(np.ceil(low - 0.5 - MARGIN) + turn, begin))
                last = int(min(np.floor(high - 0.5 + MARGIN) + turn, end - 1))
                if first <= last:
                    _count_face(
                        points, a, b, c, placed.side[limb], rays, first, last, begin, person, window, stamps, counts
                    )


@kernel
def _count_face(
    points: Float32,
    a: int,
    b: int,
    c: int,
    side: int,
    rays: Rays,
    first: int,
    last: int,
    begin: int,
    person: int,
    window: Int32,
    stamps: Int32,
    counts: IntArray,
) -> None:
    """Count the pixels of a triangle on which the person was not counted before; see `filling`."""
    e0, e1, e2 = cross(points, b, c), cross(points, c, a), cross(points, a, b)
    volume = points[a, 0] * e0[0] + points[a, 1] * e0[1] + points[a, 2] * e0[2]
    if volume * side <= 0.0:
        return
    if volume < 0.0:
        e0, e1, e2, volume = (-e0[0], -e0[1], -e0[2]), (-e1[0], -e1[1], -e1[2]), (-e2[0], -e2[1], -e2[2]), -volume
    s0, s1, s2 = rays.focal / e0[1], rays.focal / e1[1], rays.focal / e2[1]
    across, up, ahead = e0[0] + e1[0] + e2[0], e0[1] + e1[1] + e2[1], e0[2] + e1[2] + e2[2]
    fall = -up / (rays.focal * volume)
    for column in range(first, last + 1):
        x, z = rays.side[column], rays.ahead[column]
        top, bottom = 0.0, float(rays.height)
        top, bottom = trim(e0[0] * x + e0[2] * z, e0[1], s0, rays.horizon, top, bottom)
        top, bottom = trim(e1[0] * x + e1[2] * z, e1[1], s1, rays.horizon, top, bottom)
        top, bottom = trim(e2[0] * x + e2[2] * z, e2[1], s2, rays.horizon, top, bottom)
        if top < bottom:
            level = (across * x + ahead * z) / volume - fall * rays.horizon
            aside = column < window[0] or column > window[2]
            border = column == window[0] or column == window[2]
            for row in range(int(top), int(bottom)):
                if stamps[column - begin, row] != person and level + fall * row <= 1.0 / NEAR:
                    stamps[column - begin, row] = person
                    counts[person, ALL] += 1
                    if not aside and window[1] <= row <= window[3]:
                        counts[person, INSIDE] += 1
                        counts[person, ON_BORDER] += border or row == window[1] or row == window[3]
