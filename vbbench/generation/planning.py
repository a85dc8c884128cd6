"""The plan of what is asked for: whatever makes sequences of a split, in files or in memory, makes those of it.

Gives every generated sequence its own world, so that nothing in it can be recognised in another one.

Sequences of a scene share people and time: in one world, what is given in one would answer another, and whole
centimetres of a recording would reveal which way is north. So each is turned and shifted by its own random numbers,
and its tracks are renumbered. The scene stays as it is; ``truth/frames`` has where it lies.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.footage import FOOTAGE
from vbbench.generation.generator import Generator, Options, Plan, expected_rows_of, tables_of
from vbbench.geometry import FloatArray, IntArray
from vbbench.registry import load
from vbbench.scene import Scene, World
from vbbench.sequence import Given, SequenceData, Truth
from vbbench.streams import Stream, random_stream


@dataclass(frozen=True)
class DerivedPlan:
    """What a plan has in common with the ``whole`` that it is made of; ``info`` and ``build`` are its own."""

    whole: Plan

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share: all of the whole."""
        return self.whole.scenes

    @property
    def tables(self) -> tuple[str, ...]:
        """See `vbbench.generation.generator.FootagePlan.tables`: those of the whole."""
        return tables_of(self.whole)

    def __len__(self) -> int:
        return len(self.whole)


@dataclass(frozen=True)
class Thinned(DerivedPlan):
    """A plan's sequences 0, ``stride``, 2·``stride`` and so on, seen as in the whole, renumbered from 0.

    The dataset's definition, and so its id, names the stride.
    """

    stride: int

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "stride": self.stride})

    def __len__(self) -> int:
        return -(-len(self.whole) // self.stride)

    @cached_property
    def expected_rows(self) -> IntArray | None:
        """See `expected_rows_of`: those of the whole."""
        rows = expected_rows_of(self.whole)
        return None if rows is None else rows[:: self.stride]

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        data = self.whole.build(index * self.stride)
        return replace(data, sequence=replace(data.sequence, index=index))


def thinned(plan: Plan, stride: int | None) -> Plan:
    """A plan of every ``stride``-th sequence; the plan itself without a stride, or with one of 1.

    Raises VbbenchError if it is footage, whose runs are few and long.
    """
    if stride is None or stride == 1:
        return plan
    if plan.info.tier == FOOTAGE:
        raise VbbenchError(f"`stride` is not for footage such as {plan.info.split}; use `every` or `limit`")
    return Thinned(plan, stride)


@dataclass(frozen=True)
class Single(DerivedPlan):
    """One sequence of a plan, seen as in the whole; the dataset's definition, and so its id, names it."""

    number: int

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        pictures = info.pictures[self.number : self.number + 1]
        return replace(info, definition={**info.definition, "sequence": self.number}, pictures=pictures)

    def __len__(self) -> int:
        return 1

    def build(self, index: int) -> SequenceData:
        """The sequence."""
        data = self.whole.build(self.number)
        return replace(data, sequence=replace(data.sequence, index=index))


def planned(split: str, options: Options) -> Plan:
    """The plan of a split with these options.

    Raises VbbenchError if the split or an option is wrong, its sources are missing or wrong, or there is no sequence.
    """
    generator: Generator = load("generator", split)
    plan = thinned(generator.plan(options), options.stride)
    if not len(plan):
        raise VbbenchError(f"{split}: no person of the source is seen with enough others to make a sequence")
    return plan


def is_endless(plan: Plan) -> bool:
    """Whether it builds sequences of any number: that is so where each brings its own scene, but for footage."""
    return not plan.scenes and plan.info.tier != FOOTAGE


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
    """Positions [T, K, 2] in this ``order`` [K] of columns, in the ``world``."""
    return world.positions(positions.take(order, axis=1))
