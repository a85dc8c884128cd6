"""What is unknown of the camera, and how it changes: pitch, roll, height over the ground, and column offset.

Each starts within a standard deviation of the calibration and makes Student-t steps, small ones on a smooth road.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.real_camera.cues import FRAME, PITCH

UNKNOWNS = FRAME - PITCH


class Drift(NamedTuple):
    """Means and standard deviations [4] at the start, scales [4] of the steps, and their degrees of freedom."""

    mean: FloatArray
    std: FloatArray
    step: FloatArray
    nu: float


@kernel
def drift_deviance(frames: FloatArray, drift: Drift) -> float:
    """−ln of the density of what the ``frames`` [T, 7] say of the camera, up to a constant."""
    total = 0.0
    for a in range(UNKNOWNS):
        total += 0.5 * ((frames[0, PITCH + a] - drift.mean[a]) / drift.std[a]) ** 2
        for t in range(1, len(frames)):
            moved = (frames[t, PITCH + a] - frames[t - 1, PITCH + a]) / drift.step[a]
            total += 0.5 * (drift.nu + 1.0) * np.log(1.0 + moved * moved / drift.nu)
    return total


@kernel
def add_drift(frames: FloatArray, drift: Drift, gradient: FloatArray, hessian: FloatArray) -> None:
    """Add its slope to the gradient [7T] and its curvature to the lower half of the Hessian [7T, 7T]."""
    for a in range(UNKNOWNS):
        column = PITCH + a
        weight = 1.0 / drift.std[a] ** 2
        gradient[column] += weight * (frames[0, column] - drift.mean[a])
        hessian[column, column] += weight
        for t in range(1, len(frames)):
            here, before = FRAME * t + column, FRAME * (t - 1) + column
            moved = frames[t, column] - frames[t - 1, column]
            weight = (drift.nu + 1.0) / (drift.nu * drift.step[a] ** 2 + moved * moved)
            gradient[here] += weight * moved
            gradient[before] -= weight * moved
            hessian[here, here] += weight
            hessian[before, before] += weight
            hessian[here, before] -= weight
