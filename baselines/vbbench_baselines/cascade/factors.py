"""The terms of a frame's energy, as the parts in C++ take them; ``baselines/cpp/cascade/ego_motion.hpp`` derives it."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray

VAGUE = 1e-6
"""Information (1/m² and 1/rad²) that holds the pose at its prediction where people say nothing about it."""


class Factors(NamedTuple):
    """The terms of a frame's energy.

    Attributes
    ----------
    relative : [K, 2] measured (right, forward) in m, NaN = not observed.
    covariance : [K, 3] its covariance (rr, rf, ff) in m².
    expected, std : [K, 2] and [K] where people are expected, in m, NaN = unknown.
    walk, walk_std : [3] the observer's own predicted pose and the standard deviation in m of its place, inf for no
        such prior.
    """

    relative: FloatArray
    covariance: FloatArray
    expected: FloatArray
    std: FloatArray
    walk: FloatArray
    walk_std: float

    def of(self, chosen: BoolArray) -> "Factors":
        """The terms of the ``chosen`` people [K] and the observer."""
        relative, covariance, expected, std = (rows[chosen] for rows in self[:4])
        return Factors(relative, covariance, expected, std, self.walk, self.walk_std)

    @property
    def helpful(self) -> BoolArray:
        """[K] who is observed and expected."""
        return ~np.isnan(self.std + self.relative[:, 0])

    def spread(self, times: float) -> "Factors":
        """The same terms with standard deviations of motion that many times as large."""
        return self._replace(std=self.std * times, walk_std=self.walk_std * times)
