"""How sure pose and positions are: the inverse Gauss–Newton Hessian.

With r_k = z_k + Rᵀ(c − p_k) as in `vbbench_baselines.ego_motion` and J_k = ∂r_k/∂(c, yaw), the pose has the covariance

    Σ = (I/σ_0² + Σ_k J_kᵀ W_k J_k)⁻¹,   W_k = (σ_k² I + N_k)⁻¹ (I/σ_0² on the place only),

where under a reweighted norm the σ² are divided by the weights. A person's position inherits the pose's error as far as
it rests on the measurement: dx_k = R B_k Rᵀ (I, ∂x_k/∂yaw) dpose with B_k = σ_k² W_k, on top of P_k = σ_k² W_k N_k.
"""

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_baselines.compiled import kernel
from vbbench_baselines.ego_motion import VAGUE, invert


@kernel
def pose_covariance(
    pose: FloatArray,
    relative: FloatArray,
    covariance: FloatArray,
    expected: FloatArray,
    std: FloatArray,
    walk_std: float,
) -> FloatArray:
    """[3, 3] of (x, y, yaw) in m, m·rad, rad²; arguments as in `fit_pose`, at the pose [3] found."""
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    prior = max(1.0 / walk_std**2, VAGUE)
    hessian = np.diag(np.array((prior, prior, VAGUE)))
    for k in range(len(std)):
        if np.isnan(std[k]) or np.isnan(relative[k, 0]):
            continue
        v = std[k] ** 2
        rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
        x, y = expected[k, 0] - pose[0], expected[k, 1] - pose[1]
        jacobian = np.array(((sin, -cos, -(x * cos + y * sin)), (cos, sin, x * sin - y * cos)))
        hessian += jacobian.T @ np.array(((rr, rf), (rf, ff))) @ jacobian
    return np.linalg.inv(hessian)


@kernel
def position_covariances(
    pose: FloatArray, sigma: FloatArray, relative: FloatArray, covariance: FloatArray, std: FloatArray
) -> FloatArray:
    """[K, 2, 2] in m², in the world; ``sigma`` [3, 3] is the pose's covariance. NaN for people not observed."""
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    turn = np.array(((sin, cos), (-cos, sin)))
    spread = np.empty((len(std), 2, 2))
    for k in range(len(std)):
        noise = np.array(((covariance[k, 0], covariance[k, 1]), (covariance[k, 1], covariance[k, 2])))
        share = np.eye(2)
        if not np.isnan(std[k]):
            v = std[k] ** 2
            rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
            share = v * np.array(((rr, rf), (rf, ff)))
        right, forward = relative[k]
        # d(c + R z)/d(c, yaw), in the camera's frame
        jacobian = share @ np.array(((sin, -cos, -forward), (cos, sin, right)))
        spread[k] = turn @ (share @ noise + jacobian @ sigma @ jacobian.T) @ turn.T
    return spread
