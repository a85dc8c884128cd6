"""Where everybody is expected next, by the autoregression, on a past that is known."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.learning import known_before
from vbbench_baselines.joint_map.walks import REACH, Walk
from vbbench_baselines.motion import ANCHOR_STD


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
            expected[k, 0], expected[k, 1], std[k] = given[k, 0], given[k, 1], ANCHOR_STD
    pose = poses[-1].copy()
    if np.isnan(pose[0]):
        return expected, std, np.zeros(3), np.inf
    pose[0], pose[1], own = foresee(poses[:, :2], walk, variances[-1])
    return expected, std, pose, own
