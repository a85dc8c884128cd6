"""How sure pose and positions are: the inverse Gauss–Newton Hessian.

With r_k = z_k + Rᵀ(c − p_k) as in `common.ego_motion` and J_k = ∂r_k/∂(c, yaw), the pose has the covariance

    Σ = (I/σ_0² + Σ_k J_kᵀ W_k J_k)⁻¹,   W_k = (σ_k² I + N_k)⁻¹ (I/σ_0² on the place only),

where under a reweighted norm the σ² are divided by the weights. A person's position inherits the pose's error as far as
it rests on the measurement: dx_k = R B_k Rᵀ (I, ∂x_k/∂yaw) dpose with B_k = σ_k² W_k, on top of P_k = σ_k² W_k N_k.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.ego_motion import VAGUE, Factors, invert


@kernel
def pose_covariance(pose: FloatArray, factors: Factors, yaw_information: float = VAGUE) -> FloatArray:
    """[3, 3] of (x, y, yaw) in m, m·rad, rad², at the pose [3] that `fit_pose` found with that yaw information."""
    prior = max(1.0 / factors.walk_std**2, VAGUE)
    _, hessian = linearise_people(pose, factors)
    hessian[0, 0] += prior
    hessian[1, 1] += prior
    hessian[2, 2] += yaw_information
    return np.ascontiguousarray(np.linalg.inv(hessian))


@kernel
def linearise_people(pose: FloatArray, factors: Factors) -> tuple[FloatArray, FloatArray]:
    """Gradient [3] and Gauss–Newton Hessian [3, 3] of ½ Σ rᵀWr by (x, y, yaw), without the observer's own terms."""
    relative, covariance, expected, std = factors.relative, factors.covariance, factors.expected, factors.std
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    gradient, hessian = np.zeros(3), np.zeros((3, 3))
    for k in range(len(std)):
        if np.isnan(std[k]) or np.isnan(relative[k, 0]):
            continue
        v = std[k] ** 2
        rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
        x, y = expected[k, 0] - pose[0], expected[k, 1] - pose[1]
        # The rows of J_k: (sin, −cos, −forward), (cos, sin, right) of where the person is expected.
        right, forward = x * sin - y * cos, x * cos + y * sin
        off_r, off_f = relative[k, 0] - right, relative[k, 1] - forward
        pull_r, pull_f = rr * off_r + rf * off_f, rf * off_r + ff * off_f
        gradient[0] += sin * pull_r + cos * pull_f
        gradient[1] += sin * pull_f - cos * pull_r
        gradient[2] += right * pull_f - forward * pull_r
        first = rr * sin + rf * cos, rf * sin + ff * cos
        second = rf * sin - rr * cos, ff * sin - rf * cos
        hessian[0, 0] += sin * first[0] + cos * first[1]
        hessian[0, 1] += sin * second[0] + cos * second[1]
        hessian[1, 1] += sin * second[1] - cos * second[0]
        hessian[0, 2] += right * first[1] - forward * first[0]
        hessian[1, 2] += right * second[1] - forward * second[0]
        hessian[2, 2] += forward * (rr * forward - rf * right) + right * (ff * right - rf * forward)
    hessian[1, 0], hessian[2, 0], hessian[2, 1] = hessian[0, 1], hessian[0, 2], hessian[1, 2]
    return gradient, hessian


@kernel
def position_covariances(pose: FloatArray, sigma: FloatArray, factors: Factors) -> FloatArray:
    """[K, 2, 2] in m², in the world; ``sigma`` [3, 3] is the pose's covariance. NaN for people not observed."""
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    relative, covariance, std = factors.relative, factors.covariance, factors.std
    spread = np.empty((len(std), 2, 2))
    for k in range(len(std)):
        n_rr, n_rf, n_ff = covariance[k, 0], covariance[k, 1], covariance[k, 2]
        rr, rf, ff = 1.0, 0.0, 1.0  # B: all the measurement's, where nothing is expected
        if not np.isnan(std[k]):
            v = std[k] ** 2
            w_rr, w_rf, w_ff = invert(n_rr + v, n_rf, n_ff + v)
            rr, rf, ff = v * w_rr, v * w_rf, v * w_ff
        right, forward = relative[k, 0], relative[k, 1]
        # Rows of B·∂(Rᵀ(c + R z))/∂(c, yaw)
        a, b, c = rr * sin + rf * cos, rf * sin - rr * cos, rf * right - rr * forward
        d, e, f = rf * sin + ff * cos, ff * sin - rf * cos, ff * right - rf * forward
        p_rr = rr * n_rr + rf * n_rf + _product(a, b, c, sigma, a, b, c)
        p_rf = rr * n_rf + rf * n_ff + _product(a, b, c, sigma, d, e, f)
        p_ff = rf * n_rf + ff * n_ff + _product(d, e, f, sigma, d, e, f)
        spread[k, 0, 0] = sin * sin * p_rr + 2.0 * sin * cos * p_rf + cos * cos * p_ff
        spread[k, 0, 1] = spread[k, 1, 0] = sin * cos * (p_ff - p_rr) + (sin * sin - cos * cos) * p_rf
        spread[k, 1, 1] = cos * cos * p_rr - 2.0 * sin * cos * p_rf + sin * sin * p_ff
    return spread


@kernel
def _product(a: float, b: float, c: float, sigma: FloatArray, d: float, e: float, f: float) -> float:
    """(a, b, c) Σ (d, e, f)ᵀ."""
    x = a * sigma[0, 0] + b * sigma[1, 0] + c * sigma[2, 0]
    y = a * sigma[0, 1] + b * sigma[1, 1] + c * sigma[2, 1]
    z = a * sigma[0, 2] + b * sigma[1, 2] + c * sigma[2, 2]
    return float(x * d + y * e + z * f)
