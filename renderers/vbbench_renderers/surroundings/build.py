"""Everything around a walking area."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_renderers.meshes import Mesh, Sky, Surroundings, join_meshes
from vbbench_renderers.surroundings.furniture import THINGS, hedge, tree
from vbbench_renderers.surroundings.houses import house_meshes
from vbbench_renderers.surroundings.shapes import SPREAD, STREET, Quads, place, turned
from vbbench_renderers.surroundings.site import (
    FAR_PAVEMENT,
    PAVEMENT,
    ROADWAY,
    TO_PARK,
    Area,
    Site,
    Tone,
    dark_spot,
    ground_mesh,
    ground_tone,
    plan,
    surface,
)
from vbbench_renderers.surroundings.textures import textures

MOST = 7
"""The largest number of trees or things of one kind along one side."""


@dataclass(frozen=True, kw_only=True)
class Spot:
    """The place of a thing of some kind, in m and rad; `size` is a tree's scale or a hedge's length, m."""

    kind: str
    u: float
    v: float
    yaw: float = 0.0
    size: float = 1.0


def outfit(site: Site, tone: Tone, rng: np.random.Generator) -> list[Mesh]:
    """All things in the site's frame, with the dark spots under them."""
    spots = [*_side(site, 0, rng), *_side(site, 1, rng), *_street(site, rng), *_park(site, rng)]
    meshes = []
    for spot in spots:
        meshes.append(_thing(site, spot, rng))
        if spot.kind in STREET["spots"] and site.distance(spot.u, spot.v) < 45.0:
            half = np.array(STREET["spots"][spot.kind])
            meshes.append(dark_spot(site, tone, np.array([spot.u, spot.v]), half, spot.yaw))
    return meshes


def _thing(site: Site, spot: Spot, rng: np.random.Generator) -> Mesh:
    distance = site.distance(spot.u, spot.v)
    if spot.kind == "tree":
        mesh = tree(spot.size, distance, rng)
    elif spot.kind == "hedge":
        mesh = hedge(spot.size, distance, rng)
    else:
        parts = THINGS[spot.kind](rng)
        mesh = join_meshes(
            [part.divide(SPREAD * distance).mesh() if isinstance(part, Quads) else part for part in parts]
        )
    _, depth = surface(site, np.array([spot.u]), np.array([spot.v]))
    return place(mesh, spot.u, spot.v, spot.yaw, float(depth[0]))


def _stations(low: float, high: float, gap: float, rng: np.random.Generator) -> Iterator[float]:
    """Places along a line, about `gap` apart, at most `MOST`."""
    count = int(np.clip((high - low) / gap, 1, MOST))
    width = (high - low) / count
    yield from low + width * (np.arange(count) + rng.uniform(0.35, 0.65, count))


def _side(site: Site, side: int, rng: np.random.Generator) -> list[Spot]:
    """Along one of the long sides: an avenue with benches if it is wide enough, lamps and café tables otherwise."""
    sign = 1.0 - 2.0 * side
    yaw = 0.0 if side == 0 else np.pi
    wide = site.setbacks[side] > 7.0
    spots: list[Spot] = []
    for u in _stations(-site.long - 3.0, site.long + 3.0, 10.0 if wide else 9.0, rng):
        if wide:
            spots.append(Spot(kind="tree", u=u, v=sign * (site.wide + 4.9), yaw=0.0, size=rng.uniform(0.85, 1.1)))
            things = ["bench", "bin", "planter"] if rng.random() < 0.7 else ["lamp", "planter"]
            offsets = [3.0, 4.6, -2.6]
            line = 2.8
        else:
            kind = rng.random()
            things = ["planter", "sign"]
            if kind < 0.8:
                things = ["cafe", "cafe", "planter"] if kind < 0.45 else ["bench", "bin", "lamp"]
            offsets = [0.0, 2.7, -1.9]
            line = 2.6
        spots += [
            Spot(kind=thing, u=u + offset, v=sign * (site.wide + line + 0.5 * (thing == "cafe")), yaw=yaw)
            for thing, offset in zip(things, offsets, strict=False)
        ]
    return spots


def _street(site: Site, rng: np.random.Generator) -> list[Spot]:
    """The crossing street: bollards, parked cars, lamps, and trees behind."""
    kerb = site.long + PAVEMENT
    reach = site.wide + 14.0
    spots = [
        Spot(kind="bollard", u=kerb - 0.7, v=v)
        for v in np.arange(-site.wide, site.wide + 0.1, max(2.6, site.wide / 5.0))
    ]
    for lane, share in ((1.15, 0.4), (ROADWAY - 1.15, 0.5)):
        yaw = 0.5 * np.pi * (1.0 if lane < 2.0 else -1.0)
        lots = np.arange(-reach, reach, 5.6)[:MOST] + rng.uniform(-0.4, 0.4)
        clear = (lots > site.gap[0]) & (lots < site.gap[1]) & (lane > 2.0)
        taken = (rng.random(len(lots)) < share) & ~clear
        spots += [Spot(kind="car", u=kerb + lane, v=float(v), yaw=yaw) for v in lots[taken]]
    beyond = kerb + ROADWAY + 1.3
    for v in _stations(-reach, reach, 11.0, rng):
        if not site.gap[0] - 2.0 < v < site.gap[1] + 2.0:
            spots.append(
                Spot(kind="tree" if rng.random() < 0.6 else "lamp", u=beyond, v=v, size=rng.uniform(0.75, 0.95))
            )
    spots.append(
        Spot(kind="column", u=site.long + 3.4, v=rng.choice([-1.0, 1.0]) * (site.wide - rng.uniform(0.0, 2.0)))
    )
    spots.append(Spot(kind="sign", u=kerb - 0.7, v=-site.wide - 1.3, yaw=-0.5 * np.pi))
    lot = kerb + ROADWAY + FAR_PAVEMENT
    for u in (lot + 22.0, lot + 34.0, lot + 46.0):
        spots += [
            Spot(kind="tree", u=u + rng.uniform(-2.0, 2.0), v=v, size=rng.uniform(0.8, 1.0))
            for v in (site.gap[0] + 1.4, site.gap[1] - 1.4)
        ]
    return spots


def _park(site: Site, rng: np.random.Generator) -> list[Spot]:
    """The park: benches in front of a hedge, and trees behind it."""
    edge = -site.long - TO_PARK
    spots: list[Spot] = []
    for v in _stations(-site.wide - 2.0, site.wide + 2.0, 7.5, rng):
        if rng.random() < 0.6:
            spots.append(Spot(kind="bench", u=edge + 0.5, v=v, yaw=0.5 * np.pi))
        spots.append(Spot(kind="hedge", u=edge - 0.9, v=v, yaw=0.5 * np.pi, size=5.2))
        if rng.random() < 0.5:
            spots.append(Spot(kind="lamp", u=edge + 0.5, v=v + 2.6))
    count = int(np.clip(0.8 * site.wide, 7, MOST))
    for n in range(count):
        v = (n + rng.uniform(0.2, 0.8)) / count * 2.0 - 1.0
        away = rng.uniform(4.0, 12.0) if n % 2 else rng.uniform(14.0, 42.0)
        spots.append(
            Spot(kind="tree", u=edge - away, v=v * (site.wide + 5.0 + 0.3 * away), size=rng.uniform(0.9, 1.35))
        )
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
