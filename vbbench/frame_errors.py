"""The four errors of single frames, for pictures and plots over time; scores are made of rows (`vbbench.scoring`)."""

import numpy as np

from vbbench.arrays import BoolArray, FloatArray
from vbbench.metrics import position_error, relative_position_error, rotation_error, translation_error

LABELS = {"dx": "Δx", "dx_rel": "Δx̃", "dr": "Δr", "dt": "Δt"}
"""How the errors are written, by their key in files."""

UNITS = {"dx": "m", "dx_rel": "m", "dr": "rad", "dt": "m"}


def frame_errors(
    poses: FloatArray, positions: FloatArray, true_poses: FloatArray, true_positions: FloatArray, counted: BoolArray
) -> dict[str, FloatArray]:
    """Errors of each frame by their key; NaN where there is no answer or nobody counts.

    Parameters
    ----------
    poses, true_poses : [..., 3] in m and rad.
    positions, true_positions : [..., K, 2] in m.
    counted : [..., K] who counts in Δx and Δx̃; of these, those with an estimate and a true position do.
    """
    off = position_error(positions, true_positions)
    apart = relative_position_error(positions, poses[..., None, :], true_positions, true_poses[..., None, :])
    return {
        "dx": _mean(off, counted),
        "dx_rel": _mean(apart, counted),
        "dr": rotation_error(poses, true_poses),
        "dt": translation_error(poses, true_poses),
    }


def _mean(values: FloatArray, counted: BoolArray) -> FloatArray:
    """Mean over the last axis of those values that count and are there, NaN without any."""
    use = counted & np.isfinite(values)
    total, number = np.where(use, values, 0.0).sum(axis=-1), use.sum(axis=-1)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)
