"""From which distance on the five-point method errs more than somebody else, and how sure that is.

An error grows with distance: the means at all distances are made to rise by isotonic regression, and lie on straight
lines between. Intervals are quantiles over a bootstrap of the trials at every distance and of the other's own error.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import isotonic_regression

from vbbench.geometry import FloatArray

RESAMPLES = 1000
LEVELS = (0.025, 0.975)


@dataclass(frozen=True, kw_only=True)
class Level:
    """Somebody's mean error, and its 95 % interval; NaN where it has none."""

    value: float
    low: float = np.nan
    high: float = np.nan

    def drawn(self, count: int, random: np.random.Generator) -> FloatArray:
        """Means [count] that might as well have been: log-normal, as errors are positive; alike without interval."""
        if not 0.0 < self.low <= self.high:
            return np.full(count, self.value)
        spread = np.log(self.high / self.low) / (2.0 * 1.96)
        return np.asarray(self.value * np.exp(spread * random.normal(size=count)))


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """A distance in m and its 95 % interval; the first measured one also if it is nearer, infinite beyond the last."""

    distance: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Errors [D, N] of trials at distances [D] in m; ``seed`` is of the bootstrap."""

    distances: FloatArray
    errors: FloatArray
    seed: int = 0

    @property
    def means(self) -> FloatArray:
        """[D] mean error at every distance."""
        return np.asarray(self.errors.mean(axis=1))

    def rises_over(self, value: float) -> float:
        """The distance at which the mean reaches a value: the first one if it is there already, infinite if never."""
        return float(_first_over(self.distances, _rising(self.means)[None], np.array([value]))[0])

    def crossing(self, level: Level) -> Crossing:
        """Where it rises over a level."""
        levels = level.drawn(RESAMPLES, np.random.default_rng(self.seed))
        found = _first_over(self.distances, self._resampled, levels)
        low, high = np.quantile(found, LEVELS, method="inverted_cdf")
        return Crossing(distance=self.rises_over(level.value), low=float(low), high=float(high))

    @cached_property
    def _resampled(self) -> FloatArray:
        """[R, D] rising means of trials drawn with replacement."""
        places, trials = self.errors.shape
        chosen = np.random.default_rng([self.seed, 1]).integers(trials, size=(RESAMPLES, places, trials))
        means = np.take_along_axis(self.errors[None], chosen, axis=2).mean(axis=2)
        return np.stack([_rising(one) for one in means])


def _rising(means: FloatArray) -> FloatArray:
    """[D] never falling, nearest to means [D]."""
    return np.asarray(isotonic_regression(means).x)


def _first_over(distances: FloatArray, rising: FloatArray, levels: FloatArray) -> FloatArray:
    """[R] where rising means [R, D], straight between the distances [D], reach levels [R]."""
    after = np.sum(rising < levels[:, None], axis=1)
    last = np.clip(after, 1, len(distances) - 1)
    row = np.arange(len(levels))
    below, above = rising[row, last - 1], rising[row, last]
    share = (levels - below) / np.where(above > below, above - below, 1.0)
    between = distances[last - 1] + share * (distances[last] - distances[last - 1])
    return np.where(after == 0, distances[0], np.where(after == len(distances), np.inf, between))
