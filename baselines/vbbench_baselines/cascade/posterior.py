"""How the cascade's energies rise away from their minimum: −ln p of the observer's pose, and people's beliefs.

The first energy (`vbbench_baselines.cascade.reweighting`) at a pose (c, R), each person minimised out, is

    E_c(c, R) = ρ(m_0) + Σ_k min over x of ρ(‖x − p_k‖/σ_k) + ½‖z_k − Rᵀ(x − c)‖²_{N_k⁻¹}.

Since ρ(m) = √(m² + ε²) is the least over v > 0 of ½(m²/v + v + ε²/v), a person's place can be eliminated as under
squared norms, with σ_k² v for σ_k². Along the principal axes of N_k, in the camera's frame, with
r_k = z_k + Rᵀ(c − p_k), what remains is one convex function of one number,

    g(v) = ½ [ r_1²/(σ²v + n_1) + r_2²/(σ²v + n_2) + v + ε²/v ],

whose slope is concave: Newton's method from the left of its zero never steps over it. With N_k = 0 it is ρ itself.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.cascade.message_passing import pass_beliefs
from vbbench_baselines.common.ego_motion import VAGUE, Factors

_FINE = 1e-4
"""Newton's method stops at this relative step; the energy's own error is its square."""


@kernel
def pose_energies(poses: FloatArray, factors: Factors, softness: float, facing: float) -> FloatArray:
    """−ln p [N] of the observer's poses [N, 3] in m and rad, up to a constant, people's places minimised out.

    Parameters
    ----------
    softness : ε, in standard deviations.
    facing : information in 1/rad² on the yaw of ``factors.walk``.
    """
    people, count = _along_axes(factors)
    walk, walk_std, energies = factors.walk, factors.walk_std, np.empty(len(poses))
    for n in range(len(poses)):
        x, y, yaw = poses[n, 0], poses[n, 1], poses[n, 2]
        sin, cos = np.sin(yaw), np.cos(yaw)
        moved = (x - walk[0]) ** 2 + (y - walk[1]) ** 2
        total = facing * (1.0 - np.cos(yaw - walk[2]))
        if np.isinf(walk_std):
            total += 0.5 * VAGUE * moved
        else:
            total += np.sqrt(moved / walk_std**2 + softness**2)
        for k in range(count):
            p_x, p_y, variance, z_1, z_2, along, across, n_1, n_2 = people[k]
            dx, dy = p_x - x, p_y - y
            right, forward = dx * sin - dy * cos, dx * cos + dy * sin
            r_1 = z_1 - (along * right + across * forward)
            r_2 = z_2 - (along * forward - across * right)
            total += _least(r_1 * r_1, r_2 * r_2, variance, n_1, n_2, softness)
        energies[n] = total
    return energies


@kernel
def _along_axes(factors: Factors) -> tuple[FloatArray, int]:
    """The usable people's terms along the principal axes of their N, a row each, and how many there are.

    The expected place and its variance; z along the axes; the first axis (right, forward); the variances along both.
    """
    relative, covariance, expected, std = factors.relative, factors.covariance, factors.expected, factors.std
    rows, count = np.empty((len(std), 9)), 0
    for k in range(len(std)):
        if np.isnan(std[k]) or np.isnan(relative[k, 0]):
            continue
        rr, rf, ff = covariance[k, 0], covariance[k, 1], covariance[k, 2]
        angle = 0.5 * np.arctan2(2.0 * rf, rr - ff)
        along, across = np.cos(angle), np.sin(angle)
        middle, half = 0.5 * (rr + ff), np.hypot(0.5 * (rr - ff), rf)
        row = rows[count]
        row[0], row[1], row[2] = expected[k, 0], expected[k, 1], std[k] ** 2
        row[3] = along * relative[k, 0] + across * relative[k, 1]
        row[4] = along * relative[k, 1] - across * relative[k, 0]
        row[5], row[6], row[7], row[8] = along, across, middle + half, max(middle - half, 0.0)
        count += 1
    return rows, count


@kernel
def _least(s_1: float, s_2: float, variance: float, n_1: float, n_2: float, softness: float) -> float:
    """The least g(v) of squared distances along the axes; n_1 ≥ n_2."""
    squared = softness**2
    if n_1 <= 1e-9 * variance:
        return float(np.sqrt((s_1 + s_2) / variance + squared))
    v = max(softness, np.sqrt((s_1 + s_2) / variance) - n_1 / variance)
    for _ in range(50):
        t_1, t_2, bend = 1.0 / (variance * v + n_1), 1.0 / (variance * v + n_2), squared / (v * v)
        pull_1, pull_2 = s_1 * variance * t_1 * t_1, s_2 * variance * t_2 * t_2
        slope = 1.0 - bend - pull_1 - pull_2
        step = -slope / (2.0 * (bend / v + variance * (pull_1 * t_1 + pull_2 * t_2)))
        v += step
        if abs(step) <= _FINE * v:
            break
    return float(0.5 * (s_1 / (variance * v + n_1) + s_2 / (variance * v + n_2) + v + squared / v))


@kernel
def ray_beliefs(
    energies: FloatArray, edges: IntArray, pair: FloatArray, rounds: int, damping: float, tolerance: float
) -> FloatArray:
    """Probability [K, S] of each person's samples by the messages: exp(−belief), of sum 1; the rest as `pass_messages`.

    Beliefs are min-marginals: a sample has the probability of the best choice of all others beside it.
    """
    beliefs, _ = pass_beliefs(energies, edges, pair, rounds, damping, tolerance)
    for k in range(len(beliefs)):
        beliefs[k] = np.exp(np.min(beliefs[k]) - beliefs[k])
        beliefs[k] /= np.sum(beliefs[k])
    return beliefs
