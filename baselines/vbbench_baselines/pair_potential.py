"""The pairwise potential V_ik = ‖∇ exp(−d²/2σ²)‖ = (d/σ²) exp(−d²/2σ²) of two people at distance d.

From arXiv 2111.05060, eq. 12 (σ² = 1 m²). In m/s², like D_k: greatest at d = σ, nought for people far apart.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel


@kernel
def potential(squared: float, sigma: float) -> float:
    """V at the squared distance d² in m²."""
    return float(np.sqrt(squared) / sigma**2 * np.exp(-0.5 * squared / sigma**2))


@kernel
def pull(positions: FloatArray, edges: IntArray, strength: float, sigma: float) -> FloatArray:
    """Gradient [K, 2] in 1/m of strength·Σ V over the edges [E, 2], at positions [K, 2] in m."""
    gradient = np.empty(positions.shape)
    for k in range(len(positions)):
        gradient[k, 0], gradient[k, 1] = 0.0, 0.0
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        dx, dy = positions[i, 0] - positions[j, 0], positions[i, 1] - positions[j, 1]
        squared = dx * dx + dy * dy
        distance = max(np.sqrt(squared), 1e-9)
        slope = strength * (1.0 - squared / sigma**2) / sigma**2 * np.exp(-0.5 * squared / sigma**2) / distance
        gradient[i, 0] += slope * dx
        gradient[i, 1] += slope * dy
        gradient[j, 0] -= slope * dx
        gradient[j, 1] -= slope * dy
    return gradient
