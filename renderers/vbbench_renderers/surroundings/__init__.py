"""Surroundings: ground, houses, trees, lamps and sky around the place where people walk."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_renderers.meshes import Sky, Surroundings, join_meshes
from vbbench_renderers.surroundings.objects import house_mesh, lamp, tree
from vbbench_renderers.surroundings.shapes import place, turned
from vbbench_renderers.surroundings.site import FAR_PAVEMENT, PAVEMENT, ROADWAY, TO_PARK, Area, Site, ground_mesh, plan
from vbbench_renderers.surroundings.textures import textures

MOST = 7
"""The largest number of trees or lamps along one side."""


class Spot(NamedTuple):
    """The place of a tree of that scale, or of a lamp if its size is 0, in m."""

    u: float
    v: float
    size: float = 0.0


def _stations(low: float, high: float, gap: float, rng: np.random.Generator) -> FloatArray:
    """Places along a line, about `gap` apart, at most `MOST`."""
    count = int(np.clip((high - low) / gap, 1, MOST))
    width = (high - low) / count
    return np.asarray(low + width * (np.arange(count) + rng.uniform(0.35, 0.65, count)))


def _side(site: Site, side: int, rng: np.random.Generator) -> list[Spot]:
    """Lamps along one of the long sides, with an avenue of trees if it is wide enough."""
    sign = 1.0 - 2.0 * side
    stations = _stations(-site.long - 3.0, site.long + 3.0, 9.5, rng)
    spots = [Spot(u + 3.0, sign * (site.wide + 2.7)) for u in stations[::2]]
    if site.setbacks[side] > 7.0:
        spots += [Spot(u, sign * (site.wide + 4.9), rng.uniform(0.85, 1.1)) for u in stations]
    return spots


def _street(site: Site, rng: np.random.Generator) -> list[Spot]:
    """The crossing street: lamps and trees behind it and along the street that goes on."""
    kerb, spots = site.long + PAVEMENT, list[Spot]()
    for v in _stations(-site.wide - 14.0, site.wide + 14.0, 11.0, rng):
        if not site.gap[0] - 2.0 < v < site.gap[1] + 2.0:
            spots.append(Spot(kerb + ROADWAY + 1.3, v, rng.uniform(0.75, 0.95) * (rng.random() < 0.6)))
    for away in (22.0, 34.0, 46.0):
        u = kerb + ROADWAY + FAR_PAVEMENT + away + rng.uniform(-2.0, 2.0)
        spots += [Spot(u, v, rng.uniform(0.8, 1.0)) for v in (site.gap[0] + 1.4, site.gap[1] - 1.4)]
    return spots


def _park(site: Site, rng: np.random.Generator) -> list[Spot]:
    """The park: lamps along its edge, and trees behind them."""
    edge = -site.long - TO_PARK
    spots = [Spot(edge + 0.5, v) for v in _stations(-site.wide - 2.0, site.wide + 2.0, 15.0, rng)]
    for n in range(MOST):
        v = (n + rng.uniform(0.2, 0.8)) / MOST * 2.0 - 1.0
        away = rng.uniform(4.0, 12.0) if n % 2 else rng.uniform(14.0, 42.0)
        spots.append(Spot(edge - away, v * (site.wide + 5.0 + 0.3 * away), rng.uniform(0.9, 1.35)))
    return spots


LEAST_SIDE = 4.0
"""A walking area is at least this long and wide, m."""
MARGIN = 1.0
"""Of a walking area around everybody's positions, m."""


def walking_area(scene: Scene) -> Area:
    """Bounds of all positions of a scene, `MARGIN` wider on every side and at least `LEAST_SIDE` long and wide."""
    seen = scene.positions[scene.present]
    low, high = (seen.min(axis=0), seen.max(axis=0)) if len(seen) else (np.zeros(2), np.zeros(2))
    middle = 0.5 * (low + high)
    half = np.maximum(0.5 * (high - low) + MARGIN, 0.5 * LEAST_SIDE)
    return (*(middle - half).tolist(), *(middle + half).tolist())


def surroundings_of(scene: Scene, seed: int, *, plain: bool) -> Surroundings:
    """The surroundings of the people of a scene; ``plain`` for only ground and sky."""
    area = walking_area(scene)
    return plain_surroundings(area) if plain else build_surroundings(area, seed)


def plain_surroundings(area: Area) -> Surroundings:
    """Ground and sky only."""
    return build_surroundings(area, 0, bare=True)


@lru_cache(maxsize=8)
def build_surroundings(area: Area, seed: int, *, bare: bool = False) -> Surroundings:
    """Ground around a walking area and, if it is not ``bare``, houses, trees and lamps.

    It is the same for the same area and seed.
    """
    streams = [np.random.default_rng(s) for s in np.random.SeedSequence([2111, seed]).spawn(4)]
    sides = np.array([area[2] - area[0], area[3] - area[1]])
    long, wide = 0.5 * float(sides.max()), 0.5 * float(sides.min())
    turn = (0.5 * np.pi if sides[1] > sides[0] else 0.0) + np.pi * float(streams[0].integers(2))
    site = plan(long, wide, streams[0])
    if bare:
        site = Site(long=long, wide=wide, sun=site.sun, gap=site.gap)
    parts = [ground_mesh(site, streams[1])]
    if not bare:
        rng = streams[3]
        spots = [*_side(site, 0, rng), *_side(site, 1, rng), *_street(site, rng), *_park(site, rng)]
        parts += [house_mesh(plot, streams[2]) for plot in site.plots]
        for u, v, size in spots:
            parts.append(place(tree(size, site.distance(u, v), rng) if size else lamp(rng), u, v))
    middle = (0.5 * (area[0] + area[2]), 0.5 * (area[1] + area[3]))
    sun = turned(site.sun, turn)
    return Surroundings(mesh=place(join_meshes(parts), *middle, turn), textures=textures(), sky=late_morning(sun))


def late_morning(sun: FloatArray) -> Sky:
    """A fine day; `sun` [3] points towards the sun."""
    return Sky(
        sun_direction=np.asarray(sun, dtype=np.float32),
        sun_colour=np.array([1.35, 1.20, 0.97], np.float32),
        zenith=np.array([0.13, 0.28, 0.60], np.float32),
        horizon=np.array([0.60, 0.71, 0.84], np.float32),
        ground_glow=np.array([0.24, 0.22, 0.19], np.float32),
        haze_distance=400.0,
    )
