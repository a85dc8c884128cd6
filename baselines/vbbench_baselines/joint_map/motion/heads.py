"""How the observer's head turns: it follows the path or wanders, and the sequence tells which.

A head that follows turns towards where its bearer steps, v = c_t − c_{t−1}, with a lag: in the axes of the yaw before,
of which v has the parts F (forward) and L (to the left), it turns by

    f = atan2(κL, (1 − κ)ρ + κF),   κ = (1 − exp(−dt/lag))·‖v‖⁴/(‖v‖⁴ + ρ_0⁴),   ρ² = ‖v‖² + ρ_0²,

where ρ_0 keeps the heads of those who stand where they are. Its yaw increment d is f but for an error, d − f ~
Cauchy(γ_f). A head that wanders turns whatever its bearer does, d ~ Cauchy(γ). One head does the same all the time, so
that all its increments together tell how probable it is, π, that it follows. Either law counts as the normal one that
touches it from above, with the precision π·2/(γ_f² + e²) or (1 − π)·2/(γ² + e²) of a residual e: the step of
expectation and maximisation.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.ego_motion import wrapped
from vbbench_baselines.joint_map.prior import Prior

SLOW = 0.3
"""ρ_0 in m/s; slower people stand."""


class Head(NamedTuple):
    """The prior's numbers of the head.

    Attributes
    ----------
    gain : κ of those who walk; 0 holds the head.
    slow : ρ_0 in m a frame.
    following, wandering : γ_f and γ in rad.
    odds : ln of those that it follows; −inf = no head is believed to.
    """

    gain: float
    slow: float
    following: float
    wandering: float
    odds: float


def head_of(prior: Prior, ego_prior: bool = True) -> Head:
    """The head of ``prior`` at its frame rate; without ``ego_prior`` none follows: the observer may be no person."""
    following = prior.following if ego_prior else 0.0
    return Head(
        gain=1.0 - np.exp(-prior.dt / prior.lag),
        slow=SLOW * prior.dt,
        following=prior.follow_scale,
        wandering=min(prior.yaw_scale, 1e6),
        odds=np.log(following / (1.0 - following)) if following > 0.0 else -np.inf,
    )


@kernel
def turn(before: FloatArray, now: FloatArray, head: Head) -> tuple[float, float, FloatArray]:
    """Residuals d − f and d in rad of two poses [3], and the derivatives [6] of d − f by both, ``before`` first."""
    cos, sin = np.cos(before[2]), np.sin(before[2])
    vx, vy = now[0] - before[0], now[1] - before[1]
    forward, left = cos * vx + sin * vy, cos * vy - sin * vx
    square, slow = vx * vx + vy * vy, head.slow**4
    pace, still = np.sqrt(square + head.slow**2), square**2 + slow
    gain = head.gain * square**2 / still
    n, d = gain * left, (1.0 - gain) * pace + gain * forward
    by_n, by_d = d / (n * n + d * d), -n / (n * n + d * d)
    by_gain = 4.0 * head.gain * square * slow / still**2 * (left * by_n + (forward - pace) * by_d)
    by_left, by_forward, by_step = gain * by_n, gain * by_d, (1.0 - gain) * by_d / pace + by_gain
    fx = cos * by_forward - sin * by_left + vx * by_step
    fy = sin * by_forward + cos * by_left + vy * by_step
    fyaw = left * by_forward - forward * by_left
    moved = wrapped(now[2] - before[2])
    slopes = np.empty(6)
    slopes[0], slopes[1], slopes[2] = fx, fy, -1.0 - fyaw
    slopes[3], slopes[4], slopes[5] = -fx, -fy, 1.0
    return moved - np.arctan2(n, d), moved, slopes


@kernel
def surprise(off: float, moved: float, head: Head) -> tuple[float, float]:
    """−ln of an increment's density if the head follows and if it wanders, both in units of 1/(πγ)."""
    follows = np.log(head.following / head.wandering) + np.log(1.0 + (off / head.following) ** 2)
    return float(follows), float(np.log(1.0 + (moved / head.wandering) ** 2))


@kernel
def evidence(poses: FloatArray, head: Head) -> float:
    """What poses [T, 3] add to the logarithm of the odds that the head follows."""
    odds = 0.0
    for t in range(1, len(poses)):
        off, moved, _ = turn(poses[t - 1], poses[t], head)
        follows, wanders = surprise(off, moved, head)
        odds += wanders - follows
    return odds


@kernel
def weigh(off: float, moved: float, odds: float, head: Head) -> tuple[float, float]:
    """Precisions in 1/rad² of the residuals d − f and d; ``odds`` after everything that tells of the head."""
    follows = 1.0 / (1.0 + np.exp(-odds))
    loose = 2.0 * (1.0 - follows) / (head.wandering**2 + moved * moved)
    return 2.0 * follows / (head.following**2 + off * off), loose


@kernel
def judge(poses: FloatArray, head: Head, odds: float, weights: FloatArray) -> float:
    """Write the precisions [T, 2] of the residuals of poses [T, 3], the first row zero; return their deviance.

    ``odds`` is what frames before added to the logarithm of the odds.
    """
    return judge_some(poses, head, odds, weights, np.ones(len(poses), np.bool_))


@kernel
def judge_some(poses: FloatArray, head: Head, odds: float, weights: FloatArray, counted: BoolArray) -> float:
    """`judge` by the increments into the frames ``counted`` [T] alone; the others' precisions are zero."""
    residuals, following, wandering = np.empty((len(poses), 2)), 0.0, 0.0
    for t in range(1, len(poses)):
        residuals[t, 0], residuals[t, 1], _ = turn(poses[t - 1], poses[t], head)
        if not counted[t]:
            continue
        follows, wanders = surprise(residuals[t, 0], residuals[t, 1], head)
        following, wandering = following + follows, wandering + wanders
    odds += head.odds
    weights[0, 0], weights[0, 1] = 0.0, 0.0
    for t in range(1, len(poses)):
        weights[t, 0], weights[t, 1] = weigh(residuals[t, 0], residuals[t, 1], odds + wandering - following, head)
        if not counted[t]:
            weights[t, 0], weights[t, 1] = 0.0, 0.0
    if np.isinf(odds):
        return wandering
    return float(np.logaddexp(0.0, odds) - np.logaddexp(odds - following, -wandering))


@kernel
def add_slope(poses: FloatArray, head: Head, weights: FloatArray, gradient: FloatArray) -> None:
    """Add what increments with ``weights`` [T, 2] say to the gradient [3T] by poses [T, 3]."""
    for t in range(1, len(poses)):
        off, moved, slopes = turn(poses[t - 1], poses[t], head)
        for i in range(6):
            gradient[3 * t - 3 + i] += weights[t, 0] * off * slopes[i]
        gradient[3 * t + 2] += weights[t, 1] * moved
        gradient[3 * t - 1] -= weights[t, 1] * moved


@kernel
def add_curvature(poses: FloatArray, head: Head, weights: FloatArray, hessian: FloatArray) -> None:
    """Add the upper half of what they say to the Gauss–Newton Hessian [3T, 3T]."""
    for t in range(1, len(poses)):
        _, _, slopes = turn(poses[t - 1], poses[t], head)
        first, here, before = 3 * t - 3, 3 * t + 2, 3 * t - 1
        for i in range(6):
            for j in range(i, 6):
                hessian[first + i, first + j] += weights[t, 0] * slopes[i] * slopes[j]
        hessian[here, here] += weights[t, 1]
        hessian[before, before] += weights[t, 1]
        hessian[before, here] -= weights[t, 1]
