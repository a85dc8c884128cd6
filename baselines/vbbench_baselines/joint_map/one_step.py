"""One frame on a known past: the autoregression predicts all people, then one robust fit of the pose.

This is the joint problem with all frames but one anchored. The innovation of the new frame is the distance from what is
foreseen, p_k, so that a weighted problem but for the head is that of `vbbench_baselines.common.ego_motion.fit_pose`,
whose minimum over all poses is exact: there the search starts. Gauss–Newton steps with the weights of
`vbbench_baselines.joint_map.motion.walks` and the head's (`motion.heads`) lead on. What the walks are like is learned
from the past, too (`motion.learning`).
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.ego_motion import VAGUE, Factors, fit_pose, localise, wrapped
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.odometry import Motions, carried, measured, stray, tracked
from vbbench_baselines.common.sightings import Sightings, measure
from vbbench_baselines.common.uncertainty import linearise_people
from vbbench_baselines.joint_map.measurement.boxes import FLOOR, Statures, farther
from vbbench_baselines.joint_map.motion.heads import (
    FOLLOWERS,
    add_curvature,
    add_slope,
    judge,
)
from vbbench_baselines.joint_map.motion.learning import Lessons, known_before, learn, taught
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, observer_of

PAST = REACH + 1
"""Frames before the newest that are used."""

ROUNDS, LONGEST = 20, 0.2
"""Maximum number of steps, and their maximum length in m and rad."""

TOLERANCE = 2e-4
"""In m and rad; the search ends with a shorter step."""


class Located(NamedTuple):
    """One frame on a known past.

    Attributes
    ----------
    pose, places : [3], [K, 2] (NaN = not observed).
    factors : the normal terms that were minimised in the end.
    own : [3, 3] the information that the observer's own walk and head add, where the pose is not given.
    """

    pose: FloatArray
    places: FloatArray
    factors: Factors
    own: FloatArray


@kernel
def locate(
    sightings: Sightings,
    statures: Statures,
    places: FloatArray,
    poses: FloatArray,
    given: FloatArray,
    known: FloatArray,
    fitted: Walk,
    lessons: Lessons,
    learns: bool,
    motions: Motions,
) -> Located:
    """The pose and all places at t.

    Parameters
    ----------
    places, poses, given : as of `foresee_all`.
    known : [3] the pose where it is given, else NaN.
    fitted, lessons : the prior, and what was learned of it, to which the newest revealed frame adds if it ``learns``.
    motions : the newest, one row.
    """
    if learns:
        learn(places, poses, fitted, lessons)
    walk = taught(fitted, lessons)
    relative, covariance = measure(sightings, statures.mean, statures.variance)
    covariance[:, 0] += FLOOR**2
    covariance[:, 2] += FLOOR**2
    expected, std, walk_pose, own_std = foresee_all(places, poses, given, walk, lessons.variances)
    factors = Factors(relative.copy(), covariance.copy(), expected, std.copy(), walk_pose, own_std)
    free = np.isnan(known[2])
    follows = not np.isnan(poses[-1, 0])
    carries = tracked(motions.information[0]) and follows
    pose = walk_pose if free else known.copy()
    _linearise_boxes(relative, covariance, expected, pose, factors)
    if free:
        facing = VAGUE if np.isinf(own_std) else max(1.0 / walk.head.wandering**2, VAGUE)
        pose = fit_pose(factors, facing)
        if follows and motions.information[0, 2, 2] > 0.0:
            near, information = carried(poses[-1], motions.moved[0]), motions.information[0]
            near_std = np.sqrt(2.0 / (information[0, 0] + information[1, 1]))
            told = Factors(factors.relative, factors.covariance, expected, factors.std, near, near_std)
            pose = fit_pose(told, max(information[2, 2], VAGUE if carries else facing))
    own = np.zeros((3, 3))
    for _ in range(ROUNDS):
        found = localise(pose, factors)
        _spread(found, std, walk.nu, factors)
        _linearise_boxes(relative, covariance, found, pose, factors)
        if not free:
            break
        slope, own = own_terms(pose, poses[-1], walk_pose, np.inf if carries else own_std, walk)
        if follows and measured(motions.information[0]):
            _add_motion(pose, poses[-1], motions, slope, own)
        gradient, hessian = linearise_people(pose, factors)
        step = np.linalg.solve(hessian + own, gradient + slope)
        length = np.max(np.abs(step))
        pose = pose - step * min(1.0, LONGEST / max(length, LONGEST))
        if length < TOLERANCE:
            break
    pose[2] = wrapped(pose[2])
    return Located(pose, localise(pose, factors), factors, own)


@kernel
def own_terms(
    pose: FloatArray, before: FloatArray, walk_pose: FloatArray, std: float, walk: Walk
) -> tuple[FloatArray, FloatArray]:
    """Gradient [3] and Hessian [3, 3] of the observer's walk, expected at ``walk_pose`` within ``std``, and head."""
    gradient, hessian = np.zeros(3), VAGUE * np.eye(3)
    if np.isinf(std):
        return gradient, hessian
    off_x, off_y = pose[0] - walk_pose[0], pose[1] - walk_pose[1]
    precision = (walk.nu + 2.0) / (walk.nu * std**2 + (off_x * off_x + off_y * off_y))
    gradient[0], gradient[1] = precision * off_x, precision * off_y
    hessian[0, 0] += precision
    hessian[1, 1] += precision
    pair, weights, slope, curvature = np.empty((2, 3)), np.empty((2, FOLLOWERS + 1)), np.zeros(6), np.zeros((6, 6))
    pair[0], pair[1] = before, pose
    judge(pair, walk.head, np.zeros(FOLLOWERS), weights)
    add_slope(pair, walk.head, weights, slope)
    add_curvature(pair, walk.head, weights, curvature)
    gradient += slope[3:]
    for i in range(3):
        for j in range(3):
            hessian[i, j] += curvature[3 + min(i, j), 3 + max(i, j)]
    return gradient, hessian


@kernel
def _add_motion(
    pose: FloatArray, before: FloatArray, motions: Motions, gradient: FloatArray, hessian: FloatArray
) -> None:
    """Add what odometry says of the ``pose`` [3] to its gradient [3] and Hessian [3, 3]."""
    error, slopes = stray(before, pose, motions.moved[0])
    by_pose = np.ascontiguousarray(slopes[:, 3:])
    gradient += by_pose.T @ (motions.information[0] @ error)
    hessian += by_pose.T @ (motions.information[0] @ by_pose)


@kernel
def _spread(found: FloatArray, std: FloatArray, nu: float, factors: Factors) -> None:
    """Write to the factors the standard deviations of normal laws that touch the Student-t ones at ``found`` [K, 2]."""
    expected = factors.expected
    for k in range(len(std)):
        if std[k] > ANCHOR_STD:
            squared = ((found[k, 0] - expected[k, 0]) ** 2 + (found[k, 1] - expected[k, 1]) ** 2) / std[k] ** 2
            if not np.isnan(squared):
                factors.std[k] = std[k] * np.sqrt((nu + squared) / (nu + 2.0))


@kernel
def _linearise_boxes(
    relative: FloatArray, covariance: FloatArray, places: FloatArray, pose: FloatArray, factors: Factors
) -> None:
    """Write the measured places and their noise, linearised about ``places``, to the factors."""
    for k in range(len(places)):
        if not np.isnan(places[k, 0] + relative[k, 0]):
            q = farther(relative[k], places[k], pose)
            for i in range(2):
                factors.relative[k, i] = relative[k, i] * (2.0 * q - q * q)
            for i in range(3):
                factors.covariance[k, i] = covariance[k, i] * q**4


@kernel
def foresee(places: FloatArray, walk: Walk, variance: float) -> tuple[float, float, float]:
    """Where a walk [n, 2] with σ_k² = ``variance`` goes next, and its standard deviation, in m; NaN = unknown.

    One unknown frame at the end is foreseen first, and its error carried on.
    """
    known = known_before(places)
    if known > 0:
        return _continue(places, min(known, REACH), walk, variance)
    known = known_before(places[:-1])
    if known == 0:
        return np.nan, np.nan, np.nan
    filled = places.copy()
    filled[-1, 0], filled[-1, 1], before = _continue(places[:-1], min(known, REACH), walk, variance)
    order = min(known + 1, REACH)
    x, y, std = _continue(filled, order, walk, variance)
    return x, y, np.sqrt(std**2 + (walk.filters[order, 1] * before) ** 2)


@kernel
def _continue(places: FloatArray, order: int, walk: Walk, variance: float) -> tuple[float, float, float]:
    """`foresee` by the filter of this ``order``, the number of known frames at the end of places [n, 2]."""
    n, x, y = len(places), 0.0, 0.0
    for d in range(1, order + 1):
        x -= walk.filters[order, d] * places[n - d, 0]
        y -= walk.filters[order, d] * places[n - d, 1]
    return x, y, walk.spreads[order] * (1.0 if order == 1 else np.sqrt(variance))


@kernel
def foresee_all(
    places: FloatArray, poses: FloatArray, given: FloatArray, walk: Walk, variances: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Where everyone is expected at t.

    Parameters
    ----------
    places, poses : [n, K, 2] and [n, 3] of the n frames before t; NaN = unknown.
    given : [K, 2] places at t, NaN = not given.
    variances : [K + 1] σ_k² in m² of the people and the observer.

    Returns
    -------
    [K, 2] and [K] expected places and their standard deviations in m, [3] the observer's pose and its own in m.
    """
    people = len(given)
    expected, std = np.empty((people, 2)), np.empty(people)
    for k in range(people):
        if np.isnan(given[k, 0]):
            expected[k, 0], expected[k, 1], std[k] = foresee(places[:, k], walk, variances[k])
        else:
            expected[k, 0], expected[k, 1], std[k] = given[k, 0], given[k, 1], ANCHOR_STD
    pose = poses[-1].copy()
    if np.isnan(pose[0]):
        return expected, std, np.zeros(3), np.inf
    pose[0], pose[1], own = foresee(poses[:, :2], observer_of(walk), variances[-1])
    return expected, std, pose, own
