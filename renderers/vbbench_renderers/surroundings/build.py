"""Assembles the surroundings of a walking area."""

from functools import lru_cache

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_renderers.meshes import Sky, Surroundings, join_meshes
from vbbench_renderers.surroundings.ground import ground_mesh, ground_tone
from vbbench_renderers.surroundings.houses import house_meshes
from vbbench_renderers.surroundings.layers import textures
from vbbench_renderers.surroundings.layout import Area, Site, plan
from vbbench_renderers.surroundings.outfit import outfit
from vbbench_renderers.surroundings.shapes import place, turned

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


@lru_cache(maxsize=4)
def build_surroundings(area: Area, seed: int) -> Surroundings:
    """Ground, houses, trees and furniture around a walking area; the same for the same area and seed."""
    return _surroundings(area, seed, bare=False)


@lru_cache(maxsize=4)
def plain_surroundings(area: Area) -> Surroundings:
    """Ground and sky only."""
    return _surroundings(area, 0, bare=True)


def _surroundings(area: Area, seed: int, *, bare: bool) -> Surroundings:
    streams = [np.random.default_rng(s) for s in np.random.SeedSequence([2111, seed]).spawn(4)]
    sides = np.array([area[2] - area[0], area[3] - area[1]])
    long, wide = 0.5 * float(sides.max()), 0.5 * float(sides.min())
    turn = (0.5 * np.pi if sides[1] > sides[0] else 0.0) + np.pi * float(streams[0].integers(2))
    site = plan(long, wide, streams[0])
    if bare:
        site = Site(long=long, wide=wide, sun=site.sun, gap=site.gap)
    tone = ground_tone(site, streams[1])
    parts = [ground_mesh(site, tone)]
    if not bare:
        parts += [*house_meshes(site.plots, streams[2]), *outfit(site, tone, streams[3])]
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
