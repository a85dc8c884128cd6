"""Weighted least-squares fit of the observer's motion by Gauss–Newton steps; the network chooses the weights.

Under a motion (d, ψ), a person predicted at T relative to the last pose is at q = (T − d)·exp(−iψ) relative to the new
one. The box measures z on the ray ρ, |ρ| = 1. The residuals along and across the ray are the real and imaginary part of
r = (z − q)·ρ̄, with

    ∂r/∂d = ū, i·ū  (forward, left),  u = ρ·exp(iψ),    ∂r/∂ψ = i·q·ρ̄.

The cost is Σ w_a (Re r − o_a)² + w_c (Im r − o_c)² + Σ λ_j (x_j − x⁰_j)², x = (Re d, Im d, ψ), with an offset o and a
predicted motion x⁰, plus the factor of `heads`.
"""

from typing import NamedTuple

from vbbench_baselines.former.heads import Head, head_equations
from vbbench_baselines.former.operations import Array, Operations


class Motion(NamedTuple):
    """How the observer moved since the last frame: ``step`` [...] in m (complex) and ``turn`` [...] in rad."""

    step: Array
    turn: Array


class Views(NamedTuple):
    """People in the fit, complex [..., K].

    Attributes
    ----------
    expected : T, relative to the last pose, in m.
    reach, seen : |z|, real, and z in m.
    ray, upright : ρ, and ρ̄, which rotates the ray onto the real axis.
    """

    expected: Array
    reach: Array
    seen: Array
    ray: Array
    upright: Array


class Weighing(NamedTuple):
    """Weights of the fit.

    Attributes
    ----------
    weights : [..., K, 2] w_a and w_c in 1/m².
    offset : o [..., K] in m, complex along and across the ray.
    inertia : λ [..., 3] in 1/m² and 1/rad².
    motion : x⁰.
    head : the factor of the observer's head; ``None`` without it.
    """

    weights: Array
    offset: Array
    inertia: Array
    motion: Motion
    head: Head | None = None


class Measured(NamedTuple):
    """The motion that odometry measured.

    Attributes
    ----------
    motion : in m and rad.
    information : [..., 3] 1/variance of forward, left and turn.
    sure : [...] 1 where it replaces the predicted motion; else it counts in addition.
    """

    motion: Motion
    information: Array
    sure: Array


def with_measured(
    operations: Operations, inertia: Array, motion: Motion, measured: Measured | None
) -> tuple[Array, Motion]:
    """λ and x⁰ (``inertia`` and ``motion``) combined with odometry."""
    if measured is None:
        return inertia, motion
    sure, total = measured.sure > 0.5, inertia + measured.information
    ahead, left, turning = operations.unstack(measured.information / total)
    off = Motion(measured.motion.step - motion.step, measured.motion.turn - motion.turn)
    step = motion.step + operations.point(ahead * off.step.real, left * off.step.imag)
    turn = motion.turn + turning * off.turn
    return operations.where(sure[..., None], measured.information, total), Motion(
        operations.where(sure, measured.motion.step, step), operations.where(sure, measured.motion.turn, turn)
    )


def view(operations: Operations, views: Views, motion: Motion) -> tuple[Array, Array]:
    """Places q and residuals r of people under a motion, complex [..., K] in m."""
    turned = operations.direction(-motion.turn)[..., None]
    places = (views.expected - motion.step[..., None]) * turned
    return places, views.reach - places * views.upright


def align(operations: Operations, views: Views, weighing: Weighing) -> Motion:
    """The best motion with isotropic weights: a rigid fit in closed form, for any turn (Umeyama 1991, in the plane).

    The predicted motion counts as one more point at 0, and as cos(ψ − ψ⁰).
    """
    (along, across), expected = operations.unstack(weighing.weights), weighing.motion
    weights, own = 2.0 * along * across / (along + across + 1e-9), weighing.inertia[..., 0]
    total = weights.sum(-1) + own
    middle = ((weights * views.expected).sum(-1) + own * expected.step) / total
    centre = (weights * views.seen).sum(-1) / total
    apart = views.expected - middle[..., None]
    turned = (weights * apart * (views.seen - centre[..., None]).conj()).sum(-1)
    turned = turned - own * (expected.step - middle) * centre.conj()
    ahead = operations.direction(expected.turn)
    turn = expected.turn + operations.angle(turned * ahead.conj() + weighing.inertia[..., 2])
    return Motion(middle - centre * operations.direction(turn), turn)


def fit(
    operations: Operations, views: Views, weighing: Weighing, motion: Motion, times: int
) -> tuple[Motion, tuple[Array, Array, Array]]:
    """The motion after ``times`` ≥ 1 steps from ``motion``, and the variances [...] of its three components.

    The variances exclude the factor of `heads`, without which the network learned to estimate its own spread.
    """
    ahead, left, turning = operations.unstack(weighing.inertia)
    weights = operations.flat(weighing.weights)
    measured = views.reach - weighing.offset
    for _ in range(times):
        a, b, c, gx, d, e, gy, f, gt = _normal_equations(operations, views, weights, measured, motion)
        drift = motion.step - weighing.motion.step
        gx, gy = gx + ahead * drift.real, gy + left * drift.imag
        gt = gt + turning * (motion.turn - weighing.motion.turn)
        plain = equations = [a + ahead, b, c, d + left, e, f + turning, gx, gy, gt]
        if weighing.head is not None:
            head = head_equations(operations, weighing.head, motion.step, motion.turn)
            equations = [one + other for one, other in zip(plain, head, strict=True)]
        xx, xy, xt, yy, yt, tt = _inverse(*equations[:6])
        gx, gy, gt = equations[6:]
        back = operations.point(xx * gx + xy * gy + xt * gt, xy * gx + yy * gy + yt * gt)
        motion = Motion(motion.step - back, motion.turn - (xt * gx + yt * gy + tt * gt))
    xx, _, _, yy, _, tt = _inverse(*plain[:6])
    return motion, (xx, yy, tt)


def _inverse(a: Array, b: Array, c: Array, d: Array, e: Array, f: Array) -> list[Array]:
    """The upper half by rows of the inverse of a symmetric 3 × 3 matrix, given its own."""
    xx, xy, xt = d * f - e * e, c * e - b * f, b * e - c * d
    scale = 1.0 / (a * xx + b * xy + c * xt)
    return [one * scale for one in (xx, xy, xt, a * f - c * c, b * c - a * e, a * d - b * b)]


def _normal_equations(
    operations: Operations, views: Views, weights: Array, measured: Array, motion: Motion
) -> list[Array]:
    """The upper half by rows of Σ JᵀwJ, each row followed by its Σ Jᵀwr, over people: nine sums [...].

    ``weights`` [..., 2 K] are w along and across by turns; ``measured`` [..., K] is z·ρ̄ − o.
    """
    ahead = views.upright * operations.direction(-motion.turn)[..., None]
    swing = (views.expected - motion.step[..., None]) * ahead
    columns = operations.stack([ahead, 1j * ahead, 1j * swing, measured - swing]).swapaxes(-1, -2)
    parts = operations.flat(operations.pairs(columns))
    sums = operations.unstack(operations.flat((parts * weights[..., None, :]) @ parts.swapaxes(-1, -2)))
    return [*sums[:4], *sums[5:8], *sums[10:12]]
