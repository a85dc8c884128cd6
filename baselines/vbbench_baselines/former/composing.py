"""Between the world, in float64, and what the network sees from the last pose, in float32."""

import math

import numpy as np
from numpy.typing import NDArray

from vbbench.estimate import LARGEST
from vbbench.geometry import FloatArray
from vbbench.sequence import Odometry
from vbbench_baselines.common.odometry import SMALLEST, SURE
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.pose_fit import Measured, Motion

TRUSTED = 10.0
"""Odometry that is sure counts as so many times its information: what is wrong with a box is so for several frames, and
the network, which learned without odometry, takes it for new in each."""


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
    sure = bool(variances.max() < SURE**2)
    return Measured(motion, ((TRUSTED if sure else 1.0) / variances).astype(np.float32), np.float32(sure))
