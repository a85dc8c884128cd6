"""What the known past of a sequence teaches about its people: each person's σ_k, and their common b and σ.

One-step reveals where people truly were, and with it how these people are annotated and walk, which differs from one
recording to the next. Revealed innovations e = a_0 − b_1 a_1 − b_2 a_2 count with their precision w = (ν + 2)/(νσ_k² +
m²), as in `vbbench_baselines.joint_map.motion.walks`:

    b     = (I/s_b² + Σ w AᵀA)⁻¹ (b_fitted/s_b² + Σ w Aᵀa_0),   A = (a_1, a_2),
    σ_k²  = (a_0σ² + Σ w σ_k² m²)/(a_0 + 2n),
    1/σ²  = (s_σ/σ_fitted² + Σ 1/σ_k²)/(s_σ + people known),

each the most probable value given the rest (steps of expectation and maximisation). s_b and s_σ say how firmly the
fitted values are believed; they belong to the prior, and are fitted too (`vbbench_baselines.joint_map.priors.lessons`).
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, Head, evidence
from vbbench_baselines.joint_map.motion.walks import REACH, UNKNOWN, Walk, filters_of, innovation
from vbbench_baselines.joint_map.prior import Prior

STATIONARY = 0.95
"""Partial autocorrelations are kept below it."""


class Lessons(NamedTuple):
    """What was learned up to some frame; written over frame by frame.

    Attributes
    ----------
    normal, slope : [2, 2] and [2] of the equations for b.
    scales : [K + 1, 2] Σ w σ_k² m² and the number of innovations of each person, the observer last.
    variances : [K + 1] σ_k² in m².
    sigma : [1] σ in m.
    sigma_people : s_σ, the number of people as which the fitted σ counts.
    odds : [M] what is added to the logarithms of the odds that the head follows by each law.
    """

    normal: FloatArray
    slope: FloatArray
    scales: FloatArray
    variances: FloatArray
    sigma: FloatArray
    sigma_people: float
    odds: FloatArray


def nothing_learned(people: int, walk: Walk, prior: Prior) -> Lessons:
    """Before anything is revealed of ``people`` and the observer; ``walk`` is that of the ``prior``."""
    normal = np.eye(2) / prior.b_std**2
    b = np.array((-2.0 - walk.filters[REACH, 1], -walk.filters[REACH, 4]))
    scales, variances = np.zeros((people + 1, 2)), np.full(people + 1, walk.sigma**2)
    variances[-1] = walk.own**2
    return Lessons(
        normal, normal @ b, scales, variances, np.full(1, walk.sigma), prior.sigma_people, np.zeros(FOLLOWERS)
    )


def only(columns: IntArray, lessons: Lessons) -> Lessons:
    """The lessons as of the people in the ``columns`` [M] and the observer alone, to be read."""
    rows = np.append(columns, -1)
    return lessons._replace(scales=lessons.scales[rows], variances=lessons.variances[rows])


def forget(columns: IntArray, lessons: Lessons) -> None:
    """Drop what was learned of single people: the ``columns`` [M] stand for new ones."""
    lessons.scales[columns], lessons.variances[columns] = 0.0, lessons.sigma[0] ** 2


@kernel
def taught(fitted: Walk, lessons: Lessons) -> Walk:
    """The prior ``fitted`` with what was learned."""
    b1, b2 = np.linalg.solve(lessons.normal, lessons.slope)
    b2 = min(max(b2, -STATIONARY), STATIONARY)
    b1 = min(max(b1, -STATIONARY * (1.0 - b2)), STATIONARY * (1.0 - b2))
    filters, spreads = filters_of(b1, b2, fitted.spreads[1])
    head = fitted.head
    head = Head(head.gains, head.slow, head.following, head.wandering, head.odds + lessons.odds)
    sigma, nu, a0, own, first = lessons.sigma[0], fitted.nu, fitted.a0, fitted.own, fitted.own_pace
    return Walk(filters, spreads, sigma, nu, a0, own, head, fitted.rest, fitted.own_rest, first, fitted.pace)


@kernel
def known_before(places: FloatArray) -> int:
    """How many frames in a row are known at the end of places [n, 2], up to five."""
    n, count = len(places), 0
    while count <= REACH and count < n and not np.isnan(places[n - 1 - count, 0]):
        count += 1
    return count


@kernel
def learn(places: FloatArray, poses: FloatArray, fitted: Walk, lessons: Lessons) -> None:
    """Learn from the newest of the revealed places [n, K, 2] and poses [n, 3]."""
    walk = taught(fitted, lessons)
    for k in range(len(lessons.scales)):
        walked = poses[:, :2] if k == len(lessons.scales) - 1 else places[:, k]
        count = known_before(walked)
        if count >= 3:
            _count(walked[len(walked) - count :], k, walk, lessons)
    if known_before(poses[:, :2]) >= 2:
        for law, told in enumerate(evidence(poses[-2:], fitted.head)):
            lessons.odds[law] += told
    _conclude(fitted, lessons)


@kernel
def _count(track: FloatArray, k: int, walk: Walk, lessons: Lessons) -> None:
    """Take in the newest innovation of a track [n, 2], n ≥ 3."""
    n, variance = len(track), lessons.variances[k]
    squared = innovation(track, n - 1, walk)
    precision = (walk.nu + 2.0) / (walk.nu * variance + squared)
    lessons.scales[k, 0] += precision * variance * squared
    lessons.scales[k, 1] += 1.0
    if n <= REACH:
        return
    last = track[::-1]
    second = last[:3] - 2.0 * last[1:4] + last[2:5]  # the last second difference, and the two before it
    for i in range(1, 3):
        lessons.slope[i - 1] += precision * (second[0, 0] * second[i, 0] + second[0, 1] * second[i, 1])
        for j in range(1, 3):
            product = second[i, 0] * second[j, 0] + second[i, 1] * second[j, 1]
            lessons.normal[i - 1, j - 1] += precision * product


@kernel
def _conclude(fitted: Walk, lessons: Lessons) -> None:
    """Renew σ and each person's σ_k²."""
    sigma_precision, people = lessons.sigma_people / fitted.sigma**2, lessons.sigma_people
    walkers = len(lessons.scales) - 1 if fitted.own == UNKNOWN else len(lessons.scales)
    for k in range(walkers):
        if lessons.scales[k, 1] > 0.0:
            sigma_precision += 1.0 / lessons.variances[k]
            people += 1.0
    variance = people / sigma_precision
    for k in range(walkers):
        total, count = lessons.scales[k, 0], lessons.scales[k, 1]
        lessons.variances[k] = (fitted.a0 * variance + total) / (fitted.a0 + 2.0 * count)
    lessons.sigma[0] = np.sqrt(variance)
