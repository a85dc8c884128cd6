"""Social-force terms: how people who walk near one another take over each other's velocity."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel


@kernel
def adapt_velocities(positions: FloatArray, velocities: FloatArray, radius: float, rate: float) -> FloatArray:
    """Change of velocity rate·(w_k − v_k), w_k the mean velocity of everybody within ``radius``, k included.

    Parameters
    ----------
    positions, velocities : [K, 2] in m and m/s; people of unknown velocity (NaN) are left out and do not change.
    radius : in m.
    rate : dt/η; above 1 the mean would be overshot, so it is cut there.

    Returns
    -------
    [K, 2] in m/s.
    """
    change = np.empty(velocities.shape)
    for k in range(len(positions)):
        change[k, 0], change[k, 1] = 0.0, 0.0
        if np.isnan(velocities[k, 0]):
            continue
        total_x, total_y, count = 0.0, 0.0, 0
        for i in range(len(positions)):
            dx = positions[i, 0] - positions[k, 0]
            if not abs(dx) < radius:  # spares most of a large crowd the root
                continue
            near = np.hypot(dx, positions[i, 1] - positions[k, 1]) < radius
            if near and not np.isnan(velocities[i, 0]):
                total_x, total_y, count = total_x + velocities[i, 0], total_y + velocities[i, 1], count + 1
        change[k, 0] = min(rate, 1.0) * (total_x / count - velocities[k, 0])
        change[k, 1] = min(rate, 1.0) * (total_y / count - velocities[k, 1])
    return change
