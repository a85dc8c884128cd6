"""Large triangles for a panorama, divided until straight edges follow the cylinder.

A straight line that spans an azimuth θ bows from its chord by (v − cy) θ²/8 rows, whatever its distance; so edges are
halved until they span little. The test looks at nothing but the edge's ends, so that neighbours agree on every cut and
no cracks open.
"""

import numpy as np
from numpy.typing import NDArray

from vbbench.kernels import kernel
from vbbench_renderers.mesh import Float32, Int32

COLUMNS = 12
WIDEST = np.deg2rad(5.0)
"""Edges span at most this azimuth: 0.23 px at the border of a picture 480 px high."""
DEEPEST = 14
_STACK = 3 * DEEPEST + 4


@kernel
def refine(
    vertices: Float32, triangles: Int32, eye: NDArray[np.float64], yaw: float, low: float, high: float, out: Float32
) -> int:
    """Write the corners of refined triangles, the base azimuth behind each vertex, and return how many corners.

    Parameters
    ----------
    vertices : [V, 12] see `vbbench_renderers.opengl.packing.pack_vertices`.
    triangles : [F, 3].
    eye : [3] in m.
    yaw : heading in rad.
    low, high : slopes (height over range) of the picture's lower and upper border; beyond them nothing is drawn.
    out : [M, 13] filled as far as it reaches; a result beyond M asks for a longer one.
    """
    stack = np.empty((_STACK, 3, COLUMNS), np.float32)
    depth = np.empty(_STACK, np.int64)
    azimuth, right, forward = np.empty(3), np.empty(3), np.empty(3)
    cos, sin, steepest = np.cos(yaw), np.sin(yaw), np.tan(WIDEST)
    filled = int(np.int64(0))  # here and below, a constant would compile a kernel twice
    for f in range(len(triangles)):
        for c in range(3):
            stack[0, c] = vertices[triangles[f, c]]
        depth[0] = 0
        top = 1
        while top > 0:
            top -= 1
            if _outside(stack[top], eye, low, high):
                continue
            for c in range(3):
                dx, dy = stack[top, c, 0] - eye[0], stack[top, c, 1] - eye[1]
                right[c], forward[c] = dx * sin - dy * cos, dx * cos + dy * sin
            wide = int(np.int64(0))
            for c in range(3):
                d = (c + 1) % 3
                across = abs(right[c] * forward[d] - right[d] * forward[c])
                if across > steepest * (right[c] * right[d] + forward[c] * forward[d]):
                    wide |= 1 << c
            if wide and depth[top] < DEEPEST:
                top = _cut(stack, depth, top, wide)
                continue
            for c in range(3):
                azimuth[c] = np.arctan2(right[c], forward[c])
            filled = _write(stack[top], azimuth, out, filled)
    return filled


@kernel
def _outside(corners: Float32, eye: NDArray[np.float64], low: float, high: float) -> bool:
    below, above = True, True
    for c in range(3):
        reach = np.hypot(corners[c, 0] - eye[0], corners[c, 1] - eye[1])
        rise = corners[c, 2] - eye[2]
        below &= rise < low * reach
        above &= rise > high * reach
    return below or above


@kernel
def _cut(stack: Float32, depth: NDArray[np.int64], top: int, wide: int) -> int:
    """Replace the triangle at ``top`` by the two, three or four triangles that result from halving its wide edges."""
    corner = stack[top].copy()
    below = depth[top] + 1
    middle = np.empty((3, COLUMNS), np.float32)
    for c in range(3):
        middle[c] = np.float32(0.5) * (corner[c] + corner[(c + 1) % 3])
    count = (wide & 1) + (wide >> 1 & 1) + (wide >> 2 & 1)
    if count == 3:
        for c in range(3):
            top = _push(stack, depth, top, below, corner[c], middle[c], middle[(c + 2) % 3])
        return _push(stack, depth, top, below, middle[0], middle[1], middle[2])
    if count == 1:
        a = 0 if wide & 1 else 1 if wide & 2 else 2
        top = _push(stack, depth, top, below, corner[a], middle[a], corner[(a + 2) % 3])
        return _push(stack, depth, top, below, middle[a], corner[(a + 1) % 3], corner[(a + 2) % 3])
    a = 1 if not wide & 1 else 2 if not wide & 2 else 0  # edges a and a + 1 are wide
    b, c = (a + 1) % 3, (a + 2) % 3
    top = _push(stack, depth, top, below, middle[a], corner[b], middle[b])
    top = _push(stack, depth, top, below, corner[a], middle[a], middle[b])
    return _push(stack, depth, top, below, corner[a], middle[b], corner[c])


@kernel
def _push(stack: Float32, depth: NDArray[np.int64], top: int, level: int, a: Float32, b: Float32, c: Float32) -> int:
    stack[top, 0] = a
    stack[top, 1] = b
    stack[top, 2] = c
    depth[top] = level
    return top + 1


@kernel
def _write(corners: Float32, azimuth: NDArray[np.float64], out: Float32, filled: int) -> int:
    """Write one triangle; if it crosses the seam, write it again at the other border."""
    base = azimuth[0]
    least, most = base, base
    for c in range(1, 3):
        turn = azimuth[c] - base
        turn -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        least, most = min(least, base + turn), max(most, base + turn)
    copies = 2 if least < -np.pi or most > np.pi else 1
    for copy in range(copies):
        shift = 0.0 if copy == 0 else (2.0 * np.pi if least < -np.pi else -2.0 * np.pi)
        for c in range(3):
            if filled < len(out):
                out[filled, :COLUMNS] = corners[c]
                out[filled, COLUMNS] = base + shift
            filled += 1
    return filled
