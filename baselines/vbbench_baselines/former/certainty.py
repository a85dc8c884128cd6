"""Covariances of poses and places: the network's own, and common drift, which short training windows do not contain."""

import math

import numpy as np

from vbbench.geometry import FloatArray, covariance_along, place_levers, pose_levers
from vbbench_baselines.common.cold_start import Astray
from vbbench_baselines.former.operations import Array

NARROWEST, WIDEST = -7.0, 3.0
"""ln of the least and greatest standard deviations in m and rad that are learned."""

TURNED = 0.1
"""In rad after a second, growing as its root: by how much all may seem to turn after a cold start."""

STILL = np.zeros((3, 3))
"""The covariance of a motion that is known."""


class Certainty:
    """Covariances of the last pose and of people's places.

    Where places are given, newcomers reduce the error of the pose, and its covariance is the network's, or odometry's
    where that is smaller. After a cold start nothing reduces it, and the network, which learned on short windows, does
    not estimate the common drift. Then each frame adds the covariance of odometry, or of the crowd's common velocity.

    Parameters
    ----------
    dt : duration of a frame in s.

    Attributes
    ----------
    pose : [3, 3] covariance in m² and rad².
    cold : whether nobody's place was given yet.
    """

    def __init__(self, dt: float) -> None:
        self.cold, self._dt = True, dt
        self.know()

    def know(self) -> None:
        """Reset the covariance: the pose is given."""
        self.pose, self._astray, self._alone = STILL, Astray(), True

    def follow(
        self, before: FloatArray, now: FloatArray, spread: Array, motion: FloatArray | None, *, sure: bool
    ) -> None:
        """Propagate the covariance from the pose ``before`` to ``now`` [3], whose ``spread`` [3] the network estimates.

        ``motion`` [3, 3] is the covariance of odometry, and ``sure`` is whether odometry replaces other priors.
        """
        estimated = _turned(_variances(spread), now)
        if sure:
            self._alone = False  # from here on the network, which does not count on odometry, knows less than is known
            self._astray.wait(0.0)
        if self.cold:
            step = motion if motion is not None and sure else self._unmeasured(motion)
            self.pose = _carried(before, now, self.pose, step)
            if self._alone:
                self.pose = _at_least(self.pose, estimated)
        elif motion is None:
            self.pose = estimated
        else:
            self.pose = min(estimated, _carried(before, now, self.pose, motion), key=_size)

    def _unmeasured(self, motion: FloatArray | None) -> FloatArray:
        """Covariance [3, 3] of the motion in a frame with weak odometry or none."""
        drifted = self._astray.variance
        self._astray.wait(self._dt)
        place, yaw = (self._astray.variance - drifted) * np.eye(2), TURNED**2 * self._dt
        if motion is not None:
            place, yaw = min(place, motion[:2, :2], key=np.trace), min(yaw, float(motion[2, 2]))
        made = np.zeros((3, 3))
        made[:2, :2], made[2, 2] = place, yaw
        return made

    def of_places(self, pose: FloatArray, places: FloatArray, rays: Array, spread: Array) -> FloatArray:
        """Covariances [K, 2, 2] of ``places`` [K, 2] by the network's ``spread`` [K, 2] along and across ``rays``."""
        estimated = _along_and_across(_variances(spread), rays, pose)
        if not self.cold:
            return estimated
        return estimated + covariance_along(place_levers(places, pose), self.pose)


def _at_least(covariance: FloatArray, other: FloatArray) -> FloatArray:
    """The ``covariance`` [3, 3], enlarged to at least the variances of place and yaw of the ``other``."""
    place = max(0.0, 0.5 * (_size(other) - _size(covariance)))
    return covariance + np.diag((place, place, max(0.0, other[2, 2] - covariance[2, 2])))


def _size(covariance: FloatArray) -> float:
    return float(np.trace(covariance[:2, :2]))


def _variances(spread: Array) -> FloatArray:
    """Variances of the network's ``spread``, ln of standard deviations."""
    return np.asarray(np.exp(2.0 * spread.astype(np.float64).clip(NARROWEST, WIDEST)))


def _turned(variances: FloatArray, pose: FloatArray) -> FloatArray:
    """Covariance [3, 3] in the world of a pose [3] with ``variances`` [3] forward, left and in yaw."""
    ahead, left, yaw = variances.tolist()
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    across = (ahead - left) * cos * sin
    return np.array(
        (
            (ahead * cos**2 + left * sin**2, across, 0.0),
            (across, ahead * sin**2 + left * cos**2, 0.0),
            (0.0, 0.0, yaw),
        )
    )


def _carried(before: FloatArray, now: FloatArray, covariance: FloatArray, motion: FloatArray) -> FloatArray:
    """Covariance [3, 3] of the pose ``now``, propagated from that of the pose ``before`` and of the ``motion``."""
    cos, sin = math.cos(before[2]), math.sin(before[2])
    axes = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    return covariance_along(pose_levers(now, before), covariance) + covariance_along(axes, motion)


def _along_and_across(variances: FloatArray, rays: Array, pose: FloatArray) -> FloatArray:
    """Covariances [K, 2, 2] in the world, from ``variances`` [K, 2] along and across ``rays`` [K] of a pose."""
    along = rays * np.exp(1j * pose[2])
    axes = np.stack([along.real, along.imag], axis=-1)
    round_about = np.broadcast_to(np.eye(2), (len(axes), 2, 2)) * variances[:, 1, None, None]
    further = (variances[:, 0] - variances[:, 1])[:, None, None]
    return np.asarray(round_about + further * axes[:, :, None] * axes[:, None, :])
