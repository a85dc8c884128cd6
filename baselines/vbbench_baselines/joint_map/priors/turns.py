"""How observers' heads turn under each way of looking, and the prior of heads under which that is most likely."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vbbench.generation.generator import Look, Options, Plan
from vbbench.geometry import FloatArray
from vbbench.registry import load
from vbbench_baselines.joint_map.motion.heads import Head, head_of, turn
from vbbench_baselines.joint_map.prior import Prior

LEAST_FOLLOW = 0.03
"""γ_f in rad is kept at or above it: recipes turn heads exactly along the path, unlike real heads."""

FOLLOWING = 0.1
"""Share of heads that follow: a head is taken to wander until it shows that it does not."""

LAG_RANGE = (0.1, 5.0)
"""In s: from at once to hardly."""

SMALLEST_TURN = 1e-4
"""Least scale in rad of yaw increments; people who stand do not turn at all."""


class Turns(NamedTuple):
    """Poses (x, y, yaw) of observers in two frames, one after the other.

    Attributes
    ----------
    motion, wander : [M, 2, 3] and [N, 2, 3] of heads that follow the path and that wander.
    """

    motion: FloatArray
    wander: FloatArray


def turns_of(split: str, seed: int, most: int) -> Turns:
    """What about ``most`` observers of a split, spread over it, do under each way of looking."""
    return Turns(*(_pairs_of(split, look, seed, most) for look in ("motion", "wander")))


def _pairs_of(split: str, look: Look, seed: int, most: int) -> FloatArray:
    """An observer's first pair is left out: there is no heading before the first step."""
    plan: Plan = load("generator", split).plan(Options(seed=seed, look=look))
    chosen = range(0, len(plan), max(len(plan) // most, 1))
    walks = [plan.build(index).truth.poses[1:] for index in chosen]
    pairs = np.concatenate([np.stack((poses[:-1], poses[1:]), axis=1) for poses in walks])
    known: FloatArray = pairs[np.isfinite(pairs).all(axis=(1, 2))]
    return known


def fit_head(turns: Sequence[Turns], prior: Prior) -> Prior:
    """``prior`` with the head that is most likely; each split counts the same.

    `FOLLOWING` is not fitted: a solver does not know which heads a dataset has.
    """

    def follow(lag: float) -> tuple[float, Prior]:
        head = head_of(replace(prior, lag=lag))
        offs = [_residuals(pairs.motion, head)[:, 0] for pairs in turns]
        scale = max(fit_cauchy(offs), LEAST_FOLLOW)
        cost = np.log(scale) + np.mean([np.mean(np.log1p((off / scale) ** 2)) for off in offs])
        return float(cost), replace(prior, lag=lag, follow_scale=scale)

    best = minimize_scalar(lambda lag: follow(lag)[0], bounds=LAG_RANGE, method="bounded")
    wander = fit_cauchy([_residuals(pairs.wander, head_of(prior))[:, 1] for pairs in turns])
    return replace(follow(float(best.x))[1], yaw_scale=wander, following=FOLLOWING)


def _residuals(pairs: FloatArray, head: Head) -> FloatArray:
    """[M, 2] in rad: how far the heads of pairs [M, 2, 3] are off the path, and how far they turned."""
    return np.array([turn(before, now, head)[:2] for before, now in np.ascontiguousarray(pairs)])


def fit_cauchy(turns: Sequence[FloatArray]) -> float:
    """The scale of a Cauchy distribution about zero under which increments are most likely; each array counts the same.

    The scale s solves mean 2x²/(x² + s²) = 1.
    """
    low, high = SMALLEST_TURN, 2.0 * np.pi
    while high / low > 1.0 + 1e-9:
        middle = float(np.sqrt(low * high))
        excess = np.mean([np.mean(2.0 * x * x / (x * x + middle * middle)) for x in turns]) - 1.0
        low, high = (middle, high) if excess > 0.0 else (low, middle)
    return low
