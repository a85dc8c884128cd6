"""How observers' heads turn under each way of looking, and the prior of heads under which that is most likely."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from vbbench.generation.generator import Look, Options, Plan
from vbbench.geometry import FloatArray, wrap_angle
from vbbench.registry import load
from vbbench_baselines.joint_map.motion.heads import head_of, turn
from vbbench_baselines.joint_map.prior import Prior

LEAST_FOLLOW = (0.03, 0.1)
"""γ_1 and γ_2 in rad are kept at or above them: recipes turn heads exactly along the path, unlike real heads; and a
head that points beside the path does so for a while, so that its increments together say less than each of them."""

FOLLOWING = (0.02, 0.3)
"""Shares of heads that follow by either law: a head is taken to wander until it shows that it does not."""

LAGGING: tuple[Look, ...] = ("motion",)
LOOSE: tuple[Look, ...] = ("follow", "ahead", "glance", "sway")
WANDERING: tuple[Look, ...] = ("wander",)
"""Ways of looking that the two laws of heads that follow, and that of heads that wander, are fitted on."""

HELD_OUT: Look = "glance"
"""The way of looking that no fit sees unless another is held out: what heads really do stands in no prior."""

LAG_RANGE, AT_ONCE = (0.05, 5.0), 0.05
"""In s: of the law that lags, and of the other. Heads that stray slowly from the path fit a long lag better, increment
by increment; but it is that they look along the path at all that tells where it is, and wandering heads from them."""

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
    lagging, loose, wandering = (
        [each[look] for each in turns for look in looks if look in each] for looks in (LAGGING, LOOSE, WANDERING)
    )
    lag, exact = _fit_lag(lagging, prior) if lagging else (prior.lag[0], prior.follow_scale[0])
    about = max(fit_cauchy(_strays(loose, prior, AT_ONCE)), LEAST_FOLLOW[1]) if loose else prior.follow_scale[1]
    turned = wandering or [pairs for each in turns for pairs in each.values()]
    wander = fit_cauchy([wrap_angle(np.diff(pairs[..., 2], axis=1)) for pairs in turned])
    shares = (FOLLOWING[0] if lagging else 0.0, FOLLOWING[1] if loose else 0.0)
    return replace(prior, lag=(lag, AT_ONCE), follow_scale=(exact, about), following=shares, yaw_scale=wander)


def _fit_lag(known: Sequence[FloatArray], prior: Prior) -> tuple[float, float]:
    """Lag in s and scale in rad of heads that follow the path exactly."""

    def follow(lag: float) -> tuple[float, float]:
        offs = _strays(known, prior, lag)
        scale = max(fit_cauchy(offs), LEAST_FOLLOW[0])
        return float(np.log(scale) + np.mean([np.mean(np.log1p((off / scale) ** 2)) for off in offs])), scale

    best = minimize_scalar(lambda lag: follow(lag)[0], bounds=LAG_RANGE, method="bounded")
    return float(best.x), follow(float(best.x))[1]


def _strays(known: Sequence[FloatArray], prior: Prior, lag: float) -> list[FloatArray]:
    """How far in rad the heads of pairs [M, 2, 3] are off a path that they follow with a ``lag``."""
    head = head_of(replace(prior, lag=(lag, lag)))
    return [np.array([turn(before, now, head, 0)[0] for before, now in np.ascontiguousarray(pairs)]) for pairs in known]


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
