"""When each sequence was, and how long figures of sequences stay alike: the length of a block of the bootstrap.

Sequences of one recording share people and time. How far that reaches is told by their figures, by a rule of
Politis & White (Econometric Reviews 23, 2004), corrected by Patton, Politis & White (ibid. 28, 2009).
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray

RULES_A_BLOCK = 3.0
"""Blocks are so many times as long as the rule says, which is made for errors of a variance. For intervals that cover
what they say, longer ones are better (Lazarus et al., J. Business & Economic Statistics 36, 2018); how much longer is
from simulations (``benchmarks/interval_coverage.py``)."""

SHARE_OF_SCENE = 0.1
"""Nor is a block shorter than this share of the longest scene: a short recording tells little of slow changes."""


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """The scenes of a dataset one after the other, and where on this line each sequence is. Times are in frames.

    Parameters
    ----------
    scene : [N] the scene of each sequence.
    middle : [N] the middle of its time.
    total : length of the line.
    longest_scene, longest, typical : the longest scene; the longest sequence, and the mean one.
    """

    scene: IntArray
    middle: FloatArray
    total: float
    longest_scene: float
    longest: float
    typical: float

    @staticmethod
    def of(scene: IntArray, first_frame: IntArray, last_frame: IntArray) -> "Timeline":
        """The timeline of sequences [N] that have the frames first_frame to last_frame of their scenes."""
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
        """Frames of a block for the means of the columns of figures [N, M], NaN = none; one length for all of them."""
        return max(RULES_A_BLOCK * self._rule(values), self.longest, SHARE_OF_SCENE * self.longest_scene)

    def _rule(self, values: FloatArray) -> float:
        """What the rule says of the sums of figures over stretches of time, each as long as a typical sequence."""
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
    """The length of the blocks of a circular bootstrap that is best for the variance of a mean.

    Parameters
    ----------
    correlation : [K] autocorrelation of the series at lags 0, 1, …
    size : values in the series.
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
    """How many lags must be insignificant for the correlation to have ended."""
    return max(5, int(np.ceil(np.sqrt(np.log10(size)))))


def _last_significant(small: BoolArray, run: int) -> int:
    """The last lag before the first ``run`` of small correlations [K], which begin at lag 1."""
    runs = np.flatnonzero(np.convolve(small, np.ones(run), "valid") == run) if len(small) >= run else np.empty(0)
    return int(runs[0]) if len(runs) else int(np.max(np.flatnonzero(~small) + 1, initial=0))


def _carried(values: IntArray, there: BoolArray) -> IntArray:
    """The values [n], where one is not there the last before it."""
    last = np.maximum.accumulate(np.where(there, np.arange(len(values)), 0))
    return values[last]
