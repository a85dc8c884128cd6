"""Each person's height: a normal posterior, sharpened by every frame with a known position."""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import History
from vbbench_baselines.common.sightings import Sightings

FLOOR = 1e-5
"""Least standard deviation in m of a height from one frame, so that exact data do not divide by zero."""


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

    def learn(self, history: History, previous: Sightings, expected: FloatArray, std: FloatArray) -> None:
        """Update from what is known of frame t−1 and its boxes; called once per frame.

        Without a given position the walk may help: places ``expected`` then [K, 2] with deviations ``std`` [K] in m,
        which do not depend on the boxes of that frame; NaN = not to be learned from.
        """
        given = history.position_given[1]
        places = np.where(given[:, None], history.positions[1], expected)
        pose_std = 0.0 if history.pose_given[1] else self._pose_std
        spread = np.where(given, 0.0, std)
        _update(self.mean, self.variance, history.poses[1], places, spread, previous, pose_std, self._limits)


@kernel
def _update(
    mean: FloatArray,
    variance: FloatArray,
    pose: FloatArray,
    positions: FloatArray,
    spread: FloatArray,
    sightings: Sightings,
    pose_std: float,
    limits: tuple[float, float],
) -> None:
    rays, sideways, stretch = sightings
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    for k in range(len(mean)):
        if np.isnan(spread[k] + stretch[k]):
            continue
        dx, dy = positions[k, 0] - pose[0], positions[k, 1] - pose[1]
        right, forward = dx * sin - dy * cos, dx * cos + dy * sin
        squared = rays[k, 0] ** 2 + rays[k, 1] ** 2
        height = (right * rays[k, 0] + forward * rays[k, 1]) / squared
        slip = (rays[k, 0] * sideways[k, 0] + rays[k, 1] * sideways[k, 1]) / squared
        noise = height**2 * (stretch[k] ** 2 + slip**2) + (pose_std**2 + spread[k] ** 2) / squared + FLOOR**2
        gain = variance[k] / (variance[k] + noise)
        mean[k] = min(max(mean[k] + gain * (height - mean[k]), limits[0]), limits[1])
        variance[k] *= 1.0 - gain
