"""People's positions once the pose is known: measurement and expectation weighed against each other."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.ego_motion import invert


@kernel
def localise(
    pose: FloatArray, relative: FloatArray, covariance: FloatArray, expected: FloatArray, std: FloatArray
) -> FloatArray:
    """Positions of least energy given the pose (see `vbbench_baselines.ego_motion`), the same as a Kalman update.

    Rᵀ(x_k − c) = e_k + σ_k² (σ_k² I + N_k)⁻¹ (z_k − e_k),   e_k = Rᵀ(p_k − c).

    With N_k → 0 a person stands on its ray where its height says; without expectation the measurement is all there is.

    Parameters
    ----------
    pose : [3] (x, y, yaw) in m and rad.
    relative, covariance : [K, 2] measured (right, forward) in m, NaN = not observed, and [K, 3] (rr, rf, ff) in m².
    expected, std : [K, 2] and [K] where people are expected, in m, NaN = unknown.

    Returns
    -------
    [K, 2] world positions in m, NaN = not observed.
    """
    people = len(std)
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    positions = np.empty((people, 2))
    for k in range(people):
        right, forward = relative[k, 0], relative[k, 1]
        if not np.isnan(std[k]):
            dx, dy = expected[k, 0] - pose[0], expected[k, 1] - pose[1]
            e_r, e_f = dx * sin - dy * cos, dx * cos + dy * sin
            v = std[k] ** 2
            rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
            d_r, d_f = right - e_r, forward - e_f
            right, forward = e_r + v * (rr * d_r + rf * d_f), e_f + v * (rf * d_r + ff * d_f)
        positions[k, 0] = pose[0] + right * sin + forward * cos
        positions[k, 1] = pose[1] - right * cos + forward * sin
    return positions
