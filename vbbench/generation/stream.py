"""Endless sequences made on the fly, for training: nothing is written, and any of them can be had again."""

from collections.abc import Iterator
from itertools import count

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Generator, Options, Plan
from vbbench.registry import load
from vbbench.sequence import SequenceData


def stream(
    split: str = "sim",
    options: Options | None = None,
    *,
    first: int = 0,
    stop: int | None = None,
    shard: int = 0,
    shards: int = 1,
) -> Iterator[SequenceData]:
    """Sequences first + shard, first + shard + shards, … of a split: the same ones that `generate` would write.

    Parameters
    ----------
    split, options : what to make; splits made of recordings end with their last sequence, ``sim`` never does.
    first : where to begin, to go on where an earlier run stopped.
    stop : the sequence to stop before; ``None`` for none.
    shard, shards : this worker's number, from 0, and how many workers share the stream. No two get the same sequence.

    Raises
    ------
    VbbenchError
        If the split or an option is wrong, or there is no such shard.
    """
    if not 0 <= shard < shards:
        raise VbbenchError(f"shard {shard} of {shards}: shards are numbered from 0 to one less than their number")
    if first < 0:
        raise VbbenchError(f"the stream begins at sequence 0 or later, not {first}")
    generator: Generator = load("generator", split)
    plan = generator.plan(options or Options())
    end = _end(plan, stop)
    return map(plan.build, count(first + shard, shards) if end is None else range(first + shard, end, shards))


def _end(plan: Plan, stop: int | None) -> int | None:
    """Where the plan's sequences end: a plan whose sequences share scenes has just so many."""
    if not plan.scenes:
        return stop
    return len(plan) if stop is None else min(stop, len(plan))
