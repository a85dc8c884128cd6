"""How noisy boxes are, and for how long their errors are alike: learned from what boxes add.

Each pair of σ and τ of a grid is weighed by the density of all residuals so far under it, and by what is believed at
first. The estimate is the mean of ln σ, and the τ that is most probable.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.cues import CUES, PIXEL, Noise, Residuals
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen, boxes_of

SIGMAS = np.geomspace(0.01, 0.16, 11)
"""σ that are weighed, as shares of a box."""

TAUS = np.array((0.1, 0.4, 1.5, 6.0, 20.0))
"""τ in s that are weighed."""


class NoiseLearner:
    """What residuals have told so far.

    Parameters
    ----------
    first : what is believed at first.
    spread : standard deviation of ln σ about it.
    staying : ln of how much more probable its τ is than each other.
    telling : how much a frame counts.
    """

    def __init__(self, first: Noise, spread: float, staying: float, telling: float = 1.0) -> None:
        self.noise, self._telling = first, telling
        off = (np.log(SIGMAS) - np.log(first.sigma)[:, None]) / spread
        away = np.abs(np.log(TAUS) - np.log(first.tau)[:, None])
        chosen = away == away.min(axis=1, keepdims=True)
        self._told: FloatArray = -0.5 * off[:, :, None] ** 2 + staying * chosen[:, None, :]

    def learn(self, told: FloatArray) -> None:
        """Take in the log densities [3, σ, τ] of some residuals."""
        self._told += self._telling * told
        chances = np.exp(self._told - self._told.max(axis=(1, 2), keepdims=True))
        chances /= chances.sum(axis=(1, 2), keepdims=True)
        sigma = np.exp((chances.sum(axis=2) * np.log(SIGMAS)).sum(axis=1))
        tau = TAUS[chances.sum(axis=1).argmax(axis=1)]
        self.noise = Noise(sigma, tau, self.noise.nu)


@kernel
def densities(
    found: Residuals, i: int, size: float, size_before: float, nu: FloatArray, dt: float, told: FloatArray
) -> None:
    """Add the log densities [3, σ, τ] of box ``i``, given the one before it, and the heights of both in px."""
    for j in range(CUES):
        if found.counts[i, j] != 1.0:
            continue
        paired = i > 0 and found.counts[i - 1, j] == 1.0 and found.frame[i] - found.frame[i - 1] < REACH
        here, before = found.value[i, j] * found.scale[i, j], 0.0
        if paired:
            before = found.value[i - 1, j] * found.scale[i - 1, j]
        for a in range(len(SIGMAS)):
            now = np.sqrt(SIGMAS[a] ** 2 + (PIXEL / size) ** 2)
            then = np.sqrt(SIGMAS[a] ** 2 + (PIXEL / size_before) ** 2) if paired else 1.0
            for b in range(len(TAUS)):
                rho = np.exp(-(found.frame[i] - found.frame[i - 1]) * dt / TAUS[b]) if paired else 0.0
                spread = np.sqrt(1.0 - rho * rho)
                added = (here / now - rho * before / then) / spread
                told[j, a, b] -= np.log(now * spread) + 0.5 * (nu[j] + 1.0) * np.log(1.0 + added * added / nu[j])


@kernel
def residual_densities(point: Point, seen: Seen, model: Model, t: int) -> FloatArray:
    """The log densities [3, σ, τ] of what the boxes of frame ``t`` add, see `densities`."""
    told = np.zeros((CUES, len(SIGMAS), len(TAUS)))
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if t < 0 or not first <= t <= last or np.isnan(seen.boxes.azimuth[t, k]):
            continue
        _, found = boxes_of(k, point, seen, model)
        i = int(np.searchsorted(found.frame, t - first))
        size = seen.boxes.size[t, k]
        before = seen.boxes.size[first + found.frame[i - 1], k] if i > 0 else size
        densities(found, i, size, before, model.noise.nu, model.dt, told)
    return told
