"""The terms of a frame's energy: where people are measured and expected, how tall they are, and who interacts.

``baselines/cpp/cascade/ego_motion.hpp`` derives the terms of the pose. Edges of the crowd graph join each person with
its nearest neighbours within reach. Two people at distance d feel the pairwise potential of arXiv 2111.05060, eq. 12
(σ² = 1 m²),

    V_ik = ‖∇ exp(−d²/2σ²)‖ = (d/σ²) exp(−d²/2σ²),

in m/s², like D_k: greatest at d = σ, zero for people far apart. In very large crowds only the nearest people take part.
"""

import math
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_baselines._core import fit_pose, learn_heights, pose_covariance
from vbbench_baselines.common.bearings import Sightings
from vbbench_baselines.common.drift import ASTRAY, Drift, variances
from vbbench_baselines.common.motion import History

VAGUE = 1e-6
"""Information (1/m² and 1/rad²) that holds the pose at its prediction where people say nothing about it."""


class Factors(NamedTuple):
    """The terms of a frame's energy.

    Attributes
    ----------
    relative : [K, 2] measured (right, forward) in m, NaN = not observed.
    covariance : [K, 3] its covariance (rr, rf, ff) in m².
    expected, std : [K, 2] and [K] where people are expected, in m, NaN = unknown.
    walk, walk_std : [3] the observer's own predicted pose and the standard deviation in m of its place, inf for no
        such prior.
    """

    relative: FloatArray
    covariance: FloatArray
    expected: FloatArray
    std: FloatArray
    walk: FloatArray
    walk_std: float

    def of(self, chosen: BoolArray) -> "Factors":
        """The terms of the ``chosen`` people [K] and the observer."""
        relative, covariance, expected, std = (rows[chosen] for rows in self[:4])
        return Factors(relative, covariance, expected, std, self.walk, self.walk_std)

    @property
    def helpful(self) -> BoolArray:
        """[K] who is observed and expected."""
        return ~np.isnan(self.std + self.relative[:, 0])


class CrowdGraph(NamedTuple):
    """The interacting pairs and the strength of their potential.

    Attributes
    ----------
    edges : [E, 2] people (i, j).
    strength, sigma : λ, and σ in m, of λV.
    """

    edges: IntArray
    strength: float
    sigma: float


def select(observations: FloatArray, most: int, smallest: float) -> BoolArray:
    """Which people [K] take part: all if at most ``most`` are seen, else the ``most`` of greatest box height.

    Parameters
    ----------
    observations : [K, 3] boxes in px, NaN = not observed; in a large crowd these people take no part.
    smallest : ε, the box height in px above which people are selected from a large crowd.
    """
    size = np.nan_to_num(observations[:, 2])
    if np.count_nonzero(size) <= most:
        return np.ones(len(size), np.bool_)
    chosen: BoolArray = (size >= np.partition(size, -most)[-most]) & (size > smallest)
    return chosen


def nearest(rays: FloatArray, most: int) -> BoolArray:
    """Which people [K] are the ``most`` nearest by their rays [K, 2] (see `Sightings`), all if there are no more."""
    distance = np.hypot(rays[:, 0], rays[:, 1])
    if np.count_nonzero(~np.isnan(distance)) <= most:
        return np.ones(len(rays), np.bool_)
    near: BoolArray = distance <= np.partition(distance, most - 1)[most - 1]
    return near


class Heights:
    """Posterior N(mean, variance) of each track's height, starting from the prior N(μ_h, σ_h²).

    A person at relative position z, seen on the ray ρ, has the height h = z·ρ/‖ρ‖², which noise in the box gives the
    variance h²·2σ²/l² + (h σ ρ·ρ'/‖ρ‖²)² and an error of the pose, (pose_std/‖ρ‖)², and of the place likewise.

    Parameters
    ----------
    people : number of tracks K.
    mean, std : the prior, in m.
    limits : range of plausible heights in m; the mean is kept in it, in case poses are wrong.
    pose_std : standard deviation in m of the distances that the solver's own poses give.
    """

    def __init__(self, people: int, mean: float, std: float, limits: tuple[float, float], pose_std: float) -> None:
        self.mean: FloatArray = np.full(people, mean)
        self.variance: FloatArray = np.full(people, std * std)
        self._prior, self._limits = (mean, std * std), limits
        self._pose_std = pose_std

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self.mean[columns], self.variance[columns] = self._prior

    def learn(self, history: History, previous: Sightings) -> None:
        """Update from the positions that are given of frame t−1, and its boxes; called once per frame."""
        spread = np.where(history.position_given[1], 0.0, np.nan)
        places, pose_std = history.positions[1], 0.0 if history.pose_given[1] else self._pose_std
        learn_heights(self.mean, self.variance, history.poses[1], places, spread, previous, pose_std, *self._limits)


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
