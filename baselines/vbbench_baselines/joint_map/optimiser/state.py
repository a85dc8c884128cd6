"""A point of the descent: poses, places and heights, and what follows from them.

The weights of the Student-t and Cauchy terms, each person's own scale and the boxes' linearisation are functions of the
point (`believe`). Its deviance, −ln of the robust posterior density up to a constant, is what a step lowers, with the
boxes linearised as they were when the step was computed.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.odometry import Motions, disagreement, unmeasured
from vbbench_baselines.joint_map.measurement.boxes import ratio
from vbbench_baselines.joint_map.measurement.window import Measurements
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, judge_some
from vbbench_baselines.joint_map.motion.walks import Walk, observer_of, reweigh_continued
from vbbench_baselines.joint_map.optimiser.people import axes_of, continued_energy, misfit


class Anchor(NamedTuple):
    """What constrains the poses.

    Attributes
    ----------
    fixed : [T] whether the pose is given.
    poses, slope, information : [n, 3], [3n] and [3n, 3n] of the first n frames, by earlier ones: sᵀd + ½ dᵀΛd with d
        the poses' distance from ``poses``.
    odds : [M] what they added to the logarithms of the odds that the head follows by each law.
    """

    fixed: BoolArray
    poses: FloatArray
    slope: FloatArray
    information: FloatArray
    odds: FloatArray


class JointProblem(NamedTuple):
    """The measurements of a window or sequence, what constrains its poses, the motion prior and odometry."""

    data: Measurements
    anchor: Anchor
    walk: Walk
    motions: Motions


class State(NamedTuple):
    """A point, and what follows from it.

    Attributes
    ----------
    poses, places, heights : [T, 3], [T, K, 2] (NaN where unknown) and [K].
    weights : [K + 1, T] of innovations, each person's counted from its first frame, the observer's last.
    yaw_weights : [T, M + 1] precisions in 1/rad² of what yaw increments are off (`motion.heads`).
    variances : [K + 1] σ_k² in m².
    data : what was known, with the boxes' noise that belongs to these distances.
    improbable : the deviance but for that of boxes and given places; NaN as long as somebody's place is unknown.
    """

    poses: FloatArray
    places: FloatArray
    heights: FloatArray
    weights: FloatArray
    yaw_weights: FloatArray
    variances: FloatArray
    data: Measurements
    improbable: float


@kernel
def believe(
    poses: FloatArray, places: FloatArray, heights: FloatArray, problem: JointProblem, variances: FloatArray
) -> State:
    """The state at a point; the search for scales begins with ``variances`` [K + 1]."""
    boxes, anchor, walk, motions = problem
    frames, people = len(poses), len(boxes.first)
    weights, variances = np.full((people + 1, frames), 1.0 / walk.sigma**2), variances.copy()
    weights[-1] = 1.0 / walk.own**2
    off, smooth = (poses[: len(anchor.poses)] - anchor.poses).ravel(), False
    total = float(off @ anchor.slope + 0.5 * off @ (anchor.information @ off))
    past, counted = boxes.continued, np.ones(frames, np.bool_)
    for k in range(people):
        first, last = int(boxes.first[k]), int(boxes.last[k])
        if last < first:
            continue
        track = places[first : last + 1, k].copy()
        if np.isnan(np.sum(track)):
            total = np.nan
            continue
        held, tally = past.held[k], past.tally[k]
        variances[k], improbable = reweigh_continued(
            track, walk, walk.sigma, weights[k], variances[k], counted, held, tally
        )
        total, smooth = total + improbable + continued_energy(k, track, past), True
    if smooth or not np.isnan(total):  # at the start of a descent poses are a guess until somebody's place is known
        walked = poses[:, :2].copy()
        free, own = unmeasured(motions), observer_of(walk)
        held, tally = past.held[people], past.tally[people]
        variances[-1], improbable = reweigh_continued(
            walked, own, walk.own, weights[-1], variances[-1], free, held, tally
        )
        total += improbable
    yaw_weights = np.empty((frames, FOLLOWERS + 1))
    total += judge_some(poses, walk.head, anchor.odds, yaw_weights, unmeasured(motions))
    total += disagreement(poses, motions)
    data = rescaled(boxes, poses, places, heights)
    return State(poses, places, heights, weights, yaw_weights, variances, data, total)


@kernel
def deviance_of(state: State, data: Measurements) -> float:
    """The deviance with the boxes linearised as they are in ``data``; NaN as long as somebody's place is unknown."""
    total, axes = state.improbable, axes_of(state.poses)
    for k in range(len(data.first)):
        first, last = int(data.first[k]), int(data.last[k])
        if last >= first:
            total += misfit(k, state.places[first : last + 1, k], state.poses, axes, state.heights[k], data)
    return float(total)


@kernel
def rescaled(data: Measurements, poses: FloatArray, places: FloatArray, heights: FloatArray) -> Measurements:
    """The data with its boxes linearised about these poses, places and heights, where known (see `farther`)."""
    relative, information = data.relative.copy(), data.information.copy()
    for t in range(len(poses)):
        for k in range(len(data.first)):
            if not np.isnan(places[t, k, 0] + relative[t, k, 0]):
                stretch, x, y = (
                    heights[k] / data.stature[k],
                    places[t, k, 0] - poses[t, 0],
                    places[t, k, 1] - poses[t, 1],
                )
                q = ratio(relative[t, k, 0] * stretch, relative[t, k, 1] * stretch, x, y)
                for a in range(2):
                    relative[t, k, a] *= 2.0 * q - q * q
                for a in range(3):
                    information[t, k, a] /= q**4
    first, last, stature, variance = data.first, data.last, data.stature, data.stature_variance
    return Measurements(relative, information, data.given, first, last, stature, variance, data.continued)
