"""What is kept of a frame that leaves the window: the quadratic form that it leaves behind on the poses after it.

Eliminating people makes the energy's Hessian H in the poses. Without its first frame, the others would know H' only;
with it, they know the Schur complement of the first pose in H. The difference,

    Λ = H_rr − H_r0 H_00⁻¹ H_0r − H',   s = g_r − H_r0 H_00⁻¹ g_0 − g',

and likewise of the gradients g and g', is what the frame said, through
everybody seen in it: added to the window's energy it keeps the minimum and its curvature where they were, and as the
window slides nothing is lost but the freedom to linearise anew.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.people import Scene
from vbbench_baselines.joint_map.poses import Anchor, linearise
from vbbench_baselines.joint_map.state import State
from vbbench_baselines.joint_map.walks import REACH, Walk, innovation


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
