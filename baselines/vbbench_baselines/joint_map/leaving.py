"""Hands what frames that left have said (`vbbench_baselines.joint_map.forgetting`) from one window to the next."""

from typing import NamedTuple

import numpy as np

from vbbench.arrays import BoolArray, FloatArray
from vbbench_baselines.joint_map.forgetting import forget
from vbbench_baselines.joint_map.poses import Anchor
from vbbench_baselines.joint_map.state import State
from vbbench_baselines.joint_map.walks import Walk


class Left(NamedTuple):
    """What frames that left have said of the first n frames of the next window.

    Attributes
    ----------
    poses, slope, information : [n, 3], [3n] and [3n, 3n], as in `Anchor`.
    """

    poses: FloatArray
    slope: FloatArray
    information: FloatArray


NOTHING_LEFT = Left(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 0)))


def hold(fixed: BoolArray, poses: FloatArray, left: Left) -> Anchor:
    """What holds the poses [T, 3] of a window, of which ``fixed`` [T] are given."""
    known, size = len(left.poses), 3 * len(poses)
    centre, slope, information = poses.copy(), np.zeros(size), np.zeros((size, size))
    centre[:known] = left.poses
    slope[: 3 * known] = left.slope
    information[: 3 * known, : 3 * known] = left.information
    return Anchor(fixed, centre, slope, information)


def leave(state: State, anchor: Anchor, walk: Walk, count: int) -> Left:
    """What the first ``count`` frames of a solved window leave behind."""
    return Left(state.poses[count:], *forget(state, anchor, walk, count))
