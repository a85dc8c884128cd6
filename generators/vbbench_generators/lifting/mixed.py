"""Robust regression of head sizes, with an unknown factor a person: some heads are larger, some boxes drawn wider.

Relative sizes y = s/ŝ and rows d = (1, ν, x)/ŝ obey y = d·β + u + e; u is a person's own, e a box's. Integrating u out
(generalised least squares) lets people who walk towards the camera or away from it tell how sizes grow, whatever the
size of their heads. Weights are those of a Student-t loss of e, by iteration.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray

_TAIL = 4.0
_ROUNDS = 60
_SETTLED = 8


class PlaneError(ValueError):
    """Head sizes that tell of no plane; the message says why."""


@dataclass(frozen=True, kw_only=True)
class Mixed:
    """A fit.

    Parameters
    ----------
    beta : [C] coefficients.
    normal, right : [K, C, C] and [K, C] each person's part of the normal equations.
    scatter : robust standard deviation of y about d·β.
    flatness : by how much the normal equations are steeper than the loss.
    """

    beta: FloatArray
    normal: FloatArray
    right: FloatArray
    scatter: float
    flatness: float


def fit_mixed(design: FloatArray, size: FloatArray, share: FloatArray, pair: IntArray, starts: IntArray) -> Mixed:
    """Fit coefficients.

    Parameters
    ----------
    design : [N, C] rows (1, ν, x) in any units.
    size : [N] in px.
    share : [N] what each box counts.
    pair : [N] numbers of groups within one person, over which noise is averaged to tell a person's own share in it.
    starts : [K] where each person begins.

    Raises
    ------
    PlaneError
        If the heads stand on one line.
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
        odd = _oddness(relative - own[person])
        weight = share * (_TAIL + 1.0) / (_TAIL + odd)
        if turn < _SETTLED:
            ratio = _own_share(relative, weight, pair, person)
        elif float(np.abs(beta - before).max()) <= 1e-10 * float(np.abs(beta).max()):
            break
    curvature = share * (_TAIL + 1.0) * (_TAIL - odd) / (_TAIL + odd) ** 2
    flatness = float(weight.sum() / max(curvature.sum(), 0.2 * weight.sum()))
    return Mixed(beta=beta, normal=normal, right=right, scatter=_robust_std(relative), flatness=flatness)


def _oddness(residual: FloatArray) -> FloatArray:
    """Squares [N] of residuals in units of their robust standard deviation."""
    squares: FloatArray = (residual / max(_robust_std(residual), 1e-12)) ** 2
    return squares


def _robust_std(residual: FloatArray) -> float:
    return float(np.median(np.abs(residual))) / 0.6745


def solve(normal: FloatArray, right: FloatArray) -> FloatArray:
    """Solution of the normal equations.

    Raises
    ------
    PlaneError
        If they have none.
    """
    spread = np.sqrt(np.diag(normal))
    if not spread.all() or np.linalg.cond(normal / np.outer(spread, spread)) > 1e10:
        raise PlaneError("all heads stand on one line of the picture, which tells nothing of its perspective")
    return np.asarray(np.linalg.solve(normal, right), np.float64)


def _equations(
    rows: FloatArray, value: FloatArray, weight: FloatArray, starts: IntArray, ratio: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Each person's normal equations, u integrated out, and what the sum of residuals is multiplied by to be u."""
    weighted = rows * weight[:, None]
    mass, first = np.add.reduceat(weight, starts), np.add.reduceat(weighted, starts)
    shrink = ratio / (1.0 + ratio * mass)
    normal = np.stack([np.add.reduceat(weighted * column[:, None], starts) for column in rows.T], axis=2)
    normal -= shrink[:, None, None] * first[:, :, None] * first[:, None, :]
    right = np.add.reduceat(weighted * value[:, None], starts)
    right -= (shrink * np.add.reduceat(weight * value, starts))[:, None] * first
    return normal, right, shrink


def _own_share(relative: FloatArray, weight: FloatArray, pair: IntArray, person: IntArray) -> float:
    """Variance of u over that of a group's mean of e, from the analysis of variance of the groups' means."""
    mass = np.bincount(pair, weight)
    mean = np.bincount(pair, weight * relative) / mass
    owner = np.zeros(len(mass), np.int64)
    owner[pair] = person
    count = np.bincount(owner)
    middle = np.bincount(owner, mean) / count
    within = float(((mean - middle[owner]) ** 2).sum()) / max(len(mean) - len(count), 1)
    between = float(np.var(middle, ddof=1)) - within * float(np.mean(1.0 / count))
    return float(np.clip(between / within, 0.0, 100.0)) if within > 0.0 else 0.0
