"""The motion prior as a banded quadratic form: innovations of walks, their weights, and DᵀWD.

An innovation is a short filter of a track (`filters`): from the fifth frame on e_t = a_t − b_1 a_{t−1} − b_2 a_{t−2},
a_t = x_t − 2x_{t−1} + x_{t−2}; before, what a shorter past allows, with a wider spread; at the second frame the
velocity. Student-t innovations with ν degrees of freedom and scale σ_k in the plane are normal ones with precision

    w_t/κ²,   w_t = (ν + 2)/(νσ_k² + m_t²),   m_t = ‖e_t‖/κ,   σ_k² = (a_0σ² + Σ u_t m_t²)/(a_0 + 2n),   u_t = w_t σ_k²,

where κ is the spread of a lower order in units of the full one's. This is the expectation–maximisation of the t
distribution (Lange, Little and Taylor 1989), with σ_k² drawn towards σ² by a_0.

After a cold start (`vbbench_baselines.common.cold_start`) each displacement d counts ½ r‖d‖² besides: velocities are
those of people, N(0, `PEOPLE_SPEED`²), told anew every `FADE` seconds. The observer may be a vehicle.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.cold_start import FADE, OBSERVER_SPEED, PEOPLE_SPEED, standing
from vbbench_baselines.common.odometry import Motions
from vbbench_baselines.joint_map.motion.heads import Head, head_of
from vbbench_baselines.joint_map.motion.pace import Pace, pace_of
from vbbench_baselines.joint_map.prior import Prior, start_of

REACH = 4
"""Frames that an innovation looks back."""

UNKNOWN = 1e3
"""In m: σ of an observer whose walk is unknown."""

SETTLED_SCALE = 1e-3
"""The search for σ_k² ends with a smaller relative change, or after `SCALE_ROUNDS`."""

SCALE_ROUNDS = 20


class Walk(NamedTuple):
    """The prior's numbers as kernels take them.

    Attributes
    ----------
    filters : [5, 5] coefficients of x_t, x_{t−1}, … x_{t−4} of the innovation of order 0 to 4 (0: none).
    spreads : [5] κ of each order; of order 1, the velocity, the standard deviation in m of a displacement.
    sigma, nu, a0 : σ in m, ν, a_0.
    own : σ in m of the observer; as of all people, or `UNKNOWN`.
    head : how the observer's head turns.
    rest, own_rest : r in 1/m² of people and of the observer; 0 unless the start is cold.
    own_pace : as κ of order 1, of the observer.
    pace : how much it counts how fast people walk.
    """

    filters: FloatArray
    spreads: FloatArray
    sigma: float
    nu: float
    a0: float
    own: float
    head: Head
    rest: float
    own_rest: float
    own_pace: float
    pace: Pace


def walk_of(prior: Prior, dt: float, ego_prior: bool = True, cold: bool = False) -> Walk:
    """The numbers of ``prior`` at frames of ``dt`` seconds; without ``ego_prior`` the observer need not be a person.

    ``cold``: whether no velocity is ever given.
    """
    prior, first = prior.at(dt), prior.speed * dt
    nu, a0, own = min(prior.nu, 1e9), min(prior.a0, 1e9), prior.sigma if ego_prior else UNKNOWN
    filters, spreads = filters_of(*prior.b, first)
    rest, own_rest, own_pace = 0.0, 0.0, first
    if cold:
        own_pace = OBSERVER_SPEED * dt
        rest, own_rest = dt / FADE / (PEOPLE_SPEED * dt) ** 2, dt / FADE / own_pace**2
    head = head_of(prior, ego_prior)
    pace = pace_of(dt, share=0.0)
    return Walk(filters, spreads, prior.sigma, nu, a0, own, head, rest, own_rest, own_pace, pace)


def let_stand(motions: Motions, poses: FloatArray, seen: IntArray, new: IntArray, walk: Walk, dt: float) -> Motions:
    """``motions`` [T] with what a cold start expects of the observer where nothing was measured: that it stands.

    Parameters
    ----------
    poses : [T, 3] as believed, the newest NaN where it is not known yet: it goes on as fast.
    seen, new : [T] how many people are seen, and how many of them for the second time, which have a first velocity.
        It counts as much as all that is expected of their velocities, times `standing`; if nobody is seen, so much
        that the observer's velocity fades within `FADE`.
    """
    moved = np.diff(poses[:, :2], axis=0, prepend=poses[:1, :2])
    speed = np.hypot(moved[:, 0], moved[:, 1]) / dt
    if len(speed) > 1 and np.isnan(speed[-1]):
        speed[-1] = speed[-2]
    speed = np.nan_to_num(speed)
    rest = np.where(
        seen > 0, (walk.rest * seen + new / walk.spreads[1] ** 2) * standing(speed), (dt / FADE / walk.sigma) ** 2
    )
    rest[motions.information.any(axis=(1, 2))] = 0.0
    return motions._replace(information=motions.information + rest[:, None, None] * np.diag((1.0, 1.0, 0.0)))


@kernel
def observer_of(walk: Walk) -> Walk:
    """The same numbers for the observer as for a person."""
    spreads = walk.spreads.copy()
    spreads[1] = walk.own_pace
    sigma, nu, a0, own, head = walk.sigma, walk.nu, walk.a0, walk.own, walk.head
    return Walk(walk.filters, spreads, sigma, nu, a0, own, head, walk.own_rest, walk.own_rest, walk.own_pace, walk.pace)


@kernel
def filters_of(b1: float, b2: float, pace: float) -> tuple[FloatArray, FloatArray]:
    """The filters and spreads of an autoregression; ``pace`` is the standard deviation in m of a displacement."""
    first, b, second = start_of(b1, b2)
    filters, spreads = np.empty((REACH + 1, REACH + 1)), np.empty(REACH + 1)
    for order in range(REACH + 1):
        near = 0.0 if order < 3 else (b if order == 3 else b1)
        far = b2 if order == 4 else 0.0
        whole = 1.0 if order > 1 else 0.0
        filters[order, 0], filters[order, 1] = whole, whole * (-2.0 - near)
        filters[order, 2] = whole * (1.0 + 2.0 * near - far)
        filters[order, 3], filters[order, 4] = whole * (2.0 * far - near), whole * -far
    filters[1, 0], filters[1, 1] = 1.0, -1.0
    spreads[0], spreads[1], spreads[2], spreads[3], spreads[4] = 1.0, pace, first, second, 1.0
    return filters, spreads


@kernel
def innovation(track: FloatArray, i: int, walk: Walk) -> float:
    """m_i² in m², the squared innovation of a track [n, 2] at its frame i ≥ 2, in units of the full order's spread."""
    order = min(i, REACH)
    e0 = e1 = 0.0
    for d in range(order + 1):
        e0 += walk.filters[order, d] * track[i - d, 0]
        e1 += walk.filters[order, d] * track[i - d, 1]
    return float((e0 * e0 + e1 * e1) / walk.spreads[order] ** 2)


@kernel
def reweigh(track: FloatArray, walk: Walk, sigma: float, weights: FloatArray, variance: float) -> tuple[float, float]:
    """Write the ``weights`` [n] of a track [n, 2], and return its σ_k² in m² and its deviance.

    The scale is looked for about ``sigma`` in m, from ``variance`` on; the deviance is −ln of the prior density, up to
    a constant.
    """
    all_frames = np.ones(len(track), np.bool_)
    return reweigh_continued(track, walk, sigma, weights, variance, all_frames, 0, np.zeros(2))


@kernel
def reweigh_continued(
    track: FloatArray,
    walk: Walk,
    sigma: float,
    weights: FloatArray,
    variance: float,
    counted: BoolArray,
    held: int,
    tally: FloatArray,
) -> tuple[float, float]:
    """`reweigh` by the innovations of the frames ``counted`` [n] alone; the others' weights are zero.

    Of a walk that began before, the innovations of its first ``held`` frames are accounted for; of those that are gone
    ``tally`` [2] holds the number and Σ u m² in m².
    """
    n, count = len(track), tally[0]
    for i in range(2, n):
        if counted[i] and i >= held:
            weights[i] = innovation(track, i, walk)
            count += 1.0
        else:
            weights[i] = 0.0
    for _ in range(SCALE_ROUNDS):
        before, total = variance, 0.0
        for i in range(2, n):
            total += weights[i] / (walk.nu * variance + weights[i])
        total *= (walk.nu + 2.0) * variance
        variance = (walk.a0 * sigma**2 + tally[1] + total) / (walk.a0 + 2.0 * count)
        if abs(variance - before) < SETTLED_SCALE * variance:
            break
    deviance = 0.5 * innovation(track, 1, walk) if n > 1 and held < 2 else 0.0
    if walk.rest > 0.0:
        for i in range(1, n):
            deviance += 0.5 * walk.rest * ((track[i, 0] - track[i - 1, 0]) ** 2 + (track[i, 1] - track[i - 1, 1]) ** 2)
    for i in range(2, n):
        if counted[i] and i >= held:
            deviance += 0.5 * (walk.nu + 2.0) * np.log(1.0 + weights[i] / (walk.nu * variance))
            weights[i] = (walk.nu + 2.0) / (walk.nu * variance + weights[i])
    deviance += 0.5 * tally[1] / variance
    scale = count * np.log(variance) + 0.5 * walk.a0 * (sigma**2 / variance + np.log(variance))
    return variance, float(deviance + scale)


@kernel
def add_walk(weights: FloatArray, walk: Walk, band: FloatArray, held: int = 0) -> None:
    """Add DᵀWD of a track with weights [n] to ``band`` [n, 5], which couples frame i with i, i−1, … i−4.

    Innovations of its first ``held`` frames are accounted for elsewhere.
    """
    for i in range(1, len(weights)):
        if walk.rest > 0.0:
            band[i, 0] += walk.rest
            band[i, 1] -= walk.rest
            band[i - 1, 0] += walk.rest
        if i < held:
            continue
        order = min(i, REACH)
        precision = (1.0 if order == 1 else weights[i]) / walk.spreads[order] ** 2
        for d in range(order + 1):
            scaled = precision * walk.filters[order, d]
            for e in range(d, order + 1):
                band[i - d, e - d] += scaled * walk.filters[order, e]
