"""Whether figures of another seed agree with the committed ones within the uncertainty of both.

The two results answer the same sequences with other noise, or other crowds. The test is on the mean over sequences of
the difference of capped errors; its uncertainty comes from blocks of time, as that of the boards does, because
neighbouring sequences share people. A difference counts as drift if it is so large that chance gives one like it in the
whole run, over all results and metrics that are compared, with a probability of at most `LEVEL` (Bonferroni's bound).
"""

from collections.abc import Iterator

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.scoring.block_bootstrap import Means, block_means
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import PerSequence, capped_figures
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.result import Result

LEVEL = 0.05

FEW = 0.1
"""Where the sequences are too few for an interval, capped means may differ by this share of the committed one."""

COUNTS = 0.2
"""Counts of another seed's dataset may differ by this share: crowds and those who are seen are others."""

_SAME = ("split", "tier", "title", "camera", "dt", "caution", "licence", "citation")
_COUNTED = ("sequences", "mean_frames", "people_mean", "observations")


def disagreements(kept: Result, fresh: Result, comparisons: int) -> list[str]:
    """The metrics whose capped mean drifted, one line each.

    Parameters
    ----------
    comparisons : results that the whole run compares.
    """
    one, other = _shared(kept.per_sequence, fresh.per_sequence)
    if not len(one.sequence):
        return ["no sequence is scored in both; solve the whole dataset"]
    names, caps = [*section("metrics")], get_protocol(kept.board.protocol).caps
    old, new = (capped_figures(caps, {name: rows.figures[name] for name in names}) for rows in (one, other))
    found = block_means(one.timeline, new - old)
    level = LEVEL / (comparisons * len(names))
    return [*_lines(names, found, _mean(old), _mean(new), level)]


def _lines(names: list[str], found: Means, old: FloatArray, new: FloatArray, level: float) -> Iterator[str]:
    """What drifted: the means of the differences against the level of each, before and after [M]."""
    for name, difference, p, before, after in zip(names, found.mean, found.p_values(), old, new, strict=True):
        few = np.isnan(p)
        if np.isfinite(difference) and (abs(difference) > FEW * before if few else p < level):
            how = f"more than {FEW:.0%} apart" if few else f"p = {p:.1g}, below {level:.1g}"
            yield f"{name}: was {before:.4f}, is {after:.4f} with another seed ({how})"


def record_disagreements(kept: BoardDataset, fresh: BoardDataset) -> Iterator[str]:
    """Where the record of a dataset of another seed differs by more than its seed explains."""
    for name in _SAME:
        mine, theirs = getattr(kept, name), getattr(fresh, name)
        if mine != theirs:
            yield f"$.{name}: was {mine!r}, is {theirs!r}"
    for name in _COUNTED:
        before, after = kept.counts[name], fresh.counts[name]
        if abs(after - before) > COUNTS * before:
            yield f"$.counts.{name}: was {before:.6g}, is {after:.6g}"


def _shared(one: PerSequence, other: PerSequence) -> tuple[PerSequence, PerSequence]:
    """The rows of the sequences that both have."""
    return one.select(np.isin(one.sequence, other.sequence)), other.select(np.isin(other.sequence, one.sequence))


def _mean(values: FloatArray) -> FloatArray:
    """The mean of each column [N, M] over the rows that have a figure."""
    there = np.isfinite(values)
    mean: FloatArray = np.where(there, values, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    return mean
