"""How the observer's head turns: by one of a few laws, and the sequence tells by which.

A head that follows the path turns towards where its bearer steps, v = c_t − c_{t−1}, with a lag: in the axes of the yaw
before, of which v has the parts F (forward) and L (to the left), it turns by

    f = atan2(κL, (1 − κ)ρ + κF),   κ = (1 − exp(−dt/lag))·‖v‖⁴/(‖v‖⁴ + ρ_0⁴),   ρ² = ‖v‖² + ρ_0²,

where ρ_0 keeps the heads of those who stand where they are. Its yaw increment d is f but for an error, d − f ~
Cauchy(γ_m). There are `FOLLOWERS` such laws m: one that lags and is exact, and one that hardly lags and is loose, as
people's heads are. A head that wanders turns whatever its bearer does, d ~ Cauchy(γ). One head does the same all the
time, so that all its increments together tell how probable each law is, π_m. Each counts as the normal one that touches
it from above, with the precision π_m·2/(γ_m² + e²) of a residual e: the step of expectation and maximisation.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.ego_motion import wrapped
from vbbench_baselines.joint_map.prior import Prior

SLOW = 0.3
"""ρ_0 in m/s; slower people stand."""

FOLLOWERS = 2
"""Number of laws by which a head follows."""

NEGLIGIBLE = 1e-4
"""A law that is less probable than this does not move the poses."""


class Head(NamedTuple):
    """The prior's numbers of the head, M of them for the laws by which it may follow.

    Attributes
    ----------
    gains : [M] κ of those who walk; 0 holds the head.
    slow : ρ_0 in m a frame.
    following, wandering : [M] γ_m and γ in rad.
    odds : [M] ln of those that it follows so, against wandering; −inf = no head is believed to.
    """

    gains: FloatArray
    slow: float
    following: FloatArray
    wandering: float
    odds: FloatArray


def head_of(prior: Prior, ego_prior: bool = True) -> Head:
    """The head of ``prior`` at its frame rate; without ``ego_prior`` none follows: the observer may be no person."""
    following = np.array(prior.following) if ego_prior else np.zeros(FOLLOWERS)
    with np.errstate(divide="ignore"):
        odds = np.log(following) - np.log(1.0 - following.sum())
    return Head(
        gains=1.0 - np.exp(-prior.dt / np.array(prior.lag)),
        slow=SLOW * prior.dt,
        following=np.array(prior.follow_scale),
        wandering=min(prior.yaw_scale, 1e6),
        odds=odds,
    )


@kernel
def turn(before: FloatArray, now: FloatArray, head: Head, law: int) -> tuple[float, float, FloatArray]:
    """Residuals d − f and d in rad of two poses [3], and the derivatives [6] of d − f by both, ``before`` first."""
    cos, sin = np.cos(before[2]), np.sin(before[2])
    vx, vy = now[0] - before[0], now[1] - before[1]
    forward, left = cos * vx + sin * vy, cos * vy - sin * vx
    square, slow = vx * vx + vy * vy, head.slow**4
    pace, still = np.sqrt(square + head.slow**2), square**2 + slow
    gain = head.gains[law] * square**2 / still
    n, d = gain * left, (1.0 - gain) * pace + gain * forward
    by_n, by_d = d / (n * n + d * d), -n / (n * n + d * d)
    by_gain = 4.0 * head.gains[law] * square * slow / still**2 * (left * by_n + (forward - pace) * by_d)
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
def strays(before: FloatArray, now: FloatArray, head: Head, residuals: FloatArray) -> None:
    """Write the residuals [M + 1] in rad of two poses [3]: d − f of every law that is believed in, and d."""
    cos, sin = np.cos(before[2]), np.sin(before[2])
    vx, vy = now[0] - before[0], now[1] - before[1]
    forward, left = cos * vx + sin * vy, cos * vy - sin * vx
    square = vx * vx + vy * vy
    pace, walking = np.sqrt(square + head.slow**2), square**2 / (square**2 + head.slow**4)
    moved = wrapped(now[2] - before[2])
    residuals[-1] = moved
    for law in range(len(head.odds)):
        residuals[law] = 0.0
        if head.odds[law] > -np.inf:
            gain = head.gains[law] * walking
            residuals[law] = moved - np.arctan2(gain * left, (1.0 - gain) * pace + gain * forward)


@kernel
def surprise(residuals: FloatArray, head: Head, surprises: FloatArray) -> None:
    """Add −ln of the densities [M + 1] of an increment under every law, in units of 1/(πγ)."""
    for law in range(len(head.odds)):
        scale = head.following[law]
        surprises[law] += np.log(scale / head.wandering * (1.0 + (residuals[law] / scale) ** 2))
    surprises[-1] += np.log(1.0 + (residuals[-1] / head.wandering) ** 2)


@kernel
def evidence(poses: FloatArray, head: Head) -> FloatArray:
    """[M] what poses [T, 3] add to the logarithms of the odds that the head follows so."""
    residuals, surprises = np.empty(FOLLOWERS + 1), np.zeros(FOLLOWERS + 1)
    for t in range(1, len(poses)):
        strays(poses[t - 1], poses[t], head, residuals)
        surprise(residuals, head, surprises)
    told: FloatArray = surprises[-1] - surprises[:-1]
    return told


@kernel
def weigh(residuals: FloatArray, odds: FloatArray, head: Head, weights: FloatArray) -> None:
    """Write the precisions [M + 1] in 1/rad² of ``residuals``; ``odds`` [M] after everything that tells of the head."""
    top = max(np.max(odds), 0.0)
    total = np.exp(-top) + np.sum(np.exp(odds - top))
    for law in range(len(odds)):
        share = np.exp(odds[law] - top) / total
        weights[law] = 0.0
        if share > NEGLIGIBLE:
            weights[law] = 2.0 * share / (head.following[law] ** 2 + residuals[law] ** 2)
    weights[-1] = 2.0 * np.exp(-top) / total / (head.wandering**2 + residuals[-1] ** 2)


@kernel
def judge(poses: FloatArray, head: Head, odds: FloatArray, weights: FloatArray) -> float:
    """Write the precisions [T, M + 1] of the residuals of poses [T, 3], the first row zero; return their deviance.

    ``odds`` [M] is what frames before added to the logarithms of the odds.
    """
    return judge_some(poses, head, odds, weights, np.ones(len(poses), np.bool_))


@kernel
def judge_some(poses: FloatArray, head: Head, odds: FloatArray, weights: FloatArray, counted: BoolArray) -> float:
    """`judge` by the increments into the frames ``counted`` [T] alone; the others' precisions are zero."""
    residuals, surprises = np.empty((len(poses), FOLLOWERS + 1)), np.zeros(FOLLOWERS + 1)
    for t in range(1, len(poses)):
        strays(poses[t - 1], poses[t], head, residuals[t])
        if counted[t]:
            surprise(residuals[t], head, surprises)
    odds = odds + head.odds
    after = odds + surprises[-1] - surprises[:-1]
    weights[0] = 0.0
    for t in range(1, len(poses)):
        if counted[t]:
            weigh(residuals[t], after, head, weights[t])
        else:
            weights[t] = 0.0
    return float(surprises[-1] + _log_sum(odds) - _log_sum(after))


@kernel
def _log_sum(odds: FloatArray) -> float:
    """ln(1 + Σ e^o)."""
    top = max(np.max(odds), 0.0)
    return float(top + np.log(np.exp(-top) + np.sum(np.exp(odds - top))))


@kernel
def add_slope(poses: FloatArray, head: Head, weights: FloatArray, gradient: FloatArray) -> None:
    """Add what increments with ``weights`` [T, M + 1] say to the gradient [3T] by poses [T, 3]."""
    for t in range(1, len(poses)):
        for law in range(len(head.odds)):
            if weights[t, law] > 0.0:
                off, _, slopes = turn(poses[t - 1], poses[t], head, law)
                for i in range(6):
                    gradient[3 * t - 3 + i] += weights[t, law] * off * slopes[i]
        moved = wrapped(poses[t, 2] - poses[t - 1, 2])
        gradient[3 * t + 2] += weights[t, -1] * moved
        gradient[3 * t - 1] -= weights[t, -1] * moved


@kernel
def add_curvature(poses: FloatArray, head: Head, weights: FloatArray, hessian: FloatArray) -> None:
    """Add the upper half of what they say to the Gauss–Newton Hessian [3T, 3T]."""
    for t in range(1, len(poses)):
        first, here, before = 3 * t - 3, 3 * t + 2, 3 * t - 1
        for law in range(len(head.odds)):
            if weights[t, law] > 0.0:
                _, _, slopes = turn(poses[t - 1], poses[t], head, law)
                for i in range(6):
                    for j in range(i, 6):
                        hessian[first + i, first + j] += weights[t, law] * slopes[i] * slopes[j]
        hessian[here, here] += weights[t, -1]
        hessian[before, before] += weights[t, -1]
        hessian[before, here] -= weights[t, -1]
