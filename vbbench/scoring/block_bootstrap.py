"""Means of sequences that share people and time, with intervals: a block bootstrap over time within scenes.

The circular block bootstrap (Politis & Romano 1992) resamples blocks of time instead of sequences. The variance of a
mean has a closed form, e'Me / N²: e holds the figures less their mean, and M the share of the blocks with one sequence
that contain the other, too (a triangle over the time between them).

With few blocks this variance is biased and uncertain, the more so if sequences cluster in time. As Bell & McCaffrey
(Survey Methodology 28, 2002) do for clusters, expectation and degrees of freedom of e'Me are computed for figures with
a working correlation over `REACH` of a block. The variance is divided by that bias, and Student's t replaces the normal
distribution; for white noise this is the fixed-b correction of Shao & Politis (J. Royal Statistical Society B 75,
2013).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from threadpoolctl import ThreadpoolController

from vbbench.geometry import BoolArray, FloatArray, IntArray

RULES_A_BLOCK = 3.0
"""Blocks are so many times as long as the rule says, which is made for errors of a variance. For intervals that cover
what they say, longer ones are better (Lazarus et al., J. Business & Economic Statistics 36, 2018); how much longer is
from simulations (``benchmarks/interval_coverage.py``)."""

SHARE_OF_SCENE = 0.1
"""Nor is a block shorter than this share of the longest scene: a short recording has little of slow changes."""


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """All scenes of a dataset concatenated in time, with the place of each sequence. Times are in frames.

    Parameters
    ----------
    scene : [N] the scene of each sequence.
    middle : [N] the middle of each sequence.
    total : length of all scenes.
    longest_scene, longest, typical : lengths of the longest scene, the longest sequence and the mean sequence.
    """

    scene: IntArray
    middle: FloatArray
    total: float
    longest_scene: float
    longest: float
    typical: float

    @staticmethod
    def of(scene: IntArray, first_frame: IntArray, last_frame: IntArray) -> "Timeline":
        """The timeline of sequences [N], by the first and last frame of each in its scene."""
        _, place = np.unique(scene, return_inverse=True)
        begin, end = first_frame.astype(float), last_frame + 1.0
        scenes = int(place.max(initial=-1)) + 1
        low, high = np.full(scenes, np.inf), np.full(scenes, -np.inf)
        np.minimum.at(low, place, begin)
        np.maximum.at(high, place, end)
        start = np.cumsum(high - low) - (high - low)
        return Timeline(
            scene=scene,
            middle=start[place] + (begin + end) / 2 - low[place],
            total=float(np.sum(high - low)),
            longest_scene=float(np.max(high - low)),
            longest=float(np.max(end - begin)),
            typical=float(np.mean(end - begin)),
        )

    def block_length(self, values: FloatArray) -> float:
        """Length of blocks in frames for means of the columns of figures [N, M], NaN = none; one length for all."""
        return max(RULES_A_BLOCK * self._rule(values), self.longest, SHARE_OF_SCENE * self.longest_scene)

    def _rule(self, values: FloatArray) -> float:
        """Optimal length of blocks in frames, by sums of figures over bins of time as long as a typical sequence."""
        stretches = max(2, round(self.total / self.typical))
        width = self.total / stretches
        stretch = np.minimum(self.middle / width, stretches - 1).astype(np.int64)
        sums = np.zeros((stretches, values.shape[1]))
        # In float32, as result files have them: a recount must find the same length.
        np.add.at(sums, stretch, residuals(values.astype(np.float32).astype(float)))
        scene = np.zeros(stretches, np.int64)
        scene[stretch] = self.scene
        filled = np.zeros(stretches, bool)
        filled[stretch] = True
        return width * optimal_length(autocorrelation(sums, _carried(scene, filled)), stretches)


def optimal_length(correlation: FloatArray, size: int) -> float:
    """Optimal length, in values, of the blocks of a circular bootstrap for the variance of a mean.

    Parameters
    ----------
    correlation : [K] autocorrelation of the series at lags 0, 1, …
    size : length of the series.
    """
    limit = 2.0 * np.sqrt(np.log10(size) / size)
    lags = 2 * max(_last_significant(np.abs(correlation[1:]) < limit, _in_a_row(size)), 1)
    lag = np.arange(min(lags + 1, len(correlation)))
    window = np.clip(2.0 * (1.0 - lag / lags), 0.0, 1.0) * correlation[lag]
    spectrum, slope = 2.0 * window.sum() - window[0], 2.0 * np.sum(lag * window)
    if not spectrum:
        return 1.0
    best = (1.5 * (slope / spectrum) ** 2 * size) ** (1 / 3)
    return float(np.clip(best, 1.0, max(1.0, np.ceil(min(3.0 * np.sqrt(size), size / 3.0)))))


def autocorrelation(series: FloatArray, scene: IntArray) -> FloatArray:
    """Autocorrelation [K] within scenes of the series in the columns [n, M] that are centred, mean over the columns."""
    size = len(series)
    lags = min(size, int(np.ceil(np.sqrt(size))) + _in_a_row(size) + 1)
    covariance = np.zeros((lags, series.shape[1]))
    for k in range(lags):
        together = scene[: size - k] == scene[k:]
        covariance[k] = (series[: size - k] * series[k:])[together].sum(axis=0)
    varying = covariance[0] > 0
    if not varying.any():
        return np.asarray(np.eye(1, lags)[0])
    mean: FloatArray = np.mean(covariance[:, varying] / covariance[0, varying], axis=1)
    return mean


def residuals(values: FloatArray) -> FloatArray:
    """The figures [N, M] less their column's mean, 0 where there is none (NaN)."""
    there = ~np.isnan(values)
    total, count = np.where(there, values, 0.0).sum(axis=0), there.sum(axis=0)
    less: FloatArray = np.where(there, values - total / np.maximum(count, 1), 0.0)
    return less


def _in_a_row(size: int) -> int:
    """Number of consecutive insignificant lags that end the correlation."""
    return max(5, int(np.ceil(np.sqrt(np.log10(size)))))


def _last_significant(small: BoolArray, run: int) -> int:
    """The last lag before the first ``run`` of small correlations [K], which begin at lag 1."""
    runs = np.flatnonzero(np.convolve(small, np.ones(run), "valid") == run) if len(small) >= run else np.empty(0)
    return int(runs[0]) if len(runs) else int(np.max(np.flatnonzero(~small) + 1, initial=0))


def _carried(values: IntArray, there: BoolArray) -> IntArray:
    """The values [n], each missing one replaced by the last before it."""
    last = np.maximum.accumulate(np.where(there, np.arange(len(values)), 0))
    return values[last]


FEWEST_BLOCKS, FEWEST_SEQUENCES = 2.5, 5
"""With less there is no interval: it would be made up."""

REACH = 0.4
"""Over this share of a block figures are taken to be correlated: a triangle as well."""

_MOST = 512
"""With more sequences, neighbours in time are taken together."""


@dataclass(frozen=True, kw_only=True)
class Means:
    """Means of M columns of figures.

    Parameters
    ----------
    mean : [M], NaN without a figure.
    error : [M] standard errors, NaN where the sequences are too few for one.
    degrees : [M] degrees of freedom of Student's t.
    block, blocks : length of a block in frames, and number of blocks in the total time.
    """

    mean: FloatArray
    error: FloatArray
    degrees: FloatArray
    block: float
    blocks: float

    def interval(self) -> FloatArray:
        """[M, 2] the 95 % interval of each mean."""
        reach = self._reach()
        return np.stack([self.mean - reach, self.mean + reach], axis=-1)

    def positive_interval(self, largest: FloatArray) -> FloatArray:
        """[M, 2] the 95 % interval of means that are above 0 and at most the largest [M]: that of their logarithms."""
        reach = self._reach()
        ratio = np.divide(reach, self.mean, out=np.where(np.isnan(reach), np.nan, 0.0), where=self.mean != 0)
        factor = np.exp(np.minimum(ratio, 700.0))
        return np.stack([self.mean / factor, np.minimum(self.mean * factor, np.maximum(largest, self.mean))], axis=-1)

    def p_values(self) -> FloatArray:
        """Two-sided p-values [M] for a mean of 0; NaN without an interval."""
        t = np.divide(np.abs(self.mean), self.error, out=np.full_like(self.mean, np.inf), where=self.error > 0)
        from scipy.special import stdtr

        p = 2.0 * stdtr(np.where(np.isnan(self.degrees), 1.0, self.degrees), -t)
        p = np.where((self.mean == 0) & (self.error == 0), 1.0, p)
        return np.where(np.isnan(self.error), np.nan, p)

    def _reach(self) -> FloatArray:
        from scipy.special import stdtrit

        reach: FloatArray = stdtrit(self.degrees, 0.975) * self.error
        return reach


def block_means(timeline: Timeline, values: FloatArray, block: float | None = None) -> Means:
    """Means of the columns of figures [N, M] of sequences on the timeline, NaN = none.

    Parameters
    ----------
    block : length of a block in frames; by default `Timeline.block_length` of these figures.
    """
    block = timeline.block_length(values) if block is None else block
    there = ~np.isnan(values)
    count = there.sum(axis=0)
    mean = np.divide(np.where(there, values, 0.0).sum(axis=0), count, out=np.full(len(count), np.nan), where=count > 0)
    # A block that the rule wants longer than the data allows is as long as they allow; a sequence is never cut.
    block = min(block, max(timeline.longest, timeline.total / FEWEST_BLOCKS))
    blocks = timeline.total / block
    error, degrees = np.full((2, len(count)), np.nan)
    usual = is_enough(blocks, count)
    if usual.any():
        with _libraries().limit(limits=1):  # digits do not depend on processors, and small matrices take less time
            error[usual], degrees[usual] = _errors(timeline, values[:, usual], block)
    return Means(mean=mean, error=error, degrees=degrees, block=block, blocks=blocks)


@cache
def _libraries() -> ThreadpoolController:
    """The numerical libraries, whose threads are limited; cached, as finding them takes longer than most means."""
    return ThreadpoolController()


def is_enough(blocks: float, sequences: IntArray) -> BoolArray:
    """Whether so many ``sequences`` [M] in so many ``blocks`` of time suffice for an interval."""
    enough: BoolArray = (blocks > FEWEST_BLOCKS - 1e-9) & (np.asarray(sequences) >= FEWEST_SEQUENCES)
    return enough


def block_shares(timeline: Timeline, middle: FloatArray, block: float) -> FloatArray:
    """[n, n] share of the blocks with the time ``middle`` [n] of one sequence that contain that of the other, too."""
    apart = np.abs(middle[:, None] - middle)
    shares: FloatArray = np.clip(1.0 - np.minimum(apart, timeline.total - apart) / block, 0.0, 1.0)
    return shares


def _errors(timeline: Timeline, values: FloatArray, block: float) -> tuple[FloatArray, FloatArray]:
    """Standard errors [M] of the means of the columns [N, M], and their degrees of freedom."""
    order = np.argsort(timeline.middle, kind="stable")
    group = np.arange(len(order)) * min(_MOST, len(order)) // len(order)
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    sizes = np.diff(starts, append=len(order))
    middle = np.add.reduceat(timeline.middle[order], starts) / sizes
    scene = timeline.scene[order][starts]
    there = ~np.isnan(values)
    counts = np.add.reduceat(there[order].astype(float), starts, axis=0)
    sums = np.add.reduceat(residuals(values)[order], starts, axis=0)
    shares = block_shares(timeline, middle, block)
    apart = np.abs(middle[:, None] - middle)
    similar = np.clip(1.0 - apart / (REACH * block), 0.0, 1.0) * (scene[:, None] == scene)
    found = np.maximum(np.einsum("nm,nm->m", sums, shares @ sums), 0.0)
    ratio, degrees = _corrections(counts, shares, similar)
    return np.sqrt(found * ratio) / there.sum(axis=0), degrees


def _corrections(counts: FloatArray, shares: FloatArray, similar: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Factors [M] from e'Me to variances of sums, and degrees of freedom [M], for columns of ``counts`` [n, M]."""
    kinds, kind = np.unique(counts, axis=1, return_inverse=True)
    pairs = np.array([_correction(kinds[:, k], shares, similar) for k in range(kinds.shape[1])])
    return pairs[kind.ravel(), 0], pairs[kind.ravel(), 1]


def _correction(count: FloatArray, shares: FloatArray, similar: FloatArray) -> tuple[float, float]:
    """1'C1 / tr(R'MRC) and 2 tr²(·) / 2 tr((·)²); C is the working covariance of the sums, and R subtracts the mean."""
    covariance = similar * np.outer(count, count)
    taken = shares @ count / count.sum()
    centred = shares - taken[:, None] - taken + count @ taken / count.sum()
    product = centred @ covariance
    mean = float(np.trace(product))
    return float(covariance.sum()) / mean, mean**2 / float(np.sum(product * product.T))
