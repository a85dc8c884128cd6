"""What is kept of a frame that leaves the window: the quadratic form that it leaves behind on the poses after it.

Eliminating people makes the energy's Hessian H in the poses. Without its first frame, the others would know H' only;
with it, they know the Schur complement of the first pose in H. The difference,

    Λ = H_rr − H_r0 H_00⁻¹ H_0r − H',   s = g_r − H_r0 H_00⁻¹ g_0 − g',

and likewise of the gradients g and g', is what the frame said, through
everybody seen in it: added to the window's energy it keeps the minimum and its curvature where they were, and as the
window slides nothing is lost but the freedom to linearise anew.
"""

import numpy as np
from vbbench.arrays import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.people import Scene
from vbbench_baselines.joint_map.optimiser.poses import Anchor, linearise
from vbbench_baselines.joint_map.optimiser.state import State
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, innovation
from typing import NamedTuple
import numpy as np
from vbbench.arrays import BoolArray, FloatArray
from vbbench_baselines.joint_map.optimiser.descent import Settled, settle, unwrapped
from vbbench_baselines.joint_map.motion.heads import evidence
from vbbench_baselines.joint_map.optimiser.people import Scene
from vbbench_baselines.joint_map.optimiser.poses import Anchor
from vbbench_baselines.joint_map.optimiser.state import State
from vbbench_baselines.joint_map.motion.walks import Walk

# DOC """Hands what frames that left have said (`vbbench_baselines.joint_map.optimiser.marginalisation`) from one window to the next.
# DOC 
# DOC What is kept has directions of negative curvature: they take back how a track that goes on would begin anew in the next
# DOC window. They do so exactly where the weights are as they were; but a Student-t law flattens out, a quadratic form does
# DOC not, and far away the sum may fall without end. Where a descent went there it is done again without those directions.
# DOC """
@kernel
def forget(state: State, anchor: Anchor, walk: Walk, count: int) -> tuple[FloatArray, FloatArray]:
    """Slope [3(T − n)] and information [3(T − n), 3(T − n)] that the first n = ``count`` of T frames leave behind."""
    scene = state.scene
    size, gone = 3 * (len(state.poses) - count), 3 * count
    shorter = Scene(
        scene.relative[count:],
        scene.information[count:],
        scene.given[count:],
        np.maximum(scene.first - count, 0),
        scene.last - count,
        scene.stature,
        scene.stature_variance,
    )
    nothing = Anchor(anchor.fixed[count:], state.poses[count:], np.zeros(size), np.zeros((size, size)), 0.0)
    weights = _begin_anew(state, walk, count)
    slope, whole = linearise(state.poses, scene, anchor, walk, state.weights, state.yaw_weights)
    rest_slope, rest = linearise(state.poses[count:], shorter, nothing, walk, weights, state.yaw_weights[count:])
    across = np.ascontiguousarray(whole[gone:, :gone])
    first = np.ascontiguousarray(whole[:gone, :gone])
    share = np.ascontiguousarray(np.linalg.solve(first, np.ascontiguousarray(across.T)).T)
    slope = slope[gone:] - share @ slope[:gone] - rest_slope
    return slope, whole[gone:, gone:] - share @ np.ascontiguousarray(across.T) - rest


@kernel
def _begin_anew(state: State, walk: Walk, count: int) -> FloatArray:
    """The weights [K + 1, T − n] of innovations without the first n = ``count`` frames.

    Where a track now begins later its first innovations are of lower order, with weights of their own: those that the
    next window finds, so that what is taken away here is what is added there.
    """
    scene, size = state.scene, len(state.poses) - count
    weights = state.weights[:, :size].copy()
    for k in range(len(weights)):
        first, last = 0, len(state.poses) - 1
        if k < len(scene.first):
            first, last = int(scene.first[k]), int(scene.last[k])
        if first >= count or last < count:
            continue
        weights[k] = state.weights[k, count - first : count - first + size]
        track = state.poses[count:, :2].copy() if k == len(scene.first) else state.places[count : last + 1, k].copy()
        for i in range(2, min(REACH, len(track))):
            weights[k, i] = (walk.nu + 2.0) / (walk.nu * state.variances[k] + innovation(track, i, walk))
    return weights


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
    """`vbbench_baselines.joint_map.optimiser.descent.settle`, again with a tamed anchor if poses ran away; and that anchor."""
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
