"""How sure the last poses are that are held because frames before them were left behind, and what follows from it."""

import numpy as np

from vbbench.geometry import FloatArray, covariance_along, place_levers, pose_levers


def carried(
    covariance: FloatArray, before: FloatArray, now: FloatArray, step: FloatArray, measured: bool
) -> FloatArray:
    """The covariance [3, 3] of the pose ``now`` [≥ 3] from that of the pose ``before`` and that of the ``step``.

    A speed or a turning that was wrong stays wrong for long, so that errors add up instead of averaging out; not so
    where odometry ``measured`` the step, since its errors are new ones in each frame.
    """
    behind = covariance_along(pose_levers(now, before), covariance)
    if measured:
        return behind + step
    root = _root(behind) + _root(step)
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
    poses_spread += covariance_along(pose_levers(frames, held), covariance)
    places_spread += covariance_along(place_levers(places, held), covariance)


def _root(covariance: FloatArray) -> FloatArray:
    """The symmetric square root of a ``covariance`` [n, n]."""
    values, axes = np.linalg.eigh(covariance)
    return np.asarray((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T)
