"""The plan of what is asked for: whatever makes sequences of a split, in files or in memory, makes those of it."""

from dataclasses import dataclass, replace
from functools import cached_property

from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.footage import FOOTAGE
from vbbench.generation.generator import Generator, Options, Plan, SizedPlan, tables_of
from vbbench.geometry import IntArray
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.sequence import SequenceData


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

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        data = self.whole.build(index * self.stride)
        return replace(data, sequence=replace(data.sequence, index=index))


@dataclass(frozen=True)
class ThinnedSized(Thinned):
    """One of a plan that knows how large its sequences are."""

    whole: SizedPlan

    @cached_property
    def expected_rows(self) -> IntArray:
        """[N] observations of each sequence, or about so many."""
        return self.whole.expected_rows[:: self.stride]


def thinned(plan: Plan, stride: int | None) -> Plan:
    """A plan of every ``stride``-th sequence; the plan itself without a stride, or with one of 1.

    Raises
    ------
    VbbenchError
        If it is footage, whose runs are few and long.
    """
    if stride is None or stride == 1:
        return plan
    if plan.info.tier == FOOTAGE:
        raise VbbenchError(f"`stride` is not for footage such as {plan.info.split}; use `every` or `limit`")
    return ThinnedSized(plan, stride) if isinstance(plan, SizedPlan) else Thinned(plan, stride)


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


def single(plan: Plan, number: int) -> Plan:
    """A plan of one sequence of a plan."""
    return Single(plan, number)


def planned(split: str, options: Options) -> Plan:
    """The plan of a split with these options.

    Raises
    ------
    VbbenchError
        If the split or an option is wrong, its sources are missing or wrong, or there is no sequence.
    """
    generator: Generator = load("generator", split)
    plan = thinned(generator.plan(options), options.stride)
    if not len(plan):
        raise VbbenchError(f"{split}: no person of the source is seen with enough others to make a sequence")
    return plan


def is_endless(plan: Plan) -> bool:
    """Whether it builds sequences of any number: that is so where each brings its own scene, but for footage."""
    return not plan.scenes and plan.info.tier != FOOTAGE
