"""Fits the plane of head sizes, robust against outliers; neither long tracks nor crowded places dominate it.

Some heads are larger, and some boxes are drawn wider, so the regression has an unknown factor per person. Relative
sizes y = s/ŝ and rows d = (1, ν, x)/ŝ obey y = d·β + u + e; u belongs to a person, e to a box. With u integrated out
(generalised least squares), people who walk towards the camera or away from it show how sizes grow, whatever the size
of their heads. Weights are those of a Student-t loss of e, by iteration.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench_generators.lifting.heads import Heads, SizePlane

_TAIL = 4.0
_ROUNDS = 60
_CONVERGED = 8


@dataclass(frozen=True, kw_only=True)
class Mixed:
    """A fit of the mixed model.

    Parameters
    ----------
    beta : [C] coefficients.
    normal, right : [K, C, C] and [K, C] each person's part of the normal equations.
    scatter : robust standard deviation of y about d·β.
    flatness : ratio of the curvature of the reweighted equations to that of the loss.
    """

    beta: FloatArray
    normal: FloatArray
    right: FloatArray
    scatter: float
    flatness: float


def fit_mixed(design: FloatArray, size: FloatArray, share: FloatArray, pair: IntArray, starts: IntArray) -> Mixed:
    """Fit the coefficients β.

    Raises ValueError if the heads lie on one line.

    Parameters
    ----------
    design : [N, C] rows (1, ν, x) in any units.
    size : [N] in px.
    share : [N] weight of each box.
    pair : [N] numbers of groups within one person, over which noise is averaged to separate u from e.
    starts : [K] first row of each person.
    """
    person = np.repeat(np.arange(len(starts)), np.diff(np.r_[starts, len(size)]))
    floor = 0.05 * float(np.median(size))
    fitted, beta = np.full(len(size), float(np.mean(size))), np.zeros(design.shape[1])
    weight, ratio = share, 0.0
    for turn in range(_ROUNDS):
        normal, right, shrink = _equations(design / fitted[:, None], size / fitted, weight, starts, ratio)
        before, beta = beta, solve(normal.sum(axis=0), right.sum(axis=0))
        fitted = np.maximum(design @ beta, floor)
        relative = size / fitted - 1.0
        own = shrink * np.add.reduceat(weight * relative, starts)
        residual = relative - own[person]
        odd: FloatArray = (residual / max(_robust_std(residual), 1e-12)) ** 2
        weight = share * (_TAIL + 1.0) / (_TAIL + odd)
        if turn < _CONVERGED:
            ratio = _own_share(relative, weight, pair, person)
        elif float(np.abs(beta - before).max()) <= 1e-10 * float(np.abs(beta).max()):
            break
    curvature = share * (_TAIL + 1.0) * (_TAIL - odd) / (_TAIL + odd) ** 2
    flatness = float(weight.sum() / max(curvature.sum(), 0.2 * weight.sum()))
    return Mixed(beta=beta, normal=normal, right=right, scatter=_robust_std(relative), flatness=flatness)


def _robust_std(residual: FloatArray) -> float:
    return float(np.median(np.abs(residual))) / 0.6745


def solve(normal: FloatArray, right: FloatArray) -> FloatArray:
    """Solution of the normal equations.

    Raises ValueError if they are singular.
    """
    spread = np.sqrt(np.diag(normal))
    if not spread.all() or np.linalg.cond(normal / np.outer(spread, spread)) > 1e10:
        raise ValueError("all heads are on one line of the picture, which does not determine its perspective")
    return np.asarray(np.linalg.solve(normal, right), np.float64)


def _equations(
    rows: FloatArray, value: FloatArray, weight: FloatArray, starts: IntArray, ratio: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Each person's normal equations with u integrated out, and the factor from the sum of residuals to u."""
    weighted = rows * weight[:, None]
    mass, first = np.add.reduceat(weight, starts), np.add.reduceat(weighted, starts)
    shrink = ratio / (1.0 + ratio * mass)
    normal = np.stack([np.add.reduceat(weighted * column[:, None], starts) for column in rows.T], axis=2)
    normal -= shrink[:, None, None] * first[:, :, None] * first[:, None, :]
    right = np.add.reduceat(weighted * value[:, None], starts)
    right -= (shrink * np.add.reduceat(weight * value, starts))[:, None] * first
    return normal, right, shrink


def _own_share(relative: FloatArray, weight: FloatArray, pair: IntArray, person: IntArray) -> float:
    """Ratio of the variance of u to that of a group's mean of e, from an analysis of variance of the groups' means."""
    mass = np.bincount(pair, weight)
    mean = np.bincount(pair, weight * relative) / mass
    owner = np.zeros(len(mass), np.int64)
    owner[pair] = person
    count = np.bincount(owner)
    middle = np.bincount(owner, mean) / count
    within = float(((mean - middle[owner]) ** 2).sum()) / max(len(mean) - len(count), 1)
    between = float(np.var(middle, ddof=1)) - within * float(np.mean(1.0 / count))
    return float(np.clip(between / within, 0.0, 100.0)) if within > 0.0 else 0.0


LEAST_TRACKS = 8
_CELLS = (12, 8)
_MANY = 50


@dataclass(frozen=True, kw_only=True)
class PlaneFit:
    """A fitted plane of head sizes, with its uncertainty.

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
        return np.cov(draws, rowvar=False)


def fit_plane(heads: Heads, size: FloatArray, *, resamples: int, seed: int) -> PlaneFit:
    """Fit the plane to the sizes [N] in px of heads.

    Minimises a Student-t loss of the residuals (s − ŝ)/ŝ, since the noise of a box grows with its size. They are
    relative to the fitted size ŝ: relative to the measured one, boxes that are small by chance would weigh more.

    Raises ValueError if there are too few tracks, or sizes do not grow downwards significantly.

    Parameters
    ----------
    resamples, seed : number of resamplings of tracks for the covariance, and their seed.
    """
    x, nu, track = heads.x, heads.nu, heads.track
    starts = np.flatnonzero(np.r_[True, track[1:] != track[:-1]])
    if len(starts) < LEAST_TRACKS:
        raise ValueError(f"{len(starts)} tracks are too few to calibrate a camera; {LEAST_TRACKS} are the least")
    scale = float(np.hypot(np.ptp(x), np.ptp(nu))) or 1.0
    share, pair = _shares(x, nu, track)
    fit = fit_mixed(np.stack([np.ones_like(x), nu / scale, x / scale], axis=1), size, share, pair, starts)
    draws = _resample(fit, resamples, seed)
    if fit.beta[1] <= 3.0 * np.std(draws[:, 1]):
        raise ValueError("heads do not grow significantly towards the picture's lower edge: too few rows, or too steep")
    planes = tuple(_plane(draw, scale) for draw in draws)
    return PlaneFit(plane=_plane(fit.beta, scale), scatter=fit.scatter, resampled=planes)


def _plane(beta: FloatArray, scale: float) -> SizePlane:
    a, b, c = beta.tolist()
    return SizePlane(a=a, b=b / scale, c=c / scale)


def _shares(x: FloatArray, nu: FloatArray, track: IntArray) -> tuple[FloatArray, IntArray]:
    """Weight of each box [N], and the number of its group [N]: one person's boxes in one cell of the picture.

    A group of n boxes shares n / (n + 50) of a vote, since their noise is correlated, divided by the fourth root of the
    number of people ever in that cell. The mean vote is 1.
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

    Boxes keep the weights of the fit, which makes the equations stiffer than the loss; the draws are spread to correct
    this (M. Salibián-Barrera, R. Zamar, Bootstrapping robust estimates of regression, Annals of Statistics 30, 2002).
    """
    rng = np.random.default_rng(seed)
    tracks = len(fit.normal)
    counts = rng.multinomial(tracks, np.full(tracks, 1.0 / tracks), size=resamples).astype(np.float64)
    draws = np.array([solve(np.tensordot(count, fit.normal, 1), count @ fit.right) for count in counts])
    return fit.beta + fit.flatness * (draws - fit.beta)
