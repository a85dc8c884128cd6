"""Gives every generated sequence a world of its own, so that nothing in it can be recognised in another one.

Sequences of a scene share people and time: in one world, what is given in one would answer another, and whole
centimetres of a recording would tell which way is north. So each is turned and shifted by random numbers of its own,
and its tracks are numbered anew. The scene stays as it is; ``truth/frames`` tells where it lies.
"""

from dataclasses import replace
from math import cos, sin

import numpy as np

from vbbench.generation.generator import Plan
from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
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
    order = rng.permutation(len(data.sequence.tracks))
    if plan.info.truth == "relative":  # its world is already its own: it begins where the camera does
        return _settled(data, order, None)
    return _settled(data, order, World(x=float(shift[0]), y=float(shift[1]), yaw=float(turn)))


def _settled(data: SequenceData, order: IntArray, world: World | None) -> SequenceData:
    """The sequence, as it is in its scene, in a ``world`` and with tracks numbered from 0 in this ``order`` [K]."""
    s, given, truth = data.sequence, data.sequence.given, data.truth
    turned = world or World()
    move = turned.x, turned.y, cos(turned.yaw), sin(turned.yaw)
    poses = np.stack([given.poses, truth.poses])
    own, true = poses if world is None else world.poses(poses)
    return replace(
        data,
        sequence=replace(
            s,
            tracks=np.arange(len(order)),
            observations=_taken(_whole(s.observations), order),
            visible=s.visible.take(order, axis=1),
            given=Given(poses=own, positions=_moved(_whole(given.positions), order, move), odometry=given.odometry),
        ),
        truth=Truth(
            poses=true, positions=_moved(_whole(truth.positions), order, move), heights=truth.heights.take(order)
        ),
        persons=_persons(data, order),
        world=world,
    )


def _persons(data: SequenceData, order: IntArray) -> IntArray:
    """[T, K] the person behind each track in this ``order`` [K] of columns."""
    if data.persons is not None:
        return data.persons.take(order, axis=1)
    return np.broadcast_to(data.sequence.tracks.take(order), data.sequence.visible.shape)


def _whole(values: FloatArray) -> FloatArray:
    """The values in one piece and read-only, as kernels are compiled for."""
    whole = np.ascontiguousarray(values)
    whole.flags.writeable = False
    return whole


@kernel
def _taken(boxes: FloatArray, order: IntArray) -> FloatArray:
    """Boxes [T, K, 3] in this ``order`` [K] of columns."""
    taken = np.empty(boxes.shape)
    for t in range(boxes.shape[0]):
        for k in range(len(order)):
            for i in range(boxes.shape[2]):
                taken[t, k, i] = boxes[t, order[k], i]
    return taken


@kernel
def _moved(positions: FloatArray, order: IntArray, move: tuple[float, float, float, float]) -> FloatArray:
    """Positions [T, K, 2] in this ``order`` [K] of columns, as `World.positions` moves them.

    ``move`` is the world's x and y in m, and cosine and sine of its yaw.
    """
    east, north, across, along = move
    moved = np.empty(positions.shape)
    for t in range(positions.shape[0]):
        for k in range(len(order)):
            x, y = positions[t, order[k], 0], positions[t, order[k], 1]
            moved[t, k, 0] = across * x - along * y + east
            moved[t, k, 1] = along * x + across * y + north
    return moved
