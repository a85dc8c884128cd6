"""How observers' heads turn under each way of looking, and the prior of heads under which that is most likely."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from vbbench.generation.generator import Look, Options, Plan
from vbbench.geometry import FloatArray
from vbbench.registry import load
from vbbench_baselines.joint_map.motion.heads import Head, head_of, turn
from vbbench_baselines.joint_map.prior import Prior

LEAST_FOLLOW = 0.03
"""γ_f in rad is kept at or above it: recipes turn heads exactly along the path, unlike real heads."""

FOLLOWING = (0.02, 0.3)
"""Shares of heads that follow by either law: a head is taken to wander until it shows that it does not."""

LAGGING: tuple[Look, ...] = ("motion",)
LOOSE: tuple[Look, ...] = ("follow", "ahead", "glance", "sway")
WANDERING: tuple[Look, ...] = ("wander",)
"""Ways of looking that the two laws of heads that follow, and that of heads that wander, are fitted on."""

HELD_OUT: Look = "glance"
"""The way of looking that no fit sees unless another is held out: what heads really do stands in no prior."""

LAG_RANGES = ((0.05, 5.0), (0.02, 0.1))
"""In s. Heads that stray slowly from the path fit a long lag better, increment by increment; but it is that they look
along the path at all that tells where the path is, and by which they are told from heads that wander."""

SMALLEST_TURN = 1e-4
"""Least scale in rad of yaw increments; people who stand do not turn at all."""


Turns = Mapping[Look, FloatArray]
"""Poses (x, y, yaw) of observers in two frames, one after the other, [N, 2, 3], under each way of looking."""


def turns_of(split: str, seed: int, most: int, held_out: Look | None = HELD_OUT) -> Turns:
    """What about ``most`` observers of a split, spread over it, do under every way of looking but ``held_out``."""
    looks = (*LAGGING, *LOOSE, *WANDERING)
    return {look: _pairs_of(split, look, seed, most) for look in looks if look != held_out}


def _pairs_of(split: str, look: Look, seed: int, most: int) -> FloatArray:
    """An observer's first pair is left out: there is no heading before the first step."""
    plan: Plan = load("generator", split).plan(Options(seed=seed, look=look))
    chosen = range(0, len(plan), max(len(plan) // most, 1))
    walks = [plan.build(index).truth.poses[1:] for index in chosen]
    pairs = np.concatenate([np.stack((poses[:-1], poses[1:]), axis=1) for poses in walks])
    known: FloatArray = pairs[np.isfinite(pairs).all(axis=(1, 2))]
    return known


def fit_head(turns: Sequence[Turns], prior: Prior) -> Prior:
    """``prior`` with the head that is most likely; each split, and each way of looking of a law, counts the same.

    `FOLLOWING` is not fitted: a solver does not know which heads a dataset has. A law of which no way of looking is
    there is not believed in; a head that wanders is then one of which nothing but its increments is known.
    """
    lags, scales, shares = list(prior.lag), list(prior.follow_scale), [0.0, 0.0]
    for law, looks in enumerate((LAGGING, LOOSE)):
        known = [each[look] for each in turns for look in looks if look in each]
        if known:
            lags[law], scales[law] = _fit_follower(known, prior, law, LAG_RANGES[law])
            shares[law] = FOLLOWING[law]
    strays = [each[look] for each in turns for look in WANDERING if look in each]
    strays = strays or [pairs for each in turns for pairs in each.values()]
    wander = fit_cauchy([_residuals(pairs, head_of(prior), 0)[:, 1] for pairs in strays])
    lag, scale, following = (lags[0], lags[1]), (scales[0], scales[1]), (shares[0], shares[1])
    return replace(prior, lag=lag, follow_scale=scale, following=following, yaw_scale=wander)


def _fit_follower(
    known: Sequence[FloatArray], prior: Prior, law: int, lags: tuple[float, float]
) -> tuple[float, float]:
    """Lag in s, within ``lags``, and scale in rad of heads that follow by one ``law``."""

    def follow(lag: float) -> tuple[float, float]:
        head = head_of(replace(prior, lag=(lag, lag)))
        offs = [_residuals(pairs, head, law)[:, 0] for pairs in known]
        scale = max(fit_cauchy(offs), LEAST_FOLLOW)
        return float(np.log(scale) + np.mean([np.mean(np.log1p((off / scale) ** 2)) for off in offs])), scale

    best = minimize_scalar(lambda lag: follow(lag)[0], bounds=lags, method="bounded")
    return float(best.x), follow(float(best.x))[1]


def _residuals(pairs: FloatArray, head: Head, law: int) -> FloatArray:
    """[M, 2] in rad: how far the heads of pairs [M, 2, 3] are off the path, and how far they turned."""
    return np.array([turn(before, now, head, law)[:2] for before, now in np.ascontiguousarray(pairs)])


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
