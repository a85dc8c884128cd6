"""From which distance on the five-point method errs more than somebody else, and how sure that is.

An error grows with distance: the means at all distances are made to rise by isotonic regression, and lie on straight
lines between. Intervals are quantiles over a bootstrap of the trials at every distance and of the other's own error.
"""

from dataclasses import dataclass

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
        return self.value * np.exp(spread * random.normal(size=count))


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """A distance in m and its 95 % interval; the first measured one also if it is nearer, infinite beyond the last."""

    distance: float
    low: float
    high: float


@dataclass(frozen=True)
class Curve:
    """Errors [D, N] of trials at distances [D] in m."""

    distances: FloatArray
    errors: FloatArray

    def crossing(self, level: Level, seed: int) -> Crossing:
        """Where it rises over a level."""
        random = np.random.default_rng(seed)
        places, trials = self.errors.shape
        chosen = random.integers(trials, size=(RESAMPLES, places, trials))
        means = np.take_along_axis(self.errors[None], chosen, axis=2).mean(axis=2)
        levels = level.drawn(RESAMPLES, random)
        found = [rises_over(self.distances, one, height) for one, height in zip(means, levels, strict=True)]
        low, high = np.quantile(found, LEVELS, method="inverted_cdf")
        here = rises_over(self.distances, self.errors.mean(axis=1), level.value)
        return Crossing(distance=here, low=float(low), high=float(high))


def rises_over(distances: FloatArray, means: FloatArray, level: float) -> float:
    """The distance at which rising means [D] reach a level: the first one if it is there, infinite if never."""
    rising = isotonic_regression(means).x
    after = int(np.searchsorted(rising, level))
    if after == 0:
        return float(distances[0])
    if after == len(rising):
        return float(np.inf)
    share = (level - rising[after - 1]) / (rising[after] - rising[after - 1])
    return float(distances[after - 1] + share * (distances[after] - distances[after - 1]))
