"""A part of a dataset that stands for the whole: every so many-th sequence of a plan, or one of them."""

from dataclasses import dataclass, replace
from functools import cached_property

from vbbench.errors import VbbenchError
from vbbench.files.dataset_checks import ALWAYS
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.footage import FOOTAGE
from vbbench.generation.generator import FootagePlan, Plan, SizedPlan
from vbbench.geometry import IntArray
from vbbench.scene import Scene
from vbbench.sequence import SequenceData


@dataclass(frozen=True)
class Thinned:
    """A plan's sequences 0, ``stride``, 2·``stride`` and so on, seen as in the whole, numbered anew from 0.

    The dataset's definition, and so its id, names the stride.
    """

    whole: Plan
    stride: int

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "stride": self.stride})

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share: all of the whole."""
        return self.whole.scenes

    @property
    def tables(self) -> tuple[str, ...]:
        """See `vbbench.generation.generator.FootagePlan.tables`: those of the whole."""
        return self.whole.tables if isinstance(self.whole, FootagePlan) else ALWAYS

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
        raise VbbenchError(f"--stride is not for footage such as {plan.info.split}; use --every or --limit")
    return ThinnedSized(plan, stride) if isinstance(plan, SizedPlan) else Thinned(plan, stride)


@dataclass(frozen=True)
class Single:
    """One sequence of a plan, seen as in the whole; the dataset's definition, and so its id, names it."""

    whole: Plan
    number: int

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        pictures = info.pictures[self.number : self.number + 1]
        return replace(info, definition={**info.definition, "sequence": self.number}, pictures=pictures)

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share: all of the whole."""
        return self.whole.scenes

    def __len__(self) -> int:
        return 1

    def build(self, index: int) -> SequenceData:
        """The sequence."""
        data = self.whole.build(self.number)
        return replace(data, sequence=replace(data.sequence, index=index))


@dataclass(frozen=True)
class SingleOfFootage(Single):
    """One of footage, with its tables."""

    whole: FootagePlan

    @property
    def tables(self) -> tuple[str, ...]:
        """See `FootagePlan.tables`."""
        return self.whole.tables


def single(plan: Plan, number: int) -> Plan:
    """A plan of one sequence of a plan."""
    return SingleOfFootage(plan, number) if isinstance(plan, FootagePlan) else Single(plan, number)
