"""How sure the last poses are that are held because frames before them were left behind, and what follows from it."""

import numpy as np

from vbbench.geometry import FloatArray


def carried(covariance: FloatArray, before: FloatArray, now: FloatArray, step: FloatArray) -> FloatArray:
    """The covariance [3, 3] of the pose ``now`` [≥ 3] from that of the pose ``before`` and that of the ``step``.

    A speed or a turning that was wrong stays wrong for long, so that errors add up instead of averaging out.
    """
    lever = np.eye(3)
    lever[0, 2], lever[1, 2] = before[1] - now[1], now[0] - before[0]
    root = _root(lever @ covariance @ lever.T) + _root(step)
    return np.asarray(root @ root.T)


def add_behind(
    covariance: FloatArray,
    held: FloatArray,
    frames: FloatArray,
    places: FloatArray,
    poses_spread: FloatArray,
    places_spread: FloatArray,
) -> None:
    """Add the ``covariance`` [3, 3] of a pose ``held`` [≥ 3] to those of ``frames`` [n, ≥ 3] and ``places`` [n, K, 2].

    A held pose that is turned turns all that comes after it about it. Errors of what is held and of what follows are
    taken to be independent.
    """
    poses_spread += _turned(covariance, frames[:, :2] - held[:2], np.ones((len(frames), 1)))
    places_spread += _turned(covariance, places - held[:2], np.zeros((*places.shape[:2], 0)))


def _root(covariance: FloatArray) -> FloatArray:
    """The symmetric square root of a ``covariance`` [n, n]."""
    values, axes = np.linalg.eigh(covariance)
    return np.asarray((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T)


def _turned(covariance: FloatArray, arms: FloatArray, yaw: FloatArray) -> FloatArray:
    """[…, 2 + y, 2 + y], of what is ``arms`` […, 2] away, and its ``yaw`` […, y] with it if y is 1."""
    size = 2 + yaw.shape[-1]
    lever = np.zeros((*arms.shape[:-1], size, 3))
    lever[..., np.arange(size), np.arange(size)] = 1.0
    lever[..., 0, 2], lever[..., 1, 2] = -arms[..., 1], arms[..., 0]
    return np.asarray(lever @ covariance @ np.swapaxes(lever, -1, -2))
