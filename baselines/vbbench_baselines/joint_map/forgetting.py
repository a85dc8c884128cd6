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
from vbbench_baselines.compiled import kernel
from vbbench_baselines.joint_map.descent import Settled
from vbbench_baselines.joint_map.people import Scene
from vbbench_baselines.joint_map.poses import Anchor, linearise
from vbbench_baselines.joint_map.walks import Walk


@kernel
def forget_first(settled: Settled, scene: Scene, anchor: Anchor, walk: Walk) -> tuple[FloatArray, FloatArray]:
    """Slope [3(T − 1)] and information [3(T − 1), 3(T − 1)] that the first of T frames leaves behind."""
    size = 3 * (len(settled.poses) - 1)
    shorter = Scene(
        scene.relative[1:],
        scene.information[1:],
        scene.given[1:],
        np.maximum(scene.first - 1, 0),
        scene.last - 1,
        scene.stature,
        scene.stature_variance,
    )
    nothing = Anchor(anchor.fixed[1:], settled.poses[1:], np.zeros(size), np.zeros((size, size)))
    weights = settled.weights[:, :-1].copy()
    for k in range(len(weights)):
        if k == len(scene.first) or scene.first[k] == 0:
            weights[k] = settled.weights[k, 1:]
    room = np.empty((2 * len(settled.poses), 2 * len(settled.poses)))
    places, heights = settled.places.copy(), settled.heights.copy()
    _, slope, whole = linearise(
        settled.poses, scene, anchor, walk, settled.weights, settled.yaw_weights, places, heights, room
    )
    _, rest_slope, rest = linearise(
        settled.poses[1:], shorter, nothing, walk, weights, settled.yaw_weights[1:], places[1:].copy(), heights, room
    )
    across = np.ascontiguousarray(whole[3:, :3])
    gone = np.linalg.solve(np.ascontiguousarray(whole[:3, :3]), np.ascontiguousarray(across.T))
    return slope[3:] - gone.T.copy() @ slope[:3] - rest_slope, whole[3:, 3:] - across @ gone - rest
