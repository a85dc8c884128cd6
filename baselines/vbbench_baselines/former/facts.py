"""Input features of the network, scaled to about 1, in the order in which its weights were learned."""

from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.pose_fit import Motion, view
from vbbench_baselines.former.scene import Scene
from vbbench_baselines.former.state import Walkers


def person_facts(xp: Operations, people: Walkers, scene: Scene, rough: Motion) -> Array:
    """Features of people [..., K, `layers.PERSON_FACTS`], then memories; ``rough`` is the approximate motion."""
    walks, views, sights = scene.walks, scene.views, scene.sights
    stds = xp.stack([xp.sqrt(scene.along), xp.sqrt(scene.across)])
    scale, known = scene.scale[..., None], scene.known[..., None]
    off, off_expected = (xp.pairs(view(xp, views, motion)[1]) for motion in (rough, scene.expected))
    misses = [xp.asinh(off / scale), 0.5 * xp.asinh(off_expected / scale), xp.asinh(off / stds)]
    turned = xp.direction(-rough.turn)
    own = walks.own.velocity[..., None] + 0.0 * walks.velocity
    ways = xp.join([walks.velocity[..., None], own[..., None], walks.traces])
    ways = xp.pairs(ways * turned[..., None, None] * views.upright[..., None])
    return xp.join(
        [
            known * xp.join([*misses, xp.clip(off, -3.0, 3.0)]),
            ways.reshape((*ways.shape[:-2], 2 * ways.shape[-2])),
            xp.pairs(views.ray),
            xp.stack([scene.known, scene.told.placed, *_looks(xp, people, scene)]),
            sights.cut,
            xp.log(stds + 1e-3),
            people.memory,
        ]
    )


def _looks(xp: Operations, people: Walkers, scene: Scene) -> list[Array]:
    """16 features [..., K]: how long people are known, and their distances by their boxes."""
    sights, walks, none = scene.sights, scene.walks, 0.0 * scene.distance
    by_height, by_feet = walks.offsets[..., 0], walks.offsets[..., 1]
    apart = xp.clip(sights.by_feet + by_feet - sights.by_height - by_height, -1.0, 1.0) * sights.has_feet
    noise = xp.log(sights.noise + 1e-4)
    return [
        xp.log(1.0 + people.seen),
        xp.log(1.0 + people.away),
        walks.begins,
        people.exact,
        people.exact_before,
        scene.distance,
        noise[..., 0],
        noise[..., 1],
        noise[..., 2],
        xp.log(scene.distance_std + 1e-3),
        5.0 * apart,
        5.0 * by_height,
        5.0 * by_feet,
        sights.has_feet,
        xp.log(scene.dt)[..., None] + none,
        10.0 * scene.spread[..., None] + none,
    ]


def observer_facts(xp: Operations, scene: Scene, rough: Motion, count: Array) -> Array:
    """Features of the observer [..., `layers.OBSERVER_FACTS`], then its memory; ``count`` [...] people are known."""
    dt, own, expected, none = scene.dt, scene.walks.own, scene.expected, 0.0 * scene.dt
    beyond, turned = (rough.step - expected.step) / dt, (rough.turn - expected.turn) / dt
    motion = xp.stack([beyond.real, beyond.imag, turned])
    traces = xp.pairs(own.traces)
    others = [
        xp.log(1.0 + count),
        xp.log(dt),
        own.told,
        scene.walks.own_begins,
        xp.log(1.0 + own.frames),
        10.0 * scene.spread,
        0.05 * scene.sights.seen.sum(-1),
        xp.where(count < 1.5, 1.0 + none, none),
        xp.where(count < 2.5, 1.0 + none, none),
    ]
    return xp.join(
        [
            xp.stack([own.velocity.real, own.velocity.imag, own.turn_rate]),
            scene.walks.surprise,
            motion,
            xp.asinh(3.0 * motion),
            traces.reshape((*traces.shape[:-2], 2 * traces.shape[-2])),
            xp.stack(others),
            own.memory,
        ]
    )


def second_look(xp: Operations, scene: Scene, off: Array, offset: Array) -> Array:
    """Features of people [..., K, 8] after the first fit; ``off`` and ``offset`` [..., K] as in `Found`, in m."""
    offs, scale = xp.pairs(off), scene.scale[..., None]
    stds = xp.stack([xp.sqrt(scene.along), xp.sqrt(scene.across)])
    misses = [xp.asinh(offs / scale), xp.asinh(offs / stds), xp.asinh(xp.pairs(offset) / scale)]
    return scene.known[..., None] * xp.join([*misses, xp.clip(offs, -3.0, 3.0)])


def surprise(xp: Operations, scene: Scene, off: Array, offset: Array) -> Array:
    """Features of people [..., K, 4] for their memories, after the last pose fit; ``off`` and ``offset`` as above."""
    misses = xp.join([xp.pairs(off), xp.pairs(offset)])
    return scene.known[..., None] * xp.asinh(misses / scene.scale[..., None])


def own_change(xp: Operations, scene: Scene, motion: Motion) -> Array:
    """Features of the observer [..., 6] for its memory: its ``motion`` by the last pose fit."""
    dt, expected = scene.dt, scene.expected
    pace, beyond = motion.step / dt, (motion.step - expected.step) / dt
    turned = 3.0 * (motion.turn - expected.turn) / dt
    change = xp.asinh(xp.stack([3.0 * beyond.real, 3.0 * beyond.imag, turned]))
    return xp.join([change, xp.stack([pace.real, pace.imag, motion.turn / dt])])
