"""The state after a frame: memories updated by residuals, the network's standard deviations, and the next state.

Input features of the network, scaled to about 1, in the order in which its weights were learned.
"""

from typing import NamedTuple

from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.pose_fit import Motion, view
from vbbench_baselines.former.scene import Scene
from vbbench_baselines.former.state import State


def person_facts(xp: Operations, scene: Scene, rough: Motion) -> Array:
    """Features of people [..., K, `layers.PERSON_FACTS`], then memories; ``rough`` is the approximate motion."""
    people, views, sights, stds = scene.people, scene.views, scene.sights, scene.stds
    scale, known, none = scene.scale[..., None], scene.known[..., None], 0.0 * scene.distance
    off, off_expected = (xp.pairs(view(xp, views, motion)[1]) for motion in (rough, scene.expected))
    misses = [xp.asinh(off / scale), 0.5 * xp.asinh(off_expected / scale), xp.asinh(off / stds)]
    turned = xp.direction(-rough.turn)
    own = scene.own.velocity[..., None] + 0.0 * people.velocity
    ways = xp.join([people.velocity[..., None], own[..., None], people.traces])
    ways = xp.pairs(ways * (turned[..., None] * views.upright)[..., None])
    by_height, by_feet = people.offsets[..., 0], people.offsets[..., 1]
    apart = xp.clip(sights.by_feet + by_feet - sights.by_height - by_height, -1.0, 1.0) * sights.has_feet
    noise = xp.log(sights.noise + 1e-4)
    looks = [
        scene.known,
        scene.given.placed,
        xp.log(1.0 + people.seen),
        xp.log(1.0 + people.away),
        scene.begins,
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
    return xp.join(
        [
            known * xp.join([*misses, xp.clip(off, -3.0, 3.0)]),
            xp.flat(ways),
            xp.pairs(views.ray),
            xp.stack(looks),
            sights.cut,
            xp.log(stds + 1e-3),
            people.memory,
        ]
    )


def observer_facts(xp: Operations, scene: Scene, rough: Motion) -> Array:
    """Features of the observer [..., `layers.OBSERVER_FACTS`], then its memory."""
    count, dt, own, expected, none = scene.count, scene.dt, scene.own, scene.expected, 0.0 * scene.dt
    beyond, turned = (rough.step - expected.step) / dt, (rough.turn - expected.turn) / dt
    motion = xp.stack([beyond.real, beyond.imag, turned])
    others = [
        xp.log(1.0 + count),
        xp.log(dt),
        own.given,
        scene.own_begins,
        xp.log(1.0 + own.frames),
        10.0 * scene.spread,
        0.05 * scene.sights.seen.sum(-1),
        xp.where(count < 1.5, 1.0 + none, none),
        xp.where(count < 2.5, 1.0 + none, none),
    ]
    return xp.join(
        [
            xp.stack([own.velocity.real, own.velocity.imag, own.turn_rate]),
            scene.surprise,
            motion,
            xp.asinh(3.0 * motion),
            xp.flat(xp.pairs(own.traces)),
            xp.stack(others),
            own.memory,
        ]
    )


def second_look(xp: Operations, scene: Scene, off: Array, offset: Array) -> Array:
    """Features of people [..., K, 8] after the first fit; ``off`` and ``offset`` [..., K] as in `Found`, in m."""
    offs, scale = xp.pairs(off), scene.scale[..., None]
    misses = [xp.asinh(offs / scale), xp.asinh(offs / scene.stds), xp.asinh(xp.pairs(offset) / scale)]
    return scene.known[..., None] * xp.join([*misses, xp.clip(offs, -3.0, 3.0)])


LONGEST = 40.0
"""Frames, twice those of the longest windows that were trained on: more count as so many, however long a session."""


class Found(NamedTuple):
    """A frame after its pose is found.

    Attributes
    ----------
    motion, places : motion of the observer since the last pose; [..., K] places relative to the new one.
    kept : [..., K] distances of people in m.
    off, offset : [..., K] complex in m, along and across rays: residuals of the boxes about the predictions, and the
        network's offsets of the predictions.
    thoughts, own_thought : [..., K, N] and [..., N] hidden features of people and observer.
    uncertain : [..., 3] ln of the fit's variances.
    """

    motion: Motion
    places: Array
    kept: Array
    off: Array
    offset: Array
    thoughts: Array
    own_thought: Array
    uncertain: Array


def remembered(network: Network, scene: Scene, found: Found) -> Scene:
    """The scene with the recurrent memories after the frame."""
    xp, people, own, dt, expected = network.operations, scene.people, scene.own, scene.dt, scene.expected
    misses = scene.known[..., None] * xp.asinh(
        xp.join([xp.pairs(found.off), xp.pairs(found.offset)]) / scene.scale[..., None]
    )
    memory = network.remember("memory", xp.join([found.thoughts, misses]), people.memory)
    memory = xp.where(scene.sights.seen[..., None] > 0.5, memory, people.memory)
    pace, beyond = found.motion.step / dt, (found.motion.step - expected.step) / dt
    turned = 3.0 * (found.motion.turn - expected.turn) / dt
    change = xp.asinh(xp.stack([3.0 * beyond.real, 3.0 * beyond.imag, turned]))
    change = xp.join([found.own_thought, change, xp.stack([pace.real, pace.imag, found.motion.turn / dt])])
    own_memory = network.remember("own_memory", change, own.memory)
    thought = network.hidden("doubt", xp.detach(xp.join([found.own_thought, own_memory])))
    crowd = xp.log(1.0 + scene.count)[..., None]
    news = xp.join([thought, xp.detach(found.uncertain) * 0.2, crowd])
    own = own._replace(memory=own_memory, doubt=network.remember("doubts", news, own.doubt))
    return scene._replace(people=people._replace(memory=memory), own=own)


def spreads(network: Network, scene: Scene, found: Found) -> tuple[Array, Array]:
    """Ln of standard deviations of the pose [..., 3] and of places [..., K, 2]; no gradient passes to other layers."""
    xp, thoughts, doubt = network.operations, found.thoughts, scene.own.doubt
    facts = [
        xp.detach(thoughts),
        doubt[..., None, :] + 0.0 * scene.known[..., None],
        xp.log(scene.box_stds + 1e-3),
        xp.stack([scene.given.placed, xp.detach(xp.log(found.kept))]),
    ]
    return network.linear("pose_spread", doubt), network.perceptron("place_spread", xp.join(facts))


def state_after(xp: Operations, scene: Scene, found: Found) -> State:
    """The state for the next frame, relative to the new pose."""
    people, own, sights, dt, motion = scene.people, scene.own, scene.sights, scene.dt, found.motion
    none, back = 0.0 * dt, xp.direction(-motion.turn)
    walkers = people._replace(
        place=found.places,
        place_before=(people.place - motion.step[..., None]) * back[..., None],
        velocity=people.velocity * back[..., None],
        traces=people.traces * back[..., None, None],
        seen=xp.clip(people.seen + sights.seen, 0.0, LONGEST),
        away=(people.away + dt[..., None]) * (1.0 - sights.seen),
        shown=sights.seen,
        traceable=xp.clip(people.seen, 0.0, 1.0),
        exact=scene.given.placed * sights.seen,
        exact_before=people.exact,
        by_height=sights.by_height,
        by_feet=sights.by_feet,
        has_feet=sights.has_feet,
    )
    observer = own._replace(
        step=motion.step / dt * back,
        turn=motion.turn / dt,
        velocity=own.velocity * back,
        smooth=own.smooth * back,
        traces=own.traces * back[..., None],
        moved=xp.where(own.frames > 0.5, 1.0 + none, none),
        given=scene.given.moved + none,
        frames=xp.clip(own.frames + 1.0, 0.0, LONGEST),
    )
    return State(walkers, observer)
