"""Re-anchors a drifted observer to people whose places are certain.

A person is certain if the place at t is given, or predicted from given places only. All others are predicted from the
solver's own estimates, and have drifted with them. In the paper's energy the certain people compete with the prior of
the observer's motion, whose deviation is that of one frame, however long the drift lasted. They would correct a part of
the error only, and constant velocity would extrapolate that part as motion. Here they compete with the covariance of
the drift (`common.drift`) instead, and past poses are corrected, too:

    (c, yaw) = argmin ‖c − ĉ‖²/Var(e_t) + (yaw − ŷ)²/Var(yaw) + Σ_certain r_kᵀ W_k r_k

where (ĉ, ŷ) is the pose by the drifted people, or the predicted one. The pose of t−1 is corrected by the share
Cov(e_{t−1}, e_t)/Var(e_t) of the correction at t; the rest counts as motion.
"""

import math
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_baselines._core import fit_pose, pose_covariance
from vbbench_baselines.cascade.factors import Factors
from vbbench_baselines.common.drift import ASTRAY, Drift, variances
from vbbench_baselines.common.motion import History

CONTRADICTED = 3.0
"""How far, next to `ASTRAY`, the pose must be off for a correction, in standard deviations of what is then left."""


class Company(NamedTuple):
    """Masks [K] of people who are seen, predicted and take part; ``others`` are predicted from estimates."""

    certain: BoolArray
    others: BoolArray


def company(history: History, helpful: BoolArray) -> Company:
    """The ``helpful`` people [K], who are seen, expected and take part."""
    own = ~np.isnan(history.positions[:2, :, 0]) & ~history.position_given[:2]
    certain = helpful & (history.position_given[2] | ~own.any(axis=0))
    return Company(certain, helpful & ~certain)


def can_anchor(people: Company) -> bool:
    """Whether certain people correct the pose: there are no others, or at least two are certain, and not fewer.

    One person determines only the distance of the observer; the others, though drifted, determine its yaw better.
    """
    certain, others = int(people.certain.sum()), int(people.others.sum())
    return bool(certain > 0 and (others == 0 or certain >= max(others, 2)))


def reanchor(
    history: History, drift: Drift, factors: Factors, people: Company, facing: float, alone: tuple[float, float]
) -> FloatArray | None:
    """Correct the past in ``history``, and ``drift``; return the pose [3] by certain people, ``None`` without need.

    Parameters
    ----------
    facing : information in 1/rad² on the yaw in this frame.
    alone : variances in m² and rad² of the observer's motion within a frame without people in sight.
    """
    led, turn, fresh = factors.walk, bool(people.others.any()), alone
    if turn:
        followed = factors.of(people.others)
        led = fit_pose(followed, facing)
        fresh = variances(pose_covariance(led, followed, facing))
    common = drift.with_more(*fresh)
    certain = factors.of(people.certain)._replace(walk=led, walk_std=common.now**0.5)
    found = fit_pose(certain, 1.0 / common.yaw)
    place, yaw = variances(pose_covariance(found, certain, 1.0 / common.yaw))
    if math.dist(found[:2], led[:2]) <= ASTRAY + CONTRADICTED * turn * place**0.5:
        return None
    drift.add(*fresh)
    drift.correct(place, yaw)
    history.correct(led, found, common.across / common.now, turn=turn)
    return found
