"""Each person's height: a normal posterior, sharpened by every frame with a known position."""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench_baselines._core import learn_heights
from vbbench_baselines.common.motion import History
from vbbench_baselines.common.sightings import Sightings


class Heights:
    """Posterior N(mean, variance) of each track's height, starting from the prior N(μ_h, σ_h²).

    A person at relative position z, seen on the ray ρ, has the height h = z·ρ/‖ρ‖², which noise in the box gives the
    variance h²·2σ²/l² + (h σ ρ·ρ'/‖ρ‖²)² and an error of the pose, (pose_std/‖ρ‖)², and of the place likewise.

    Parameters
    ----------
    people : number of tracks K.
    mean, std : the prior, in m.
    limits : range of plausible heights in m; the mean is kept in it, in case poses are wrong.
    pose_std : standard deviation in m of the distances that the solver's own poses give.
    """

    def __init__(self, people: int, mean: float, std: float, limits: tuple[float, float], pose_std: float) -> None:
        self.mean: FloatArray = np.full(people, mean)
        self.variance: FloatArray = np.full(people, std * std)
        self._prior, self._limits = (mean, std * std), limits
        self._pose_std = pose_std

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self.mean[columns], self.variance[columns] = self._prior

    def learn(self, history: History, previous: Sightings) -> None:
        """Update from the positions that are given of frame t−1, and its boxes; called once per frame."""
        spread = np.where(history.position_given[1], 0.0, np.nan)
        places, pose_std = history.positions[1], 0.0 if history.pose_given[1] else self._pose_std
        learn_heights(self.mean, self.variance, history.poses[1], places, spread, previous, pose_std, *self._limits)
