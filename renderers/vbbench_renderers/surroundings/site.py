"""The place of everything by seed, and the ground under it: paving, roadways between kerb stones, a park.

The site has its own frame: the walking area is centred, u runs along its longer side and v across.
Rows of houses line the long sides; a street crosses beyond the end at positive u and a park lies beyond the other.
"""

from dataclasses import dataclass, replace

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_renderers.meshes import Mesh, join_meshes
from vbbench_renderers.surroundings.shapes import smooth_mesh
from vbbench_renderers.surroundings.textures import TILE, Layer

Area = tuple[float, float, float, float]
"""Lowest x and y, highest x and y, in m."""
PAVEMENT, ROADWAY, FAR_PAVEMENT = 5.0, 7.0, 4.0
"""From the walking area to the crossing street, its width, and the way on to the houses behind it, in m."""
TO_PARK = 3.0
"""From the walking area to the park, m."""


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A house, seen from the front: from (u, v), its front left corner, `width` to the right and `depth` away.

    Lengths in m, yaw in rad about the corner; `distance` is that from the walking area.
    """

    u: float
    v: float
    yaw: float
    width: float
    depth: float
    height: float
    distance: float


@dataclass(frozen=True, kw_only=True)
class Site:
    """The plan of the houses, m.

    Parameters
    ----------
    long, wide : half the sides of the walking area.
    sun : [3] towards the sun.
    gap : lowest and highest v of the street that goes on at positive u.
    setbacks : from the walking area to the houses on its left, v > 0, and on its right.
    plots : the houses.
    """

    long: float
    wide: float
    sun: FloatArray
    gap: tuple[float, float] = (0.0, 0.0)
    setbacks: tuple[float, float] = (0.0, 0.0)
    plots: tuple[Plot, ...] = ()

    def distance(self, u: float, v: float) -> float:
        """From the walking area to a point, m."""
        return float(np.hypot(max(abs(u) - self.long, 0.0), max(abs(v) - self.wide, 0.0)))


def plan(long: float, wide: float, rng: np.random.Generator) -> Site:
    """The plan around a walking area of half sides `long` and `wide`, m."""
    azimuth = rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(22.0, 38.0))
    elevation = np.radians(rng.uniform(40.0, 47.0))
    level = np.cos(elevation)
    sun = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    open_at = rng.uniform(-0.5, 0.5) * wide
    site = Site(long=long, wide=wide, sun=sun, gap=(open_at - 7.0, open_at + 7.0))
    setbacks = rng.permutation([rng.uniform(4.6, 5.6), rng.uniform(8.0, 9.5)])
    plots = [*_sides(site, setbacks, rng), *_opposite(site, rng), *_skyline(site, rng)]
    return replace(site, setbacks=(float(setbacks[0]), float(setbacks[1])), plots=tuple(plots))


def _sides(site: Site, setbacks: FloatArray, rng: np.random.Generator) -> list[Plot]:
    """Rows of houses along both long sides, one near and one behind trees."""
    left, right = -site.long - 28.0, site.long + PAVEMENT - 2.0
    north = _row(site, rng, (left, site.wide + setbacks[0]), 0.0, right - left)
    south = _row(site, rng, (right, -site.wide - setbacks[1]), np.pi, right - left)
    return north + south


def _opposite(site: Site, rng: np.random.Generator) -> list[Plot]:
    """Houses across the street, and the street that goes on between them."""
    front = site.long + PAVEMENT + ROADWAY + FAR_PAVEMENT
    low, high = site.gap
    reach = site.wide + 45.0
    near = _row(site, rng, (front, reach), -np.pi / 2.0, reach - high) + _row(
        site, rng, (front, low), -np.pi / 2.0, low + reach
    )
    return near + _row(site, rng, (front + 13.0, high), 0.0, 60.0) + _row(site, rng, (front + 73.0, low), np.pi, 60.0)


def _skyline(site: Site, rng: np.random.Generator) -> list[Plot]:
    """Houses far away, all around."""
    plots = []
    for yaw, reach, across in (
        (0.0, site.wide + 75.0, site.long + 70.0),
        (np.pi, site.wide + 75.0, site.long + 70.0),
        (-np.pi / 2.0, site.long + 120.0, site.wide + 90.0),
        (np.pi / 2.0, site.long + 62.0, site.wide + 90.0),
    ):
        along = np.array([np.cos(yaw), np.sin(yaw)])
        start = reach * np.array([-along[1], along[0]]) - across * along
        plots += _row(site, rng, (float(start[0]), float(start[1])), yaw, 2.0 * across, scale=1.8)
    return plots


def _row(
    site: Site, rng: np.random.Generator, start: tuple[float, float], yaw: float, length: float, scale: float = 1.0
) -> list[Plot]:
    """Houses side by side, from the left as seen from the front, with an alley here and there."""
    plots: list[Plot] = []
    done = 0.0
    along = np.array([np.cos(yaw), np.sin(yaw)])
    away = np.array([-along[1], along[0]])
    while length - done > 5.0:
        width = min(rng.uniform(8.0, 15.0) * scale, length - done)
        height = scale * (3.9 + 3.2 * rng.integers(2, 5)) * rng.uniform(0.95, 1.05)
        corner = np.array(start) + done * along + rng.uniform(0.0, 0.6) * away
        depth = 10.0 * scale
        ends = corner[:, None] + np.outer(along, np.linspace(0.0, width, 5))
        near = min(site.distance(float(u), float(v)) for u, v in ends.T)
        plots.append(
            Plot(
                u=float(corner[0]), v=float(corner[1]), yaw=yaw, width=width, depth=depth, height=height, distance=near
            )
        )
        done += width + (rng.uniform(2.5, 4.5) if rng.random() < 0.2 else 0.0)
    return plots


FAR = 250.0
"""How far the ground reaches beyond the walking area, m."""
WIDEN = 0.8
"""Width of a cell over its distance from the walking area."""
CELLS = 650
"""The approximate number of cells of the walking area, unless they would be smaller than half a metre."""
SHOULDER = 2.0
"""Cells are finest up to here from the walking area, m."""


def ground_mesh(site: Site, rng: np.random.Generator) -> Mesh:
    """The ground around and under the walking area."""
    cell = max(0.5, 2.0 * np.sqrt(site.long * site.wide / CELLS))
    street, (low, high) = site.long + PAVEMENT, site.gap
    ends = [street - 0.3, street, street + ROADWAY, street + ROADWAY + 0.3, street + ROADWAY + FAR_PAVEMENT]
    us = _lines(site.long, cell, [*ends, -site.long - TO_PARK])
    vs = _lines(site.wide, cell, [low + 2.5, low + 2.8, high - 2.8, high - 2.5])
    corner_u, corner_v = np.meshgrid(us, vs, indexing="ij")
    middle = np.stack(np.meshgrid(0.5 * (us[1:] + us[:-1]), 0.5 * (vs[1:] + vs[:-1]), indexing="ij"), axis=2)
    layers = surface(site, middle[..., 0], middle[..., 1])
    points = np.stack([corner_u, corner_v], axis=2)
    tint = _tone(points.reshape(-1, 2), rng).reshape(*points.shape[:2], 3)
    return join_meshes([_part(points, tint, layers == layer, Layer(layer)) for layer in np.unique(layers)])


def _lines(half: float, cell: float, breaks: list[float]) -> FloatArray:
    inner = half + SHOULDER
    outer = [inner]
    while outer[-1] < half + FAR:
        outer.append(outer[-1] + max(cell, WIDEN * (outer[-1] - half)))
    middle = np.linspace(-inner, inner, int(np.ceil(2.0 * inner / cell)) + 1)
    lines = np.concatenate([-np.array(outer[:0:-1]), middle, np.array(outer[1:])])
    for line in breaks:
        nearest = np.argsort(np.abs(lines - line))[:2]
        step = abs(float(lines[nearest[0]] - lines[nearest[1]]))
        lines = lines[np.abs(lines - line) > 0.3 * step]
        lines = np.sort(np.append(lines, [other for other in breaks if other not in lines]))
    return np.unique(lines)


def surface(site: Site, u: FloatArray, v: FloatArray) -> IntArray:
    """Layer of the ground at cell centres."""
    street, end = site.long + PAVEMENT, site.long + PAVEMENT + ROADWAY
    low, high = site.gap[0] + 2.5, site.gap[1] - 2.5
    layers = np.full(u.shape, int(Layer.PAVING))
    du, dv = np.abs(u) - site.long, np.abs(v) - site.wide
    layers[np.maximum(du, dv) > 35.0] = Layer.ASPHALT
    layers[u < -site.long - TO_PARK] = Layer.GRASS
    onward = (u > end) & (v > low) & (v < high)
    kerb = ((u > street - 0.3) & (u < end + 0.3)) | ((u > end) & (v > low - 0.3) & (v < high + 0.3))
    layers[kerb] = Layer.ASHLAR
    layers[((u > street) & (u < end)) | onward] = Layer.ASPHALT
    return layers


def _tone(points: FloatArray, rng: np.random.Generator) -> FloatArray:
    """[N, 3] factors of the texture at ground points [N, 2]: patches hide its repetition."""
    angles = rng.uniform(0.0, 2.0 * np.pi, 6)
    waves = rng.uniform(0.1, 0.7, (6, 1)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    patches = np.sin(points @ waves.T + rng.uniform(0.0, 2.0 * np.pi, 6))
    light = 0.92 + 0.022 * patches.sum(axis=1, keepdims=True)
    hue = 1.0 + 0.010 * patches[:, :3].sum(axis=1, keepdims=True) * np.array([1.0, 0.2, -1.0])
    return np.asarray(light * hue)


def _part(points: FloatArray, tint: FloatArray, cells: BoolArray, layer: Layer) -> Mesh:
    """The cells of one layer as a mesh of shared vertices."""
    rows, columns = np.nonzero(cells)
    width = points.shape[1]
    first = rows * width + columns
    corners = first[:, None, None] + np.array([[0, width, width + 1], [0, width + 1, 1]])
    used, triangles = np.unique(corners.reshape(-1, 3), return_inverse=True)
    flat = points.reshape(-1, 2)[used]
    return smooth_mesh(
        np.column_stack([flat, np.zeros(len(flat))]),
        np.broadcast_to([0.0, 0.0, 1.0], (len(flat), 3)),
        tint.reshape(-1, 3)[used],
        triangles.reshape(-1, 3),
        uv=flat / TILE[layer],
        layer=layer,
    )
