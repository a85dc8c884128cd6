"""An unlimited stream of sequences for training, generated on demand: nothing is written, and each is reproducible."""

from collections.abc import Iterator
from functools import partial
from itertools import count

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options
from vbbench.generation.planning import is_endless, planned
from vbbench.generation.worlds import build_sequence
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
    """Sequences first + shard, first + shard + shards, … of a split: those that `generate` would write.

    Parameters
    ----------
    split, options : what to make; splits made of recordings end with their last sequence, ``sim`` never does.
    first : the first sequence, for example to continue an earlier run.
    stop : the sequence to stop before; ``None`` for none.
    shard, shards : this worker's number, from 0, and the number of workers that share the stream without overlap.

    Raises
    ------
    VbbenchError
        If the split or an option is wrong, or there is no such shard.
    """
    if not 0 <= shard < shards:
        raise VbbenchError(f"shard {shard} of {shards}: shards are numbered from 0 to one less than their number")
    if first < 0:
        raise VbbenchError(f"the stream begins at sequence 0 or later, not {first}")
    plan = planned(split, options or Options())
    if not is_endless(plan):
        stop = len(plan) if stop is None else min(stop, len(plan))
    wanted = count(first + shard, shards) if stop is None else range(first + shard, stop, shards)
    return map(partial(build_sequence, plan), wanted)
