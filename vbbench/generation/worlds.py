"""Gives every generated sequence its own world, so that nothing in it can be recognised in another one.

Sequences of a scene share people and time: in one world, what is given in one would answer another, and whole
centimetres of a recording would reveal which way is north. So each is turned and shifted by its own random numbers,
and its tracks are renumbered. The scene stays as it is; ``truth/frames`` has where it lies.
"""

from dataclasses import replace

import numpy as np

from vbbench.generation.generator import Plan
from vbbench.geometry import FloatArray, IntArray
from vbbench.scene import World
from vbbench.sequence import Given, SequenceData, Truth
from vbbench.streams import Stream, random_stream

FARTHEST = 100.0
"""Most m that a scene is shifted along x and along y: far more than a scene is wide, and float32 still has 0.01 mm."""


def build_sequence(plan: Plan, index: int) -> SequenceData:
    """A sequence of a plan in its own world, unless it has one already.

    Where nothing was measured nothing can be recognised: such a sequence keeps its tracks' numbers, for its owner.
    """
    data = plan.build(index)
    if data.world is not None or plan.info.truth == "none":
        return data
    rng = random_stream(plan.info.known_seed, index, Stream.WORLD)
    turn, shift = rng.uniform(-np.pi, np.pi), rng.uniform(-FARTHEST, FARTHEST, 2)
    order = rng.permutation(len(data.sequence.tracks))
    if plan.info.truth == "relative":  # its world is already its own: it begins where the camera does
        return _placed(data, order, None)
    return _placed(data, order, World(x=float(shift[0]), y=float(shift[1]), yaw=float(turn)))


def _placed(data: SequenceData, order: IntArray, world: World | None) -> SequenceData:
    """The sequence, as it is in its scene, in a ``world`` and with tracks numbered from 0 in this ``order`` [K]."""
    s, given, truth = data.sequence, data.sequence.given, data.truth
    turned = world or World()
    poses = np.stack([given.poses, truth.poses])
    own, true = poses if world is None else world.poses(poses)
    return replace(
        data,
        sequence=replace(
            s,
            tracks=np.arange(len(order)),
            observations=s.observations.take(order, axis=1),
            visible=s.visible.take(order, axis=1),
            given=Given(poses=own, positions=_moved(given.positions, order, turned), odometry=given.odometry),
        ),
        truth=Truth(poses=true, positions=_moved(truth.positions, order, turned), heights=truth.heights.take(order)),
        persons=_persons(data, order),
        world=world,
    )


def _persons(data: SequenceData, order: IntArray) -> IntArray:
    """[T, K] the person behind each track in this ``order`` [K] of columns."""
    if data.persons is not None:
        return data.persons.take(order, axis=1)
    return np.broadcast_to(data.sequence.tracks.take(order), data.sequence.visible.shape)


def _moved(positions: FloatArray, order: IntArray, world: World) -> FloatArray:
    """Positions [T, K, 2] in this ``order`` [K] of columns, in the ``world``; most of them are NaN."""
    moved = positions.take(order, axis=1)
    flat = moved.reshape(-1, 2)
    known = np.flatnonzero(~np.isnan(flat[:, 0]))
    flat[known] = world.positions(flat.take(known, axis=0))
    return moved
