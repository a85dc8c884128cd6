"""Fits the plane of head sizes: robust against odd boxes, and no long track or dense place rules it."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench_generators.lifting.mixed import Mixed, PlaneError, fit_mixed, solve
from vbbench_generators.lifting.plane import SizePlane

LEAST_TRACKS = 8
_CELLS = (12, 8)
_MANY = 50


@dataclass(frozen=True, kw_only=True)
class PlaneFit:
    """A plane of head sizes and how sure it is.

    Parameters
    ----------
    plane : the fit.
    scatter : robust standard deviation of the boxes about it, relative to the size.
    resampled : [R] the same plane from tracks drawn with replacement.
    """

    plane: SizePlane
    scatter: float
    resampled: tuple[SizePlane, ...]

    @property
    def covariance(self) -> FloatArray:
        """[3, 3] of (a, b, c)."""
        draws = np.array([[plane.a, plane.b, plane.c] for plane in self.resampled])
        matrix: FloatArray = np.cov(draws, rowvar=False)
        return matrix


def fit_plane(
    x: FloatArray, nu: FloatArray, size: FloatArray, track: IntArray, *, level: bool, resamples: int, seed: int
) -> PlaneFit:
    """Fit the plane to boxes.

    Minimises a Student-t loss of the relative residuals (s − ŝ)/ŝ, for the noise of a box grows with its size. They are
    relative to the fitted size, never the measured one, or boxes would weigh more for being small by chance.

    Parameters
    ----------
    x, nu : [N] centres of the boxes in px from the picture's centre.
    size : [N] in px.
    track : [N] whose box it is; equal ids stand together.
    level : whether c is 0.
    resamples, seed : how often tracks are drawn anew for the covariance, and with which numbers.

    Raises
    ------
    PlaneError
        If there are too few tracks, or sizes do not grow downwards beyond doubt.
    """
    starts = np.flatnonzero(np.r_[True, track[1:] != track[:-1]])
    if len(starts) < LEAST_TRACKS:
        raise PlaneError(f"{len(starts)} tracks are too few to calibrate a camera; {LEAST_TRACKS} are the least")
    scale = float(np.hypot(np.ptp(x), np.ptp(nu))) or 1.0
    columns = [np.ones_like(x), nu / scale] if level else [np.ones_like(x), nu / scale, x / scale]
    share, pair = _shares(x, nu, track)
    fit = fit_mixed(np.stack(columns, axis=1), size, share, pair, starts)
    draws = _resample(fit, resamples, seed)
    _check_growth(fit.beta, draws)
    planes = tuple(_plane(draw, scale) for draw in draws)
    return PlaneFit(plane=_plane(fit.beta, scale), scatter=fit.scatter, resampled=planes)


def _plane(beta: FloatArray, scale: float) -> SizePlane:
    slopes = [float(value) / scale for value in beta[1:]]
    return SizePlane(a=float(beta[0]), b=slopes[0], c=slopes[1] if len(slopes) > 1 else 0.0)


def _shares(x: FloatArray, nu: FloatArray, track: IntArray) -> tuple[FloatArray, IntArray]:
    """What each box counts [N], and the number of its group [N]: one person's boxes in one cell of the picture.

    A group of n boxes shares n / (n + 50) of a vote, for its noise is drawn anew only every so often, divided by the
    fourth root of how many people are ever in that cell. The mean vote is 1.
    """
    cells = _CELLS[0] * _CELLS[1]
    cell = _bins(x, _CELLS[0]) * _CELLS[1] + _bins(nu, _CELLS[1])
    _, number = np.unique(track, return_inverse=True)
    group, pair, boxes = np.unique(number * cells + cell, return_inverse=True, return_counts=True)
    people = np.bincount(group % cells, minlength=cells)
    vote = boxes / (boxes + _MANY) / people[group % cells] ** 0.25
    shares: FloatArray = (vote / vote.mean() / boxes)[pair]
    return shares, pair


def _bins(values: FloatArray, count: int) -> IntArray:
    low, span = values.min(), float(np.ptp(values)) or 1.0
    bins: IntArray = np.minimum(((values - low) / span * count).astype(np.int64), count - 1)
    return bins


def _resample(fit: Mixed, resamples: int, seed: int) -> FloatArray:
    """Coefficients [R, C] from tracks drawn with replacement.

    Boxes keep the weights of the fit, which makes the equations stiffer than the loss is; the draws are spread by as
    much (M. Salibián-Barrera, R. Zamar, Bootstrapping robust estimates of regression, Annals of Statistics 30, 2002).
    """
    rng = np.random.default_rng(seed)
    tracks = len(fit.normal)
    counts = rng.multinomial(tracks, np.full(tracks, 1.0 / tracks), size=resamples).astype(np.float64)
    draws = np.array([solve(np.tensordot(count, fit.normal, 1), count @ fit.right) for count in counts])
    spread: FloatArray = fit.beta + fit.flatness * (draws - fit.beta)
    return spread


def _check_growth(beta: FloatArray, draws: FloatArray) -> None:
    if beta[1] <= 3.0 * np.std(draws[:, 1]):
        raise PlaneError("heads do not grow towards the picture's lower edge beyond doubt: too few rows, or too steep")
