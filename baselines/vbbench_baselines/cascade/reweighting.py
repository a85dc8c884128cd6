"""Pose and people together under unsquared norms, by iterative reweighting.

The cascade's first energy with D_k = ‖F_k − ẍ_k‖ (arXiv 2111.05060, eq. 11) is, with m_k = ‖x_k − p_k‖/σ_k,

    E_c = Σ_k ρ(m_k) + ½ (z_k − Rᵀ(x_k − c))ᵀ N_k⁻¹ (z_k − Rᵀ(x_k − c)),   ρ(m) = √(m² + ε²),

the observer being one more walker with z = 0, N = 0. ρ is the norm, smooth below ε standard deviations; a walk far from
its expectation pulls no harder than one that is near it. Since ρ is concave in m²,

    ρ(m) ≤ ½ w m² + constant,   w = 1/√(m_now² + ε²),   with equality at m_now,

and the right-hand side is the weighted energy that `fit_pose` and `localise` minimise exactly, over all poses: each
round lowers E_c, and the first is the global least-squares fit, wherever the observer was before. The box terms keep
their own covariances: only the motion's variance σ_k² is divided by w. The gradient of E_c is that of the weighted
energy at the same place.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.ego_motion import VAGUE, Factors, fit_pose, localise


@kernel
def weigh(positions: FloatArray, factors: Factors, softness: float) -> FloatArray:
    """Weights w [K] of positions [K, 2] about what is expected; one where nothing is."""
    off = positions - factors.expected
    squared = (off[:, 0] ** 2 + off[:, 1] ** 2) / factors.std**2
    return np.where(np.isnan(squared), 1.0, 1.0 / np.sqrt(squared + softness**2))


@kernel
def moved(before: FloatArray, after: FloatArray, distance: float) -> bool:
    """Whether a coordinate of a place [K, 2] changed by ``distance`` m or more; NaN counts as unchanged."""
    return bool(np.any(np.abs(after - before) >= distance))


@kernel
def settle(
    factors: Factors, pose: FloatArray, softness: float, rounds: int, tolerance: float, facing: float = VAGUE
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Minimise E_c over the pose, unless it is known, and the people.

    Parameters
    ----------
    pose : [3] the known pose, or NaN.
    softness : ε, in standard deviations.
    facing : information in 1/rad² on the yaw of ``factors.walk``.
    rounds, tolerance : stop after this number of rounds, or when no place (m) and no pose (m, rad) moved further.

    Returns
    -------
    Pose [3], positions [K, 2] in m (NaN = not observed) and the weights [K] of the people's terms.
    """
    relative, covariance, expected, std, walk, walk_std = factors
    free, here = np.isnan(pose[2]), pose.copy()
    people, walk_weight = len(std), 1.0
    weights, spread, positions = np.ones(people), std.copy(), np.full((people, 2), np.inf)
    for _ in range(rounds):
        before, last = here, positions
        weighted = Factors(relative, covariance, expected, spread, walk, walk_std / np.sqrt(walk_weight))
        if free:
            here = fit_pose(weighted, facing)
        positions = localise(here, weighted)
        if np.all(np.abs(here - before) < tolerance) and not moved(last, positions, tolerance):
            break
        weights = weigh(positions, factors, softness)
        spread = std / np.sqrt(weights)
        if free and not np.isinf(walk_std):
            stray = np.hypot(here[0] - walk[0], here[1] - walk[1]) / walk_std
            walk_weight = 1.0 / np.sqrt(stray**2 + softness**2)
    return here, positions, weights
