"""Whether two datasets rank solvers equally: how, with what uncertainty, and how it is drawn from errors by sequence.

A solver's figure is the mean over sequences of its capped error. With the figures f_v of V variants on one dataset
(made) and r_v on the other (real):

- Spearman's ρ of f and r, over all variants and without those that rely on the foot cue;
- the share of pairs u, v that the real data separate (the 95 % interval of their paired difference does not hold 0) for
  which f orders them as r does;
- the geometric mean of f_v/r_v;
- the regret: r of the variant with the least f, over the least r.

Their intervals are quantiles over a block bootstrap of both datasets: blocks of sequences that follow each other in
time, drawn with replacement, the same for every variant.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.scoring.block_bootstrap import Timeline, block_means

RESAMPLES, SEED = 2000, 20231119
LEVEL = (0.025, 0.975)
LEAST = 1e-6
"""Least figure, in m: a person who keeps standing at the same place has no error while the camera stands."""
FEWEST_BLOCKS = 7.0
"""Ranks cannot be drawn from fewer; intervals are then rough."""


class Estimate(NamedTuple):
    """A number and its 95 % interval; NaN where it is of nothing."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Capped errors of variants on one dataset.

    Parameters
    ----------
    values : [V, N] of every variant and sequence, in the metric's unit.
    timeline : when the sequences were.
    """

    values: FloatArray
    timeline: Timeline

    @property
    def means(self) -> FloatArray:
        """[V] figure of each variant."""
        mean: FloatArray = np.maximum(self.values.mean(axis=1), LEAST)
        return mean

    @property
    def blocks(self) -> int:
        """How many blocks a resample has: as intervals of means have it, or enough for ranks if that is fewer."""
        line = self.timeline
        block = max(line.longest, min(line.block_length(self.values.T), line.total / FEWEST_BLOCKS))
        return max(1, round(line.total / block))

    def resampled(self, resamples: int, seed: int) -> FloatArray:
        """[R, V] figures on blocks drawn with replacement."""
        counts = self.counts(resamples, seed)
        means: FloatArray = np.maximum(counts @ self.values.T / counts.sum(axis=1, keepdims=True), LEAST)
        return means

    def counts(self, resamples: int, seed: int) -> FloatArray:
        """[R, N] how often each sequence is drawn; draws of nobody are removed.

        A block is a stretch of the line of time, its start uniform; from the line's end on it goes on at the beginning.
        A sequence is in the blocks that its middle is in.
        """
        random, total = np.random.default_rng(seed), self.timeline.total
        counts = np.zeros((resamples, self.values.shape[1]))
        for _ in range(self.blocks):
            starts = random.uniform(0.0, total, (resamples, 1))
            counts += (self.timeline.middle - starts) % total < total / self.blocks
        drawn: FloatArray = counts[counts.sum(axis=1) > 0.0]
        return drawn


def agreement(made: Errors, real: Errors, feet: BoolArray, resamples: int = RESAMPLES) -> dict[str, Estimate]:
    """How ``made`` and ``real`` rank the same variants, ``feet`` [V] being those that rely on the foot cue."""
    rest, apart = ~feet, separated(real)
    figures: dict[str, Callable[[FloatArray, FloatArray], FloatArray]] = {
        "spearman": spearman,
        "spearman_without_feet": lambda f, r: spearman(f[:, rest], r[:, rest]),
        "pairs": lambda f, r: ordered_equally(f, r, apart),
        "pairs_without_feet": lambda f, r: ordered_equally(f, r, apart & np.outer(rest, rest)),
        "ratio": lambda f, r: np.exp(np.log(f / r).mean(axis=1)),
        "regret": regret,
    }
    drawn_made, drawn_real = made.resampled(resamples, SEED), real.resampled(resamples, SEED + 1)
    count = min(len(drawn_made), len(drawn_real))
    found = {}
    for name, figure in figures.items():
        low, high = np.quantile(figure(drawn_made[:count], drawn_real[:count]), LEVEL).tolist()
        found[name] = Estimate(float(figure(made.means[None], real.means[None])[0]), low, high)
    return found


def halves(errors: Errors) -> float:
    """Spearman's ρ of the odd sequences with the even ones: what noise leaves of a perfect agreement."""
    return float(spearman(*(errors.values[None, :, half::2].mean(axis=2) for half in (0, 1)))[0])


def spearman(made: FloatArray, real: FloatArray) -> FloatArray:
    """Rank correlation [R] of figures [R, V]; equals share their mean rank. NaN where all figures are equal."""
    from scipy.stats import rankdata

    f, r = (rankdata(values, axis=1) for values in (made, real))
    f, r = f - f.mean(axis=1, keepdims=True), r - r.mean(axis=1, keepdims=True)
    spread = np.sqrt((f**2).sum(axis=1) * (r**2).sum(axis=1))
    return np.where(spread > 0.0, (f * r).sum(axis=1) / np.where(spread > 0.0, spread, 1.0), np.nan)


def separated(errors: Errors) -> BoolArray:
    """[V, V] the pairs u < v whose paired difference has a 95 % interval without 0, by blocks of time."""
    one, other = np.triu_indices(len(errors.values), k=1)
    differences = (errors.values[one] - errors.values[other]).T
    low, high = block_means(errors.timeline, differences).interval().T
    apart = np.zeros((len(errors.values),) * 2, np.bool_)
    apart[one, other] = (low > 0.0) | (high < 0.0)
    return apart


def ordered_equally(made: FloatArray, real: FloatArray, pairs: BoolArray) -> FloatArray:
    """Share [R] of the ``pairs`` [V, V] that figures [R, V] of both order equally; NaN without pairs."""
    one, other = np.nonzero(pairs)
    if not len(one):
        return np.full(len(made), np.nan)
    same = np.sign(made[:, one] - made[:, other]) == np.sign(real[:, one] - real[:, other])
    share: FloatArray = same.mean(axis=1)
    return share


def regret(made: FloatArray, real: FloatArray) -> FloatArray:
    """How many times the least real figure [R, V] that of the variant with the least made one is: [R]."""
    chosen = np.take_along_axis(real, made.argmin(axis=1)[:, None], axis=1)[:, 0]
    times: FloatArray = chosen / real.min(axis=1)
    return times
