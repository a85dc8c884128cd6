"""Motion models: forces that divert people from constant velocity. A new model is a class with one method.

A model with the force F (an acceleration in m/s²) measures a walk by D_k = ‖F_k − ẍ_k‖ (arXiv 2111.05060, eq. 10 and
11). With ẍ = (x − 2x' + x'')/dt² this is the distance of x from the expectation 2x' − x'' + dt²F, divided by dt²; the
model gives dt²F; the solver applies its own loss to the distance.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_baselines._core import adapt_velocities, continue_observer, continue_people
from vbbench_baselines.common.cold_start import OBSERVER_SPEED, PEOPLE_SPEED, kept_velocities, standing
from vbbench_baselines.common.motion import History, Spreads

PATIENCE = 12.0
"""In s; an observer who saw nobody of use for longer is no longer expected to walk on as before."""


class Walkers(NamedTuple):
    """People and, last, the observer at t−1; NaN = unknown.

    Attributes
    ----------
    positions, velocities : [N, 2] in m and m/s.
    dt : seconds per frame.
    """

    positions: FloatArray
    velocities: FloatArray
    dt: float


class MotionModel(Protocol):
    """The force term of a walk."""

    def displace(self, walkers: Walkers) -> FloatArray:
        """dt²F [N, 2] in m of each walker; zero where its velocity is unknown."""


class StraightWalk:
    """Constant velocity: no force (eq. 10)."""

    def displace(self, walkers: Walkers) -> FloatArray:
        """See `MotionModel.displace`."""
        return np.zeros_like(walkers.positions)


@dataclass(frozen=True, kw_only=True)
class SocialForceWalk:
    """Velocities drawn towards those of the people around: F = (w − ẋ)/η (eq. 11, in seconds).

    With the velocity ẋ at t−1 the displacement is dt·r(w − ẋ), r = dt/η. With the velocity at t, ẋ = (x − x')/dt,
    ẍ = F is solved for x: dt·r/(1 + r)·(w − ẋ'), the implicit step, which never overshoots.

    Parameters
    ----------
    relaxation : η in s.
    radius : distance in m within which people at t−1 walk together; w is their mean velocity, oneself included.
    implicit : whether ẋ is the velocity at t, as ẍ is the acceleration there.
    """

    relaxation: float = 0.5
    radius: float = 1.0
    implicit: bool = True

    def displace(self, walkers: Walkers) -> FloatArray:
        """See `MotionModel.displace`."""
        rate = walkers.dt / self.relaxation
        rate = rate / (1.0 + rate) if self.implicit else rate
        return adapt_velocities(walkers.positions, walkers.velocities, self.radius, rate) * walkers.dt


def expect(
    model: MotionModel, history: History, chosen: BoolArray, spreads: Spreads, dt: float
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Predictions of ``model`` after ``history``; forces act among the ``chosen`` [K] and the observer only.

    Returns
    -------
    Places [K, 2] of people and their standard deviations [K] in m, NaN = no prediction; the observer's pose [3], its
    yaw held, and the standard deviation in m of its place.
    """
    kept, own_kept = kept_shares(history, dt)
    people, std = continue_people(history.positions, history.position_given, spreads, kept)
    walk, walk_std = continue_observer(history.poses, history.pose_given, spreads, own_kept)
    if history.cold:
        walk_std = _let_stand(walk, walk_std, history, spreads, dt)
    before, last = (
        np.concatenate((history.positions[row, chosen], history.poses[row : row + 1, :2])) for row in (0, 1)
    )
    moved = model.displace(Walkers(last, (last - before) / dt, dt))
    walk[:2] += moved[-1]
    people[chosen] += np.where(np.isnan(history.positions[2, chosen]), moved[:-1], 0.0)
    return people, std, walk, walk_std


def kept_shares(history: History, dt: float) -> tuple[float, float]:
    """The shares of the velocities of people and of the observer that are expected to last until the next frame."""
    if history.cold:
        return kept_velocities(dt, bool(history.seen.any()))
    fading = history.blind * dt > PATIENCE
    return 1.0, kept_velocities(dt, watched=False)[1] if fading else 1.0


def _let_stand(walk: FloatArray, walk_std: float, history: History, spreads: Spreads, dt: float) -> float:
    """Fuse the predicted pose [3], in place, with the prior of `standing`; returns its standard deviation in m."""
    steps = np.diff(history.poses[:2, :2], axis=0)
    speed = np.nan_to_num(np.hypot(*steps.T) / dt)
    share, new = float(standing(speed)[0]), int(np.count_nonzero(history.seen & history.new))
    if not history.moving:
        return float((OBSERVER_SPEED**-2 + share * new * PEOPLE_SPEED**-2) ** -0.5 * dt)
    if walk_std > 0.0:
        fading = 1.0 - kept_velocities(dt, True)[0]
        pull = share * (fading * np.count_nonzero(history.seen) + new * (walk_std / spreads.stay) ** 2)
        walk[:2] = (walk[:2] + pull * history.poses[1, :2]) / (1.0 + pull)
        walk_std /= (1.0 + pull) ** 0.5
    return walk_std
