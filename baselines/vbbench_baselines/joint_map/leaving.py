"""Hands what frames that left have said (`vbbench_baselines.joint_map.forgetting`) from one window to the next.

What is kept has directions of negative curvature: they take back how a track that goes on would begin anew in the next
window. They do so exactly where the weights are as they were; but a Student-t law flattens out, a quadratic form does
not, and far away the sum may fall without end. Where a descent went there it is done again without those directions.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_baselines.joint_map.descent import Settled, settle, unwrapped
from vbbench_baselines.joint_map.forgetting import forget
from vbbench_baselines.joint_map.heads import evidence
from vbbench_baselines.joint_map.people import Scene
from vbbench_baselines.joint_map.poses import Anchor
from vbbench_baselines.joint_map.state import State
from vbbench_baselines.joint_map.walks import Walk

RUNAWAY = 25.0
"""In m; no descent moves a pose further for good reason."""


class Left(NamedTuple):
    """What frames that left have said of the first n frames of the next window.

    Attributes
    ----------
    poses, slope, information, odds : [n, 3], [3n], [3n, 3n] and one, as in `Anchor`.
    """

    poses: FloatArray
    slope: FloatArray
    information: FloatArray
    odds: float


NOTHING_LEFT = Left(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 0)), 0.0)


def hold(fixed: BoolArray, poses: FloatArray, left: Left) -> Anchor:
    """What holds the poses [T, 3] of a window, of which ``fixed`` [T] are given."""
    known, size = len(left.poses), 3 * len(poses)
    centre, slope, information = poses.copy(), np.zeros(size), np.zeros((size, size))
    centre[:known] = left.poses
    slope[: 3 * known] = left.slope
    information[: 3 * known, : 3 * known] = left.information
    return Anchor(fixed, centre, slope, information, left.odds)


def leave(state: State, anchor: Anchor, walk: Walk, count: int) -> Left:
    """What the first ``count`` frames of a solved window leave behind."""
    odds = anchor.odds + evidence(state.poses[: count + 1], walk.head)
    return Left(state.poses[count:], *forget(state, anchor, walk, count), odds)


def settle_held(
    poses: FloatArray, places: FloatArray, scene: Scene, anchor: Anchor, walk: Walk, ends: tuple[int, float, float]
) -> tuple[Settled, Anchor]:
    """`vbbench_baselines.joint_map.descent.settle`, again with a tamed anchor if poses ran away; and that anchor."""
    settled = settle(poses, places, scene, anchor, walk, *ends)
    moved = np.abs(settled.state.poses - unwrapped(poses))[:, :2].max()
    if moved < RUNAWAY:
        return settled, anchor
    anchor = tamed(anchor)
    return settle(poses, places, scene, anchor, walk, *ends), anchor


def tamed(anchor: Anchor) -> Anchor:
    """The anchor without its directions of negative curvature."""
    values, vectors = np.linalg.eigh(anchor.information)
    kept = np.ascontiguousarray(vectors[:, values >= 0.0])
    information = (kept * values[values >= 0.0]) @ kept.T
    return anchor._replace(slope=kept @ (kept.T @ anchor.slope), information=information)
