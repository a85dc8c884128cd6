"""Errors of estimates against truth, in m and rad, of rows and of single frames. No alignment is ever applied.

x0 is the observer's ground-plane position, x_k a person's, * marks truth (DESIGN section 6, after arXiv 2111.05060).
All functions are pure, take any leading shape and map NaN to NaN.
"""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, wrap_angle


def translation_error(poses: FloatArray, true_poses: FloatArray) -> FloatArray:
    """Δt = ‖x0 − x0*‖: poses [..., 3] (x, y, yaw) in m and rad → [...] in m."""
    return _distance(poses[..., :2], true_poses[..., :2])


def rotation_error(poses: FloatArray, true_poses: FloatArray) -> FloatArray:
    """Δr = |wrap(yaw − yaw*)|: poses [..., 3] → [...] in rad, within [0, π].

    For rotations of the plane this is arccos(½ tr(R R*ᵀ)); the paper prints the form for three dimensions.
    """
    return np.abs(wrap_angle(poses[..., 2] - true_poses[..., 2]))


def position_error(positions: FloatArray, true_positions: FloatArray) -> FloatArray:
    """‖x_k − x_k*‖ of each person: positions [..., 2] in m → [...] in m. Δx is its mean over people."""
    return _distance(positions, true_positions)


def relative_position_error(
    positions: FloatArray, poses: FloatArray, true_positions: FloatArray, true_poses: FloatArray
) -> FloatArray:
    """‖(x_k − x0) − (x_k* − x0*)‖ of each person, in world axes; Δx̃ is its mean over people.

    Parameters
    ----------
    positions, true_positions : [..., 2] in m.
    poses, true_poses : [..., 3] the observer's pose at the same instant, in m and rad.

    Returns
    -------
    [...] in m.
    """
    return _distance(positions - poses[..., :2], true_positions - true_poses[..., :2])


def drift(
    start: FloatArray, end: FloatArray, true_start: FloatArray, true_end: FloatArray, seconds: float
) -> tuple[FloatArray, FloatArray]:
    """Relative pose error, a second: how far the estimated motion departs from the true one.

    With m = R(yaw_start)ᵀ (x0_end − x0_start), the motion in the frame of its start:
    ‖m − m*‖ / seconds and |wrap((yaw_end − yaw_start) − (yaw_end* − yaw_start*))| / seconds.

    Parameters
    ----------
    start, end, true_start, true_end : poses [..., 3] in m and rad.
    seconds : time from start to end.

    Returns
    -------
    [...] in m/s and [...] in rad/s.
    """
    motion = _distance(_motion(start, end), _motion(true_start, true_end))
    turn = np.abs(wrap_angle((end[..., 2] - start[..., 2]) - (true_end[..., 2] - true_start[..., 2])))
    return motion / seconds, turn / seconds


def _distance(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.hypot(a[..., 0] - b[..., 0], a[..., 1] - b[..., 1])


def _motion(start: FloatArray, end: FloatArray) -> FloatArray:
    dx, dy = end[..., 0] - start[..., 0], end[..., 1] - start[..., 1]
    cos, sin = np.cos(start[..., 2]), np.sin(start[..., 2])
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=-1)


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
