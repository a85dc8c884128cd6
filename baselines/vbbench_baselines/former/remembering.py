"""The state after a frame: memories updated by residuals, the network's standard deviations, and the next state.

Input features of the network, scaled to about 1, in the order in which its weights were learned.
"""

from typing import NamedTuple

from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.pose_fit import Motion, view
from vbbench_baselines.former.scene import Scene
from vbbench_baselines.former.state import Observer, State, Walkers


def person_facts(xp: Operations, people: Walkers, scene: Scene, rough: Motion) -> Array:
    """Features of people [..., K, `layers.PERSON_FACTS`], then memories; ``rough`` is the approximate motion."""
    walks, views, sights, stds = scene.walks, scene.views, scene.sights, scene.stds
    scale, known = scene.scale[..., None], scene.known[..., None]
    off, off_expected = (xp.pairs(view(xp, views, motion)[1]) for motion in (rough, scene.expected))
    misses = [xp.asinh(off / scale), 0.5 * xp.asinh(off_expected / scale), xp.asinh(off / stds)]
    turned = xp.direction(-rough.turn)
    own = walks.own.velocity[..., None] + 0.0 * walks.velocity
    ways = xp.join([walks.velocity[..., None], own[..., None], walks.traces])
    ways = xp.pairs(ways * (turned[..., None] * views.upright)[..., None])
    return xp.join(
        [
            known * xp.join([*misses, xp.clip(off, -3.0, 3.0)]),
            xp.flat(ways),
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


def observer_facts(xp: Operations, scene: Scene, rough: Motion) -> Array:
    """Features of the observer [..., `layers.OBSERVER_FACTS`], then its memory."""
    count, dt, own, expected, none = scene.count, scene.dt, scene.walks.own, scene.expected, 0.0 * scene.dt
    beyond, turned = (rough.step - expected.step) / dt, (rough.turn - expected.turn) / dt
    motion = xp.stack([beyond.real, beyond.imag, turned])
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


class Memories(NamedTuple):
    """Memories of people [..., K, `MEMORY`], observer [..., `MEMORY`] and the pose's error [..., `DOUBT`]."""

    people: Array
    own: Array
    doubt: Array


def memories(network: Network, state: State, scene: Scene, found: Found) -> Memories:
    """The recurrent memories after the frame."""
    xp, people = network.operations, state.people
    news = xp.join([found.thoughts, surprise(xp, scene, found.off, found.offset)])
    memory = network.remember("memory", news, people.memory)
    memory = xp.where(scene.sights.seen[..., None] > 0.5, memory, people.memory)
    change = xp.join([found.own_thought, own_change(xp, scene, found.motion)])
    own = network.remember("own_memory", change, state.observer.memory)
    thought = network.hidden("doubt", xp.detach(xp.join([found.own_thought, own])))
    crowd = xp.log(1.0 + scene.count)[..., None]
    news = xp.join([thought, xp.detach(found.uncertain) * 0.2, crowd])
    return Memories(memory, own, network.remember("doubts", news, state.observer.doubt))


def spreads(network: Network, scene: Scene, found: Found, doubt: Array) -> tuple[Array, Array]:
    """Ln of standard deviations of the pose [..., 3] and of places [..., K, 2]; no gradient passes to other layers."""
    xp, thoughts = network.operations, found.thoughts
    facts = [
        xp.detach(thoughts),
        doubt[..., None, :] + 0.0 * scene.known[..., None],
        xp.log(scene.box_stds + 1e-3),
        xp.stack([scene.told.placed, xp.detach(xp.log(found.kept))]),
    ]
    return network.linear("pose_spread", doubt), network.perceptron("place_spread", xp.join(facts))


def state_after(network: Network, state: State, scene: Scene, found: Found, memory: Memories) -> State:
    """The state for the next frame, relative to the new pose."""
    back = network.operations.direction(-found.motion.turn)
    return State(
        _people(network, state, scene, found, memory, back), _observer(network, state, scene, found, memory, back)
    )


def _people(network: Network, state: State, scene: Scene, found: Found, memory: Memories, back: Array) -> Walkers:
    xp, people, walks, sights = network.operations, state.people, scene.walks, scene.sights
    return Walkers(
        place=found.places,
        place_before=(people.place - found.motion.step[..., None]) * back[..., None],
        velocity=walks.velocity * back[..., None],
        traces=walks.traces * back[..., None, None],
        memory=memory.people,
        offsets=walks.offsets,
        seen=xp.clip(people.seen + sights.seen, 0.0, LONGEST),
        away=(people.away + scene.dt[..., None]) * (1.0 - sights.seen),
        shown=sights.seen,
        traceable=xp.clip(people.seen, 0.0, 1.0),
        exact=scene.told.placed * sights.seen,
        exact_before=people.exact,
        by_height=sights.by_height,
        by_feet=sights.by_feet,
        has_feet=sights.has_feet,
    )


def _observer(network: Network, state: State, scene: Scene, found: Found, memory: Memories, back: Array) -> Observer:
    xp, own, none = network.operations, scene.walks.own, 0.0 * scene.dt
    return Observer(
        step=found.motion.step / scene.dt * back,
        turn=found.motion.turn / scene.dt,
        velocity=own.velocity * back,
        turn_rate=own.turn_rate,
        smooth=own.smooth * back,
        head_odds=own.head_odds,
        traces=own.traces * back[..., None],
        memory=memory.own,
        doubt=memory.doubt,
        moved=xp.where(state.observer.frames > 0.5, 1.0 + none, none),
        told=scene.told.moved + none,
        frames=xp.clip(own.frames + 1.0, 0.0, LONGEST),
    )
