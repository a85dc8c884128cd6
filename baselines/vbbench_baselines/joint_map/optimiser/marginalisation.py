"""What is kept of a frame that leaves the window: the quadratic form that it leaves behind on the poses after it.

Eliminating people makes the energy's Hessian H in the poses. Without its first frame, the others would know H' only;
with it, they know the Schur complement of the first pose in H. The difference,

    Λ = H_rr − H_r0 H_00⁻¹ H_0r − H',   s = g_r − H_r0 H_00⁻¹ g_0 − g',

of the Hessians and of the gradients g and g', is the information of that frame, through all people seen in it: added to
the window's energy it keeps the minimum and its curvature, so that a sliding window only loses the freedom to linearise
again.

It has directions of negative curvature, which compensate for the new beginning of continued tracks in the next window.
This is exact at the same weights; but a Student-t law flattens out, a quadratic form does not, and far away the sum may
fall without bound. A descent that went there is repeated without those directions.
"""

from typing import NamedTuple, TypeVar

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.odometry import Motions, unmeasured
from vbbench_baselines.joint_map.measurement.window import Measurements
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, evidence
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, innovation
from vbbench_baselines.joint_map.optimiser.descent import Settled, settle, unwrapped
from vbbench_baselines.joint_map.optimiser.poses import linearise
from vbbench_baselines.joint_map.optimiser.state import Anchor, JointProblem, State

RUNAWAY = 25.0
"""In m; a descent that moves a pose further has diverged."""


class Marginal(NamedTuple):
    """Information of earlier frames on the first n frames of the next window or block.

    Attributes
    ----------
    poses, slope, information, odds : [n, 3], [3n], [3n, 3n] and [M], as in `Anchor`.
    """

    poses: FloatArray
    slope: FloatArray
    information: FloatArray
    odds: FloatArray


Constraint = TypeVar("Constraint", Anchor, Marginal)

NOTHING_KEPT = Marginal(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 0)), np.zeros(FOLLOWERS))


def anchor_of(fixed: BoolArray, poses: FloatArray, marginal: Marginal) -> Anchor:
    """What constrains the poses [T, 3] of a window, of which ``fixed`` [T] are given."""
    known, size = len(marginal.poses), 3 * len(poses)
    centre, slope, information = poses.copy(), np.zeros(size), np.zeros((size, size))
    centre[:known] = marginal.poses
    slope[: 3 * known] = marginal.slope
    information[: 3 * known, : 3 * known] = marginal.information
    return Anchor(fixed, centre, slope, information, marginal.odds)


def settle_anchored(
    poses: FloatArray, places: FloatArray, problem: JointProblem, ends: tuple[int, float, float], careful: bool
) -> tuple[Settled, JointProblem]:
    """`settle`, again with the anchor's `convex_part` if poses ran away; and the problem that was solved.

    Where little is known of the poses, a descent that is on its way into the abyss may not have gone far yet. If
    ``careful``, it counts as a runaway as soon as its end is no minimum.
    """
    settled = settle(poses, places, problem, *ends)
    moved = np.abs(settled.state.poses - unwrapped(poses))[:, :2].max()
    if moved < RUNAWAY and not (careful and _falls(settled.state, problem)):
        return settled, problem
    problem = problem._replace(anchor=convex_part(problem.anchor))
    return settle(poses, places, problem, *ends), problem


def _falls(state: State, problem: JointProblem) -> bool:
    """Whether the energy falls in some direction to both sides of a point."""
    _, hessian = linearise(state, problem)
    return bool(np.linalg.eigvalsh(hessian)[0] < 0.0)


def convex_part(anchor: Constraint) -> Constraint:
    """The constraint without its directions of negative curvature."""
    values, vectors = np.linalg.eigh(anchor.information)
    kept = np.ascontiguousarray(vectors[:, values >= 0.0])
    information = (kept * values[values >= 0.0]) @ kept.T
    return anchor._replace(slope=kept @ (kept.T @ anchor.slope), information=information)


def marginalise(state: State, problem: JointProblem, count: int) -> Marginal:
    """What the first ``count`` frames of a solved window leave behind."""
    free, told = unmeasured(problem.motions), np.zeros(FOLLOWERS)
    for t in range(1, count + 1):
        if free[t]:
            told += evidence(state.poses[t - 1 : t + 1], problem.walk.head)
    return Marginal(state.poses[count:], *schur_complement(state, problem, count), problem.anchor.odds + told)


@kernel
def schur_complement(state: State, problem: JointProblem, count: int) -> tuple[FloatArray, FloatArray]:
    """Slope [3(T − n)] and information [3(T − n), 3(T − n)] that the first n = ``count`` of T frames leave behind."""
    data, walk = state.data, problem.walk
    size, gone = 3 * (len(state.poses) - count), 3 * count
    relative, information, given = data.relative[count:], data.information[count:], data.given[count:]
    first, last = np.maximum(data.first - count, 0), data.last - count
    shorter = Measurements(relative, information, given, first, last, data.stature, data.stature_variance)
    poses, places, yaw_weights = state.poses[count:], state.places[count:], state.yaw_weights[count:]
    weights = _begin_anew(state, walk, count)
    weights[-1] = np.where(unmeasured(problem.motions)[count:], weights[-1], 0.0)
    later = State(poses, places, state.heights, weights, yaw_weights, state.variances, shorter, np.nan)
    nothing = Anchor(problem.anchor.fixed[count:], poses, np.zeros(size), np.zeros((size, size)), problem.anchor.odds)
    motions = Motions(problem.motions.moved[count:], problem.motions.information[count:])
    slope, whole = linearise(state, problem)
    rest_slope, rest = linearise(later, JointProblem(shorter, nothing, walk, motions))
    across = np.ascontiguousarray(whole[gone:, :gone])
    before = np.ascontiguousarray(whole[:gone, :gone])
    share = np.ascontiguousarray(np.linalg.solve(before, np.ascontiguousarray(across.T)).T)
    slope = slope[gone:] - share @ slope[:gone] - rest_slope
    return slope, whole[gone:, gone:] - share @ np.ascontiguousarray(across.T) - rest


@kernel
def _begin_anew(state: State, walk: Walk, count: int) -> FloatArray:
    """The weights [K + 1, T − n] of innovations without the first n = ``count`` frames.

    Where a track now begins later its first innovations are of lower order, with weights of their own: those that the
    next window finds, so that what is taken away here is what is added there.
    """
    data, size = state.data, len(state.poses) - count
    weights = state.weights[:, :size].copy()
    for k in range(len(weights)):
        first, last = 0, len(state.poses) - 1
        if k < len(data.first):
            first, last = int(data.first[k]), int(data.last[k])
        if first >= count or last < count:
            continue
        weights[k] = state.weights[k, count - first : count - first + size]
        track = state.poses[count:, :2].copy() if k == len(data.first) else state.places[count : last + 1, k].copy()
        for i in range(2, min(REACH, len(track))):
            weights[k, i] = (walk.nu + 2.0) / (walk.nu * state.variances[k] + innovation(track, i, walk))
    return weights
