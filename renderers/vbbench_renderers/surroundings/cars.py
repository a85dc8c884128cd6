"""Parked cars."""

from itertools import pairwise

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Float32, Mesh
from vbbench_renderers.surroundings.shapes import Quads, boxes, join, place, quads, smooth_mesh, tube

PAINTS = [
    (0.45, 0.46, 0.48),
    (0.10, 0.11, 0.13),
    (0.40, 0.05, 0.05),
    (0.06, 0.12, 0.27),
    (0.62, 0.62, 0.60),
    (0.20, 0.24, 0.20),
]
"""Linear RGB."""
STATIONS = np.array(
    [
        [-2.10, 0.70, 0.62],
        [-1.95, 0.80, 0.72],
        [-0.9, 0.87, 0.92],
        [1.6, 0.86, 0.95],
        [2.05, 0.80, 0.90],
        [2.12, 0.74, 0.70],
    ]
)
"""Along the lower body: x, half width and height of the shoulder, m."""
GLASS = np.array([0.035, 0.045, 0.055])
SKY = np.array([0.22, 0.28, 0.34])
"""The reflection at the upper edge of the glass."""


def car(rng: np.random.Generator) -> list[Mesh | Quads]:
    """A car 4.2 m long along x, its nose at negative x."""
    paint = np.array(PAINTS[rng.integers(len(PAINTS))])
    tall, back = rng.uniform(1.40, 1.55), rng.uniform(1.35, 1.85)
    wheels = [
        place(_wheel(), x, side * 0.89, 0.5 * np.pi * (side + 1.0), 0.32) for x in (-1.35, 1.30) for side in (-1, 1)
    ]
    return [_hull(STATIONS, paint), *_cabin(paint, tall, back), *_lights(), *wheels]


def _hull(stations: FloatArray, paint: FloatArray) -> Quads:
    """The lower body: sides in three bands, the top and both ends."""
    x, half, shoulder = stations.T
    sill, belt = np.full_like(x, 0.22), np.full_like(x, 0.48)
    rows = [(half - 0.06, sill, 0.25), (half, belt, 0.8), (half, shoulder - 0.10, 1.0),
            (half - 0.07, shoulder, 1.1)]  # fmt: skip
    faces, tints = [], []
    for (y0, z0, s0), (y1, z1, s1) in pairwise(rows):
        low, high = np.column_stack([x, -y0, z0]), np.column_stack([x, -y1, z1])
        near = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
        far = (near * [1.0, -1.0, 1.0])[:, [1, 0, 3, 2]]
        front = np.stack([low[0] * [1, -1, 1], low[0], high[0], high[0] * [1, -1, 1]])[None]
        rear = np.stack([low[-1], low[-1] * [1, -1, 1], high[-1] * [1, -1, 1], high[-1]])[None]
        group = np.concatenate([near, far, front, rear])
        faces.append(group)
        tints.append(np.broadcast_to(np.array([s0, s0, s1, s1])[None, :, None] * paint, group.shape))
    rim = np.column_stack([x, -(half - 0.07), shoulder])
    lid = np.stack([rim[:-1], rim[1:], rim[1:] * [1, -1, 1], rim[:-1] * [1, -1, 1]], axis=1)
    return join([quads(np.concatenate(faces), np.concatenate(tints)), quads(lid, paint * 1.05)])


def _cabin(paint: FloatArray, tall: float, back: float) -> list[Quads]:
    """Roof, pillars and glass."""
    low = np.array([[-0.95, -0.80, 0.90], [back, -0.80, 0.92], [back, 0.80, 0.92], [-0.95, 0.80, 0.90]])
    high = np.array(
        [[-0.25, -0.60, tall], [back - 0.45, -0.60, tall - 0.02], [back - 0.45, 0.60, tall - 0.02], [-0.25, 0.60, tall]]
    )
    walls = np.stack([np.stack([low[n], low[m], high[m], high[n]]) for n, m in ((0, 1), (1, 2), (2, 3), (3, 0))])
    middle = walls.mean(axis=1, keepdims=True)
    out = np.cross(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    panes = middle + np.array([0.90, 0.90, 0.80])[None, None] * (walls - middle) + 0.02 * out[:, None]
    tint = np.stack([GLASS, GLASS, SKY, SKY])[None]
    door = boxes([0.42, -0.90, 0.55], [0.44, -0.86, 0.88], paint * 0.3, faces=("front",))
    pillar = boxes([0.40, -0.79, 0.92], [0.48, -0.70, 0.93], paint, faces=("front",))
    return [quads(walls, paint * 0.85), quads(panes, tint), quads(high[None], paint * 1.1), door, pillar]


def _lights() -> list[Quads]:
    """Headlights, tail lights, and dark bumpers."""
    black = [0.03, 0.03, 0.03]
    parts = [
        boxes([-2.14, -0.66, 0.25], [-2.0, 0.66, 0.42], black, faces=("left", "front", "back")),
        boxes([2.0, -0.68, 0.25], [2.15, 0.68, 0.42], black, faces=("right", "front", "back")),
    ]
    for y in (-0.66, 0.40):
        parts.append(boxes([-2.14, y, 0.50], [-2.0, y + 0.26, 0.61], [0.75, 0.75, 0.72], faces=("left",)))
        parts.append(boxes([2.0, y, 0.56], [2.15, y + 0.26, 0.70], [0.40, 0.02, 0.02], faces=("right",)))
    return parts


def _wheel() -> Mesh:
    """A wheel in the plane y = 0 that is seen from −y."""
    rubber, rim = [0.018] * 3, [0.42] * 3
    shades = np.array([rim, rim, rubber, rubber, rubber])
    disc = tube([[0.0, 0.02], [0.19, 0.02], [0.21, 0.0], [0.32, 0.01], [0.32, 0.18]], shades, sides=9)
    return smooth_mesh(
        _laid(disc.vertices), _laid(disc.normals), disc.colours.astype(np.float64), disc.triangles.astype(np.int64)
    )


def _laid(vectors: Float32) -> FloatArray:
    """Turned about x so that −z becomes −y."""
    x, y, z = vectors.astype(np.float64).T
    return np.column_stack([x, z, -y])
