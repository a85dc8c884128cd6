"""A part of a dataset that stands for the whole: every so many-th sequence of a plan, or one of them."""

from dataclasses import dataclass, replace
from functools import cached_property

from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.derived import DerivedPlan
from vbbench.generation.footage import FOOTAGE
from vbbench.generation.generator import Plan, SizedPlan
from vbbench.geometry import IntArray
from vbbench.sequence import SequenceData


@dataclass(frozen=True)
class Thinned(DerivedPlan):
    """A plan's sequences 0, ``stride``, 2·``stride`` and so on, seen as in the whole, numbered anew from 0.

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
