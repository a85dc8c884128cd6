"""Where the observer is by the people whose places are certain, once its own estimates have drifted away from them.

People are certain whose place is given at t, or whose walk is expected from given places only. Everybody else is
expected where the solver put them, and has drifted with it. In the paper's energy a few certain people stand against
the observer's own walk, whose deviation is that of one frame however long nobody was seen: they move the observer by a
part of the error only, and constant velocity takes that part for motion and carries it on, more in every frame. Here
the certain people meet what the drift (`common.drift`) leaves unsure instead, and what they move is the past:

    (c, yaw) = argmin ‖c − ĉ‖²/Var(e_t) + (yaw − ŷ)²/Var(yaw) + Σ_certain r_kᵀ W_k r_k

about the pose (ĉ, ŷ) to which the drifted people, or nobody, lead. By the share Cov(e_{t−1}, e_t)/Var(e_t) of the
correction the pose of t−1 was wrong already; the rest was motion.
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
    """Who is seen, expected and takes part: [K] whether a person is certain, or expected by the solver's own places."""

    certain: BoolArray
    others: BoolArray


def company(history: History, helpful: BoolArray) -> Company:
    """The ``helpful`` people [K], who are seen, expected and take part."""
    own = ~np.isnan(history.positions[:2, :, 0]) & ~history.position_given[:2]
    certain = helpful & (history.position_given[2] | ~own.any(axis=0))
    return Company(certain, helpful & ~certain)


def can_anchor(people: Company) -> bool:
    """Whether those who are certain find the observer: they are alone, or two or more and not outnumbered.

    One person determines the observer's distance alone, and others, though they have drifted, determine its yaw better.
    Where others are the most, the energy of all is left as it is.
    """
    certain, others = int(people.certain.sum()), int(people.others.sum())
    return bool(certain > 0 and (others == 0 or certain >= max(others, 2)))


def reanchor(
    history: History, drift: Drift, factors: Factors, people: Company, facing: float, alone: tuple[float, float]
) -> FloatArray | None:
    """The pose [3] by those who are certain, if it is another; the past of ``history`` then moves, and ``drift`` knows.

    Parameters
    ----------
    facing : information in 1/rad² on the yaw in this frame.
    alone : variances in m² and rad² of what an observer does within a frame that nobody shows.
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
