"""What people who arrive tell of a pose that is held, and so of all that has been believed since.

Who arrives is given exactly, and is seen elsewhere if the map has drifted. The joint problem shares the difference
among the box and the frames of the window, which hang on poses that are held. Those are unsure themselves (`behind`).
Their share is a step of Kalman's filter ("A new approach to linear filtering and prediction problems", Journal of Basic
Engineering 82, 1960), in which all that is believed moves as one.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray, place_levers, relative_to_world, world_to_relative
from vbbench_baselines.common.bearings import Bearings
from vbbench_baselines.joint_map.real_camera.alone import places_alone, spread_alone

NU = 10.0
"""Degrees of freedom of how far arrivals are from where they are seen: those of whom that is hardly true count less."""


class UncertainPose(NamedTuple):
    """A pose [3], and its covariance [3, 3]."""

    pose: FloatArray
    covariance: FloatArray


def corrected(
    held: UncertainPose, newest: UncertainPose, given: FloatArray, boxes: Bearings, person: FloatArray
) -> UncertainPose | None:
    """What was ``held``, after people have arrived; ``None`` if nobody has, or if it was sure.

    Parameters
    ----------
    held : as believed.
    newest : the pose that sees them, whose covariance is that if the pose ``held`` were sure.
    given : [n, K, 2] places in m, NaN = not given.
    boxes : rows [n, K].
    person : [2] as of people of whom nothing is known.
    """
    arrived = _arrived(given, boxes.azimuth)
    if len(arrived) == 0 or not held.covariance.any():
        return None
    shown = places_alone(boxes.azimuth[-1, arrived], boxes.length[-1, arrived], person)
    off = (world_to_relative(given[-1, arrived], newest.pose) - shown).ravel()
    by_newest, by_held = (_levers(shown, newest.pose, pose) for pose in (newest.pose, held.pose))
    spread = by_newest @ newest.covariance @ by_newest.T + by_held @ held.covariance @ by_held.T
    for i, (rr, rf, ff) in enumerate(spread_alone(shown)):
        spread[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += np.array(((rr, rf), (rf, ff)))
    gain = np.linalg.solve(spread, by_held @ held.covariance).T
    counts = min(1.0, (NU + len(off)) / (NU + float(off @ np.linalg.solve(spread, off))))
    covariance = held.covariance - counts * gain @ spread @ gain.T
    return UncertainPose(held.pose + counts * (gain @ off), 0.5 * (covariance + covariance.T))


def _arrived(given: FloatArray, azimuth: FloatArray) -> IntArray:
    """Who [M] is given and seen in the newest frame, and in the one before was neither."""
    placed, seen = ~np.isnan(given[-2:, :, 0]), ~np.isnan(azimuth[-2:])
    return np.flatnonzero(placed[-1] & seen[-1] & ~placed[0] & ~seen[0])


def _levers(shown: FloatArray, newest: FloatArray, pose: FloatArray) -> FloatArray:
    """[2M, 3] how people ``shown`` [M, 2] before the ``newest`` pose move, in its axes, as a ``pose`` carries them."""
    sin, cos = np.sin(newest[2]), np.cos(newest[2])
    right_and_forward = np.array(((sin, -cos), (cos, sin)))
    levers = right_and_forward @ place_levers(relative_to_world(shown, newest), pose)
    return np.asarray(levers.reshape(-1, 3))
