"""What the observer measures of its own motion: one more term on every two poses in a row.

Odometry says that the observer moved by m = (forward, left, turn) in the axes of the frame before, with covariance C.
Two poses p (x', y', θ') and q (x, y, θ) differ from that by

    e = (Rᵀ(θ')(q − p), θ − θ') − m,

and the energy has ½ eᵀC⁻¹e. Where nothing was measured C⁻¹ is zero. Where C is small (`SURE`) it stands in place of
the priors of the observer's walk and head, which know far less and, of a robot, nothing that is right; elsewhere beside
them.
"""

import math
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench.sequence import Odometry
from vbbench_baselines.common.ego_motion import wrapped

SMALLEST = 1e-6
"""Least standard deviation in m and rad of a measured motion: what is said to be exact must not divide by zero."""

SURE = 0.3
"""In m and rad a frame: a motion measured with smaller standard deviations replaces the priors of walk and head."""


class Motions(NamedTuple):
    """The motion into each frame.

    Attributes
    ----------
    moved : [T, 3] m in m and rad; zero where nothing was measured.
    information : [T, 3, 3] C⁻¹, likewise.
    """

    moved: FloatArray
    information: FloatArray


def motions_of(motions: FloatArray, covariances: FloatArray) -> Motions:
    """What the odometry of T frames says (`vbbench.sequence.Odometry`); nothing where a value is not finite."""
    known = np.isfinite(motions).all(axis=1) & np.isfinite(covariances).all(axis=(1, 2))
    told = Motions(np.zeros(motions.shape), np.zeros(covariances.shape))
    if known.any():
        told.moved[known] = motions[known]
        told.information[known] = np.linalg.inv(covariances[known] + SMALLEST**2 * np.eye(3))
    return told


class Told(NamedTuple):
    """What odometry tells of the newest pose, where the pose before is known.

    Attributes
    ----------
    pose : [3] where it leads to.
    std : in m, of its place, alike in all directions.
    facing : information in 1/rad² on its yaw.
    """

    pose: FloatArray
    std: float
    facing: float


def told_by(odometry: Odometry | None, before: FloatArray) -> Told | None:
    """What the newest row of ``odometry`` tells after the pose ``before`` [3]; ``None`` if nothing."""
    if odometry is None:
        return None
    newest = motions_of(odometry.motions[-1:], odometry.covariances[-1:])
    if not newest.information[0].diagonal().sum() > 0.0 or np.isnan(before).any():
        return None
    spread = odometry.covariances[-1]
    std = np.sqrt(0.5 * (spread[0, 0] + spread[1, 1]) + SMALLEST**2)
    (x, y, yaw), (forward, left, turn) = before.tolist(), newest.moved[0].tolist()
    cos, sin = math.cos(yaw), math.sin(yaw)
    pose = np.array((x + (cos * forward - sin * left), y + (sin * forward + cos * left), yaw + turn))
    return Told(pose, float(std), float(1.0 / (spread[2, 2] + SMALLEST**2)))


@kernel
def measured(information: FloatArray) -> bool:
    """Whether anything was measured, by the information [3, 3]."""
    return bool(information[0, 0] + information[1, 1] + information[2, 2] > 0.0)


@kernel
def tracked(information: FloatArray) -> bool:
    """Whether a motion was measured so surely, turn and all, that nothing else need be expected of the observer."""
    return bool(min(information[0, 0], information[1, 1], information[2, 2]) > SURE**-2)


@kernel
def unmeasured(motions: Motions) -> BoolArray:
    """[T] the frames whose motion is not `tracked`: there the priors of the observer's walk and head hold."""
    free = np.ones(len(motions.moved), np.bool_)
    for t in range(len(free)):
        free[t] = not tracked(motions.information[t])
    return free


@kernel
def stray(before: FloatArray, now: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The error e [3] of two poses [3], and its derivatives [3, 6] by both, ``before`` first."""
    cos, sin = np.cos(before[2]), np.sin(before[2])
    dx, dy = now[0] - before[0], now[1] - before[1]
    forward, left = cos * dx + sin * dy, cos * dy - sin * dx
    error, slopes = np.empty(3), np.zeros((3, 6))
    error[0], error[1] = forward - moved[0], left - moved[1]
    error[2] = wrapped(now[2] - before[2] - moved[2])
    slopes[0, 0], slopes[0, 1], slopes[0, 2], slopes[0, 3], slopes[0, 4] = -cos, -sin, left, cos, sin
    slopes[1, 0], slopes[1, 1], slopes[1, 2], slopes[1, 3], slopes[1, 4] = sin, -cos, -forward, -sin, cos
    slopes[2, 2], slopes[2, 5] = -1.0, 1.0
    return error, slopes


@kernel
def carried(before: FloatArray, moved: FloatArray) -> FloatArray:
    """The pose [3] after a motion [3] from ``before`` [3]."""
    cos, sin = np.cos(before[2]), np.sin(before[2])
    pose = before.copy()
    pose[0] += cos * moved[0] - sin * moved[1]
    pose[1] += sin * moved[0] + cos * moved[1]
    pose[2] += moved[2]
    return pose


@kernel
def disagreement(poses: FloatArray, motions: Motions) -> float:
    """½ Σ eᵀC⁻¹e over poses [T, 3]."""
    total = 0.0
    for t in range(1, len(poses)):
        if measured(motions.information[t]):
            error, _ = stray(poses[t - 1], poses[t], motions.moved[t])
            total += 0.5 * float(error @ (motions.information[t] @ error))
    return total


@kernel
def add_motions(poses: FloatArray, motions: Motions, gradient: FloatArray) -> None:
    """Add the slope of `disagreement` to the gradient [3T] by poses [T, 3]."""
    for t in range(1, len(poses)):
        if measured(motions.information[t]):
            error, slopes = stray(poses[t - 1], poses[t], motions.moved[t])
            gradient[3 * t - 3 : 3 * t + 3] += slopes.T @ (motions.information[t] @ error)


@kernel
def add_motion_curvature(poses: FloatArray, motions: Motions, hessian: FloatArray) -> None:
    """Add the upper half of its Gauss–Newton curvature to the Hessian [3T, 3T]."""
    for t in range(1, len(poses)):
        if measured(motions.information[t]):
            _, slopes = stray(poses[t - 1], poses[t], motions.moved[t])
            curvature = slopes.T @ (motions.information[t] @ slopes)
            first = 3 * t - 3
            for i in range(6):
                for j in range(i, 6):
                    hessian[first + i, first + j] += curvature[i, j]
