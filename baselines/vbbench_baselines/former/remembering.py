"""The state after a frame: memories updated by residuals, the network's standard deviations, and the next state."""

from typing import NamedTuple

from vbbench_baselines.former.facts import own_change, surprise
from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.pose_fit import Motion
from vbbench_baselines.former.scene import Scene
from vbbench_baselines.former.state import Observer, State, Walkers

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
    crowd = xp.log(1.0 + scene.known.sum(-1))[..., None]
    news = xp.join([thought, xp.detach(found.uncertain) * 0.2, crowd])
    return Memories(memory, own, network.remember("doubts", news, state.observer.doubt))


def spreads(network: Network, scene: Scene, found: Found, doubt: Array) -> tuple[Array, Array]:
    """Ln of standard deviations of the pose [..., 3] and of places [..., K, 2]; no gradient passes to other layers."""
    xp, thoughts = network.operations, found.thoughts
    facts = [
        xp.detach(thoughts),
        doubt[..., None, :] + 0.0 * thoughts[..., : doubt.shape[-1]],
        xp.log(xp.stack([scene.box_along, scene.box_across]) + 1e-3),
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
        traceable=xp.where(people.seen > 0.5, 1.0 + 0.0 * found.kept, 0.0 * found.kept),
        exact=scene.told.placed * sights.seen,
        exact_before=people.exact,
        by_height=sights.by_height,
        by_feet=sights.by_feet,
        has_feet=sights.has_feet,
    )


def _observer(network: Network, state: State, scene: Scene, found: Found, memory: Memories, back: Array) -> Observer:
    own, none = scene.walks.own, 0.0 * scene.dt
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
        moved=(state.observer.frames > 0.5) * (1.0 + none),
        told=scene.told.moved + none,
        frames=network.operations.clip(own.frames + 1.0, 0.0, LONGEST),
    )
