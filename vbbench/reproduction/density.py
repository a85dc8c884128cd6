"""A density known up to a factor, on a grid about its maximum: entropy, covariance, marginals and tails.

The grid is q = m + Lu, u in a cube of ± `REACH` about 0, L lower triangular. With L from the covariance of the density
itself the u have unit covariance, so that the grid fits narrow and slanted densities; and since L is triangular, the
sum over the last of the u at fixed others is the marginal of the first two of the q, here the place, whatever the yaw.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import entr

from vbbench.geometry import FloatArray

REACH = 6.0
"""Half the side of the cube, in standard deviations."""
POINTS = 21
"""Points of the grid along each axis; twice as many change ETH's entropies by less than .01, kurtoses by .03."""
_TIMES = 4
"""Marginals are interpolated to so many times as fine a grid where their contours count."""
_COARSE, _ROUNDS = 13, 8
_CHANGE = 0.15
"""The grid fits once no standard deviation changes by a larger share."""

Energy = Callable[[FloatArray], FloatArray]
"""−ln of a density at points [N, D], up to a constant."""


@dataclass(frozen=True, kw_only=True)
class GridDensity:
    """A normalised density on the grid.

    Parameters
    ----------
    centre : [D] m.
    factor : [D, D] L, lower triangular.
    steps : [n] the u along each axis.
    mass : [n, …, n] probability of each cell, of sum 1.
    """

    centre: FloatArray
    factor: FloatArray
    steps: FloatArray
    mass: FloatArray

    @property
    def entropy(self) -> float:
        """Differential entropy in nats."""
        cell = float(np.prod(np.diag(self.factor)) * (self.steps[1] - self.steps[0]) ** len(self.centre))
        return float(entr(self.mass).sum() + np.log(cell))

    @property
    def offsets(self) -> FloatArray:
        """[n, …, n, D] the u of the cells."""
        return np.stack(np.meshgrid(*[self.steps] * len(self.centre), indexing="ij"), axis=-1)

    def points(self) -> FloatArray:
        """[n, …, n, D] the points of the cells."""
        return self.centre + self.offsets @ self.factor.T

    def moments(self) -> tuple[FloatArray, FloatArray]:
        """Mean [D] and covariance [D, D]."""
        mean, covariance = moments(self.offsets, self.mass)
        return self.centre + self.factor @ mean, self.factor @ covariance @ self.factor.T

    def marginal(self) -> "GridDensity":
        """That of the first two coordinates, by summation."""
        mass = self.mass.sum(axis=tuple(range(2, self.mass.ndim)))
        return GridDensity(centre=self.centre[:2], factor=self.factor[:2, :2], steps=self.steps, mass=mass)

    def level(self, share: float) -> float:
        """The mass of a cell above which lies ``share`` of the probability."""
        falling = np.sort(self.mass, axis=None)[::-1]
        return float(falling[np.searchsorted(np.cumsum(falling), share).clip(max=len(falling) - 1)])

    def finer(self) -> "GridDensity":
        """A density in the plane on `_TIMES` as fine a grid, its logarithm interpolated by cubic splines."""
        from scipy.interpolate import RectBivariateSpline

        logarithm = np.log(self.mass.clip(1e-300))
        steps = np.linspace(self.steps[0], self.steps[-1], _TIMES * (len(self.steps) - 1) + 1)
        mass = np.exp(RectBivariateSpline(self.steps, self.steps, logarithm)(steps, steps))
        return GridDensity(centre=self.centre, factor=self.factor, steps=steps, mass=mass / mass.sum())

    def tails(self) -> tuple[float, float]:
        """How heavy the tails of a density in the plane are; neither figure changes under linear maps.

        First the probability outside the ellipse of three standard deviations, e^−4.5 = 1.11 % for a normal density;
        then Mardia's kurtosis, the mean fourth power of the distance in standard deviations, less a normal one's 8.
        """
        mean, covariance = moments(self.offsets, self.mass)
        off = self.offsets - mean
        squared = np.einsum("...i,ij,...j->...", off, np.linalg.inv(covariance), off)
        return float(self.mass[squared > 9.0].sum()), float(np.sum(self.mass * squared**2)) - 8.0


def moments(points: FloatArray, mass: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean [D] and covariance [D, D] of points [..., D] of probability ``mass`` [...]."""
    flat, weight = points.reshape(-1, points.shape[-1]), mass.ravel()
    mean = weight @ flat
    off = flat - mean
    return mean, (off * weight[:, None]).T @ off


def find_density(energy: Energy, start: FloatArray, covariance: FloatArray, points: int = POINTS) -> GridDensity:
    """The density of an energy about its least point.

    Parameters
    ----------
    start, covariance : [D] the least point, and [D, D] a guess of the covariance, corrected until the grid fits.
    points : of the grid along each axis.
    """
    centre, factor = start, np.asarray(np.linalg.cholesky(covariance))
    for _ in range(_ROUNDS):
        coarse = _on_grid(energy, centre, factor, _COARSE)
        mean, spread = coarse.moments()
        # A density narrower than a cell seems to have no extent at all; it has about a cell's.
        cell = (coarse.steps[1] - coarse.steps[0]) ** 2 / 12.0 * factor @ factor.T
        better = np.asarray(np.linalg.cholesky(spread + cell))
        fits = np.all(np.abs(np.diag(better) / np.diag(factor) - 1.0) < _CHANGE)
        centre, factor = mean, better
        if fits:
            break
    return _on_grid(energy, centre, factor, points)


def _on_grid(energy: Energy, centre: FloatArray, factor: FloatArray, points: int) -> GridDensity:
    shape = (points,) * len(centre)
    steps = np.linspace(-REACH, REACH, points)
    empty = GridDensity(centre=centre, factor=factor, steps=steps, mass=np.empty(shape))
    energies = energy(empty.points().reshape(-1, len(centre))).reshape(shape)
    mass = np.exp(energies.min() - energies)
    return GridDensity(centre=centre, factor=factor, steps=steps, mass=mass / mass.sum())
