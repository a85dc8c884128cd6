"""One frame on a known past: everybody foreseen by the autoregression, then one robust fit of the pose.

This is the joint problem with all frames but one anchored. The innovation of the new frame is the distance from what
the filter foresees, p_k, so that a weighted problem is that of `vbbench_baselines.ego_motion.fit_pose`, whose minimum
over all poses is exact. The weights are those of `vbbench_baselines.joint_map.walks`, and those of a Cauchy
distribution for the turn since the frame before. What the walks are like is learned from the past, too
(`vbbench_baselines.joint_map.learning`).
"""

from typing import NamedTuple

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_baselines.compiled import kernel
from vbbench_baselines.ego_motion import VAGUE, fit_pose
from vbbench_baselines.joint_map.learning import known_before
from vbbench_baselines.joint_map.sighted import FLOOR, farther
from vbbench_baselines.joint_map.walks import REACH, Walk
from vbbench_baselines.localisation import localise
from vbbench_baselines.motion import ANCHOR_STD
from vbbench_baselines.sightings import measure

PAST = REACH + 1
"""Frames before the newest that tell of it."""

ROUNDS = 10
"""Most times the weights are renewed."""

TOLERANCE = 2e-4
"""In m and rad; the rounds end when the pose moves less."""


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
    """`foresee` by the filter of this order; so many frames at the end of places [n, 2] are known."""
    n, x, y = len(places), 0.0, 0.0
    for d in range(1, order + 1):
        x -= walk.filters[order, d] * places[n - d, 0]
        y -= walk.filters[order, d] * places[n - d, 1]
    return x, y, walk.spreads[order] * (1.0 if order == 1 else np.sqrt(variance))


@kernel
def foresee_all(
    places: FloatArray, poses: FloatArray, given: FloatArray, walk: Walk, variances: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Where everybody is expected at t.

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
            expected[k], std[k] = given[k], ANCHOR_STD
    pose = poses[-1].copy()
    if np.isnan(pose[0]):
        return expected, std, np.zeros(3), np.inf
    pose[0], pose[1], own = foresee(poses[:, :2], walk, variances[-1])
    return expected, std, pose, own


class Located(NamedTuple):
    """One frame on a known past.

    Attributes
    ----------
    pose, places : [3], [K, 2] (NaN = not observed).
    seen, noise, expected, std, own, yaw_information : the normal terms that were minimised in the end, as `fit_pose`
        takes them.
    """

    pose: FloatArray
    places: FloatArray
    seen: FloatArray
    noise: FloatArray
    expected: FloatArray
    std: FloatArray
    own: float
    yaw_information: float


@kernel
def locate(
    rays: FloatArray,
    sideways: FloatArray,
    stretch: FloatArray,
    stature: FloatArray,
    stature_variance: FloatArray,
    places: FloatArray,
    poses: FloatArray,
    given: FloatArray,
    known: FloatArray,
    walk: Walk,
    variances: FloatArray,
) -> Located:
    """The pose and everybody's places at t.

    Parameters
    ----------
    rays, sideways, stretch, stature, stature_variance : as `vbbench_baselines.sightings.measure` takes them.
    places, poses, given, walk, variances : as of `foresee_all`.
    known : [3] the pose where it is given, else NaN.
    """
    relative, covariance = measure(rays, sideways, stretch, stature, stature_variance)
    covariance[:, 0] += FLOOR**2
    covariance[:, 2] += FLOOR**2
    expected, std, walk_pose, own = foresee_all(places, poses, given, walk, variances)
    seen, noise = relative.copy(), covariance.copy()
    pose, last = known.copy(), np.full(3, np.inf)
    free, nu = np.isnan(known[2]), walk.nu
    _linearise_boxes(relative, covariance, expected, walk_pose if free else known, seen, noise)
    spread, own_spread, found = std.copy(), own, expected
    yaw_information = VAGUE if np.isinf(own) else max(1.0 / walk.yaw_scale**2, VAGUE)
    for _ in range(ROUNDS):
        if free:
            pose = fit_pose(seen, noise, expected, spread, walk_pose, own_spread, yaw_information)
        found = localise(pose, seen, noise, expected, spread)
        if np.max(np.abs(pose - last)) < TOLERANCE:
            break
        last = pose
        for k in range(len(std)):
            if std[k] > ANCHOR_STD:
                squared = ((found[k, 0] - expected[k, 0]) ** 2 + (found[k, 1] - expected[k, 1]) ** 2) / std[k] ** 2
                if not np.isnan(squared):
                    spread[k] = std[k] * np.sqrt((nu + squared) / (nu + 2.0))
        squared = ((pose[0] - walk_pose[0]) ** 2 + (pose[1] - walk_pose[1]) ** 2) / own**2
        if free and not np.isnan(squared):
            own_spread = own * np.sqrt((nu + squared) / (nu + 2.0))
            yaw_information = max(2.0 / (walk.yaw_scale**2 + turn_between(walk_pose[2], pose[2]) ** 2), VAGUE)
        _linearise_boxes(relative, covariance, found, pose, seen, noise)
    return Located(pose, found, seen, noise, expected, spread, own_spread, yaw_information)


@kernel
def turn_between(before: float, now: float) -> float:
    """From one yaw to another the short way round, in rad."""
    return float((now - before + np.pi) % (2.0 * np.pi) - np.pi)


@kernel
def _linearise_boxes(
    relative: FloatArray,
    covariance: FloatArray,
    places: FloatArray,
    pose: FloatArray,
    seen: FloatArray,
    noise: FloatArray,
) -> None:
    """Write the measured places, linearised about ``places``, to ``seen`` [K, 2] and ``noise`` [K, 3]."""
    for k in range(len(places)):
        if not np.isnan(places[k, 0] + relative[k, 0]):
            q = farther(relative[k], places[k], pose)
            seen[k] = relative[k] * (2.0 * q - q * q)
            noise[k] = covariance[k] * q**4
