"""What the entropy of posteriors goes with, over all frames: rank correlations, also at equal numbers of people.

Intervals are quantiles over a block bootstrap: sequences that follow each other in time are drawn together, with all
of their frames (`vbbench.reproduction.transfer.agreement.Errors.counts`).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.reproduction.transfer.agreement import LEVEL, Errors, Estimate
from vbbench.scoring.block_bootstrap import Timeline, block_means

RESAMPLES = 400
SEED = 20231119
FEWEST_ALIKE = 20
"""Numbers of people with fewer frames than this say nothing of what happens at equal number."""


@dataclass(frozen=True, kw_only=True)
class FrameSample:
    """Frames [F] of sequences [N] on a timeline, with their number of people.

    Parameters
    ----------
    sequence : [F] the sequence of each frame, ascending, as a row of the timeline.
    people : [F] how many are seen.
    timeline : of the sequences.
    """

    sequence: IntArray
    people: IntArray
    timeline: Timeline

    def means(self, values: FloatArray, groups: IntArray, count: int) -> tuple[FloatArray, FloatArray]:
        """Means over sequences of their mean in each of ``count`` groups [count], and 95 % intervals [count, 2].

        Values [F] are left out where NaN; ``groups`` [F] are numbers from 0 on, others in no group.
        """
        there = ~np.isnan(values) & (groups >= 0) & (groups < count)
        size = len(self.timeline.middle)
        cell = self.sequence[there] * count + groups[there]
        total = np.bincount(cell, values[there], size * count)
        number = np.bincount(cell, minlength=size * count)
        table = np.where(number > 0, total / np.maximum(number, 1), np.nan).reshape(size, count)
        found = block_means(self.timeline, table)
        return found.mean, found.interval()

    def estimate(self, statistic: Callable[..., float], *columns: FloatArray) -> Estimate:
        """A statistic of columns [F] and the number of people, with its interval; frames with a NaN are left out."""
        there = ~np.isnan(np.stack(columns)).any(axis=0)
        values = [column[there] for column in columns]
        people, sequence = self.people[there], self.sequence[there]
        drawn = [
            statistic(*(np.repeat(column, times) for column in values), np.repeat(people, times))
            for times in self._draws(columns[0])[:, sequence]
        ]
        known = np.array([one for one in drawn if not np.isnan(one)])
        low, high = np.quantile(known, LEVEL) if len(known) else (np.nan, np.nan)
        return Estimate(value=statistic(*values, people), low=float(low), high=float(high))

    def _draws(self, values: FloatArray) -> IntArray:
        """[R, N] how often each sequence is drawn, in blocks as long as values [F] stay alike."""
        there, size = ~np.isnan(values), len(self.timeline.middle)
        number = np.bincount(self.sequence[there], minlength=size)
        mean = np.bincount(self.sequence[there], values[there], size) / np.maximum(number, 1)
        filled = np.where(number > 0, mean, mean[number > 0].mean())
        return Errors(values=filled[None], timeline=self.timeline).counts(RESAMPLES, SEED).astype(np.int64)


def rank_correlation(one: FloatArray, other: FloatArray, _people: IntArray) -> float:
    """Spearman's ρ of columns [F]."""
    from scipy.stats import rankdata

    return correlation(rankdata(one), rankdata(other))


def rank_correlation_at_equal_number(one: FloatArray, other: FloatArray, people: IntArray) -> float:
    """Spearman's ρ among frames with the same number of people: of ranks within each number, over its frames."""
    return correlation(ranks_within(one, people), ranks_within(other, people))


def slope_at_equal_number(one: FloatArray, other: FloatArray, people: IntArray) -> float:
    """By how much ``other`` changes per unit of ``one`` among frames with the same number of people: least squares."""
    x, y = less_the_mean(one, people), less_the_mean(other, people)
    return float(x @ y / (x @ x)) if x.any() else float("nan")


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Pearson's; NaN where either does not vary."""
    one, other = one - one.mean(), other - other.mean()
    scale = float(np.sqrt((one @ one) * (other @ other)))
    return float(one @ other) / scale if scale > 0.0 else float("nan")


def less_the_mean(values: FloatArray, groups: IntArray) -> FloatArray:
    """Values [F] less the mean of their group; 0 in groups with fewer than `FEWEST_ALIKE`."""
    number = np.bincount(groups)
    mean = np.bincount(groups, values) / np.maximum(number, 1)
    return np.where(number[groups] >= FEWEST_ALIKE, values - mean[groups], 0.0)


def ranks_within(values: FloatArray, groups: IntArray) -> FloatArray:
    """Ranks [F] within each group, equals sharing theirs, as a share of the group's size less the mean."""
    from scipy.stats import rankdata

    among_all = rankdata(values)
    within = rankdata(groups * (2.0 * len(values)) + among_all)
    return less_the_mean(within, groups) / np.bincount(groups)[groups]
