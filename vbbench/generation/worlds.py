"""Gives every generated sequence a world of its own, so that nothing in it can be recognised in another one.

Sequences of a scene share people and time: in one world, what is given in one would answer another, and whole
centimetres of a recording would tell which way is north. So each is turned and shifted by random numbers of its own,
and its tracks are numbered anew. The scene stays as it is; ``truth/frames`` tells where it lies.
"""

from dataclasses import replace

import numpy as np

from vbbench.generation.generator import Plan
from vbbench.geometry import IntArray
from vbbench.sequence import Given, SequenceData, Truth
from vbbench.world import World

WORLD_STREAM = 2
"""Spawn key of the generator of worlds, apart from the one that makes the sequence."""
FARTHEST = 100.0
"""Most m that a scene is shifted along x and along y: far more than a scene is wide, and float32 still has 0.01 mm."""


def build_sequence(plan: Plan, index: int) -> SequenceData:
    """A sequence of a plan in a world of its own, unless it has one already.

    Where nothing was measured nothing can be recognised: such a sequence keeps its tracks' numbers, for its owner.
    """
    data = plan.build(index)
    if data.world is not None or plan.info.truth == "none":
        return data
    rng = np.random.default_rng(np.random.SeedSequence([plan.info.known_seed, index], spawn_key=(WORLD_STREAM,)))
    turn, shift = rng.uniform(-np.pi, np.pi), rng.uniform(-FARTHEST, FARTHEST, 2)
    numbered = _renumbered(data, rng.permutation(len(data.sequence.tracks)))
    if plan.info.truth == "relative":  # its world is already its own: it begins where the camera does
        return numbered
    return placed(numbered, World(x=float(shift[0]), y=float(shift[1]), yaw=float(turn)))


def placed(data: SequenceData, world: World) -> SequenceData:
    """The sequence, as it is in its scene, in a world."""
    truth, given = data.truth, data.sequence.given
    moved = Given(poses=world.poses(given.poses), positions=world.positions(given.positions), odometry=given.odometry)
    return replace(
        data,
        sequence=replace(data.sequence, given=moved),
        truth=replace(truth, poses=world.poses(truth.poses), positions=world.positions(truth.positions)),
        world=world,
    )


def _renumbered(data: SequenceData, order: IntArray) -> SequenceData:
    """The same with tracks numbered from 0 in this ``order`` [K] of columns."""
    s, given, truth = data.sequence, data.sequence.given, data.truth
    shape = s.visible.shape
    people = np.broadcast_to(s.tracks.take(order), shape) if data.persons is None else data.persons.take(order, axis=1)
    return replace(
        data,
        sequence=replace(
            s,
            tracks=np.arange(len(order)),
            observations=s.observations.take(order, axis=1),
            visible=s.visible.take(order, axis=1),
            given=Given(poses=given.poses, positions=given.positions.take(order, axis=1), odometry=given.odometry),
        ),
        truth=Truth(
            poses=truth.poses, positions=truth.positions.take(order, axis=1), heights=truth.heights.take(order)
        ),
        persons=people,
    )
