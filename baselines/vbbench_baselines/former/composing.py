"""Between the world, in float64, and what the network sees from the last pose, in float32."""

import math

import numpy as np
from numpy.typing import NDArray

from vbbench.estimate import LARGEST
from vbbench.geometry import FloatArray, pose_levers
from vbbench.sequence import Odometry
from vbbench_baselines.common.odometry import SMALLEST, SURE
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.pose_fit import Measured, Motion

NARROWEST, WIDEST = -7.0, 3.0
"""ln of the least and greatest standard deviations in m and rad that are learned."""


def seen_from(pose: FloatArray, positions: FloatArray) -> NDArray[np.complex64]:
    """Positions [..., 2] in the world as forward + i·left of a pose [3]; 0 for NaN."""
    apart = np.nan_to_num(positions) - pose[:2]
    turned: NDArray[np.complex128] = (apart[..., 0] + 1j * apart[..., 1]) * np.exp(-1j * pose[2])
    return np.where(np.isnan(positions[..., 0]), 0.0, turned).astype(np.complex64)


def in_world(pose: FloatArray, places: Array) -> FloatArray:
    """The inverse of `seen_from`: [..., 2], within what can be an answer."""
    turned = np.asarray(places, np.complex128) * np.exp(1j * pose[2])
    positions = np.stack([pose[0] + turned.real, pose[1] + turned.imag], axis=-1)
    made: FloatArray = np.minimum(np.maximum(positions, -LARGEST), LARGEST)
    return made


def motion_between(before: FloatArray, pose: FloatArray) -> Motion:
    """The motion from one pose [3] to another."""
    turn = math.remainder(pose[2] - before[2], math.tau)
    return Motion(seen_from(before, pose[:2])[()], np.float32(turn))


def moved(pose: FloatArray, motion: Motion) -> FloatArray:
    """The pose [3] after a motion; the yaw is within ±π."""
    x, y = in_world(pose, motion.step)
    return np.array((x, y, math.remainder(pose[2] + float(motion.turn), math.tau)))


def measured_motion(odometry: Odometry | None) -> Measured | None:
    """What odometry says of the newest frame."""
    if odometry is None or not np.isfinite(odometry.motions[-1]).all():
        return None
    variances = odometry.covariances[-1].diagonal() + SMALLEST**2
    if not np.isfinite(odometry.covariances[-1]).all():
        return None
    forward, left, turn = odometry.motions[-1].tolist()
    motion = Motion(np.complex64(complex(forward, left)), np.float32(math.remainder(turn, math.tau)))
    return Measured(motion, (1.0 / variances).astype(np.float32), np.float32(variances.max() < SURE**2))


def pose_covariance(pose: FloatArray, spread: Array) -> FloatArray:
    """[3, 3] of a pose [3] whose standard deviations ahead, to the left and in yaw are exp of ``spread`` [3]."""
    ahead, left, yaw = np.exp(2.0 * np.clip(spread.astype(np.float64), NARROWEST, WIDEST)).tolist()
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    across = (ahead - left) * cos * sin
    return np.array(
        (
            (ahead * cos**2 + left * sin**2, across, 0.0),
            (across, ahead * sin**2 + left * cos**2, 0.0),
            (0.0, 0.0, yaw),
        )
    )


def place_covariances(pose: FloatArray, rays: Array, spread: Array) -> FloatArray:
    """[K, 2, 2] of places whose standard deviations along and across rays [K] are exp of ``spread`` [K, 2]."""
    variances = np.exp(2.0 * np.clip(spread.astype(np.float64), NARROWEST, WIDEST))
    along = rays * np.exp(1j * pose[2])
    axes = np.stack([along.real, along.imag], axis=-1)
    round_about = np.broadcast_to(np.eye(2), (len(axes), 2, 2)) * variances[:, 1, None, None]
    further = (variances[:, 0] - variances[:, 1])[:, None, None]
    made: FloatArray = round_about + further * axes[:, :, None] * axes[:, None, :]
    return made


def carried_covariance(pose: FloatArray, now: FloatArray, sigma: FloatArray, odometry: FloatArray) -> FloatArray:
    """Of the pose ``now`` after ``pose`` with ``sigma`` [3, 3], by odometry with a covariance [3, 3] of its motion."""
    levers = pose_levers(now, pose)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    axes = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    made: FloatArray = levers @ sigma @ levers.T + axes @ odometry @ axes.T
    return made
