"""Whether two datasets rank solvers alike: how, with what uncertainty, and how it is drawn from errors by sequence.

A solver's figure is the mean over sequences of its capped error. With the figures f_v of V variants on the one dataset
(made) and r_v on the other (real):

- Spearman's ρ of f and r, over all variants and without those that rely on feet;
- the share of pairs u, v that the real data separate (the 95 % interval of their paired difference leaves 0 out) for
  which f orders them as r does;
- the geometric mean of f_v/r_v;
- the regret: r of the variant with the least f, over the least r.

Their intervals are quantiles over a block bootstrap of both datasets: blocks of sequences that follow each other in
time, drawn with replacement, the same for every variant.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray

RESAMPLES = 2000
SEED = 20231119
LEVEL = (0.025, 0.975)


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Capped errors of variants on one dataset.

    Parameters
    ----------
    values : [V, N] of every variant and sequence, in the metric's unit.
    scene : [N] scene of each sequence.
    start, end : [N] when it begins and ends, in s of its scene.
    block : seconds that a block lasts.
    """

    values: FloatArray
    scene: IntArray
    start: FloatArray
    end: FloatArray
    block: float

    @property
    def means(self) -> FloatArray:
        """[V] figure of each variant."""
        mean: FloatArray = self.values.mean(axis=1)
        return mean

    def resampled(self, resamples: int, seed: int) -> FloatArray:
        """[R, V] figures on blocks drawn with replacement."""
        counts = block_counts(self, np.random.default_rng(seed), resamples)
        kept = counts.sum(axis=1) > 0
        counts = counts[kept]
        means: FloatArray = counts @ self.values.T / counts.sum(axis=1, keepdims=True)
        return means


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A number and its 95 % interval; NaN where it is of nothing."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """How alike two datasets rank variants; see the top of this file.

    Parameters
    ----------
    separated : number of pairs that the real data separate.
    """

    spearman: Estimate
    spearman_without_feet: Estimate
    alike: Estimate
    alike_without_feet: Estimate
    ratio: Estimate
    regret: Estimate
    separated: int
    blocks: tuple[int, int]


def block_counts(errors: Errors, random: np.random.Generator, resamples: int) -> FloatArray:
    """[R, N] how often each sequence is drawn.

    Scenes lie one behind the other on a line of time; a block is a stretch of it, its start uniform, from its end on it
    goes on at the line's beginning. A sequence is in the blocks that its middle is in.
    """
    middle, length = _line_of_time(errors)
    number = max(1, round(length / errors.block))
    starts = random.uniform(0.0, length, (resamples, number, 1))
    inside = (middle - starts) % length < errors.block
    counts: FloatArray = inside.sum(axis=1).astype(float)
    return counts


def number_of_blocks(errors: Errors) -> int:
    """How many blocks a resample has."""
    return max(1, round(_line_of_time(errors)[1] / errors.block))


def _line_of_time(errors: Errors) -> tuple[FloatArray, float]:
    """The middle [N] of each sequence on the line of time, and its length; both in s."""
    middle, length = 0.5 * (errors.start + errors.end), 0.0
    for scene in np.unique(errors.scene):
        own = errors.scene == scene
        first, last = errors.start[own].min(), errors.end[own].max()
        middle[own] += length - first
        length += last - first
    return middle, length


def agreement(made: Errors, real: Errors, feet: BoolArray, resamples: int = RESAMPLES) -> Agreement:
    """How alike ``made`` and ``real`` rank the same variants, ``feet`` [V] being those that rely on feet."""
    drawn_made, drawn_real = made.resampled(resamples, SEED), real.resampled(resamples, SEED + 1)
    apart = separated(drawn_real)
    rest = ~feet
    both = np.outer(rest, rest)

    def estimate(function: Callable[[FloatArray, FloatArray], FloatArray]) -> Estimate:
        value = function(made.means[None], real.means[None])[0]
        count = min(len(drawn_made), len(drawn_real))
        low, high = np.quantile(function(drawn_made[:count], drawn_real[:count]), LEVEL)
        return Estimate(value=float(value), low=float(low), high=float(high))

    return Agreement(
        spearman=estimate(spearman),
        spearman_without_feet=estimate(lambda f, r: spearman(f[:, rest], r[:, rest])),
        alike=estimate(lambda f, r: alike(f, r, apart)),
        alike_without_feet=estimate(lambda f, r: alike(f, r, apart & both)),
        ratio=estimate(lambda f, r: np.exp(np.log(f / r).mean(axis=1))),
        regret=estimate(regret),
        separated=int(apart.sum()),
        blocks=(number_of_blocks(made), number_of_blocks(real)),
    )


def spearman(made: FloatArray, real: FloatArray) -> FloatArray:
    """Rank correlation [R] of figures [R, V]; equals share their mean rank. NaN where all figures are equal."""
    from scipy.stats import rankdata

    f, r = (rankdata(values, axis=1) for values in (made, real))
    f, r = f - f.mean(axis=1, keepdims=True), r - r.mean(axis=1, keepdims=True)
    spread = np.sqrt((f**2).sum(axis=1) * (r**2).sum(axis=1))
    return np.where(spread > 0.0, (f * r).sum(axis=1) / np.where(spread > 0.0, spread, 1.0), np.nan)


def separated(drawn: FloatArray) -> BoolArray:
    """[V, V] the pairs u < v whose difference has one sign throughout the 95 % interval of figures drawn [R, V]."""
    count = drawn.shape[1]
    apart = np.zeros((count, count), np.bool_)
    for one in range(count):
        low, high = np.quantile(drawn[:, one, None] - drawn[:, one + 1 :], LEVEL, axis=0)
        apart[one, one + 1 :] = (low > 0.0) | (high < 0.0)
    return apart


def alike(made: FloatArray, real: FloatArray, pairs: BoolArray) -> FloatArray:
    """Share [R] of the ``pairs`` [V, V] that figures [R, V] order alike; NaN without pairs."""
    one, other = np.nonzero(pairs)
    if not len(one):
        return np.full(len(made), np.nan)
    same = np.sign(made[:, one] - made[:, other]) == np.sign(real[:, one] - real[:, other])
    share: FloatArray = same.mean(axis=1)
    return share


def regret(made: FloatArray, real: FloatArray) -> FloatArray:
    """How many times as large [R] as the least real figure that of the variant with the least made one is, [R, V]."""
    chosen = np.take_along_axis(real, made.argmin(axis=1)[:, None], axis=1)[:, 0]
    times: FloatArray = chosen / real.min(axis=1)
    return times
