"""The observer's motion that fits best, by Gauss–Newton steps in closed form, whose weights the network chooses.

With a motion (d, ψ), people expected at T (from the last pose) are seen at q = (T − d)·exp(−iψ); boxes show them at z,
along the ray ρ, |ρ| = 1. The residuals along and across it are the parts of r = (z − q)·ρ̄, with

    ∂r/∂d = ū, i·ū  (ahead, to the left),  u = ρ·exp(iψ),    ∂r/∂ψ = i·q·ρ̄.

What is minimised is Σ w_a (Re r − o_a)² + w_c (Im r − o_c)² + Σ λ_j (x_j − x⁰_j)², x = (Re d, Im d, ψ), about an offset o
and an expected motion x⁰.
"""

from typing import NamedTuple

from vbbench_baselines.former.operations import Array, Operations


class Motion(NamedTuple):
    """How the observer moved since the last frame: ``step`` [...] in m (complex) and ``turn`` [...] in rad."""

    step: Array
    turn: Array


class Views(NamedTuple):
    """People as a pose shows them: complex, [..., K].

    Attributes
    ----------
    expected : T from the last pose, in m.
    seen : z in m.
    ray : ρ.
    """

    expected: Array
    seen: Array
    ray: Array


class Weighing(NamedTuple):
    """What counts how much.

    Attributes
    ----------
    along, across : w [..., K] in 1/m².
    offset : o [..., K] in m, complex along and across the ray.
    inertia : λ [..., 3] in 1/m² and 1/rad².
    motion : x⁰.
    """

    along: Array
    across: Array
    offset: Array
    inertia: Array
    motion: Motion


def view(operations: Operations, views: Views, motion: Motion) -> tuple[Array, Array]:
    """q, and r: where people are seen, and how far off along and across the ray; complex [..., K] in m."""
    turned = operations.direction(-motion.turn)[..., None]
    places = (views.expected - motion.step[..., None]) * turned
    return places, (views.seen - places) * views.ray.conj()


def fit(
    operations: Operations, views: Views, weighing: Weighing, motion: Motion, times: int
) -> tuple[Motion, tuple[Array, Array, Array]]:
    """The motion after some steps from ``motion``, and the variances [...] of its three numbers."""
    variances = motion.turn, motion.turn, motion.turn
    inertia = [weighing.inertia[..., number] for number in range(3)]
    for _ in range(times):
        places, off = view(operations, views, motion)
        off = off - weighing.offset
        ahead = views.ray * operations.direction(motion.turn)[..., None]
        swing = places * views.ray.conj()
        ux, uy, along, across = ahead.real, ahead.imag, -swing.imag, swing.real
        wa, wc = weighing.along, weighing.across
        wax, way, wcx, wcy = wa * ux, wa * uy, wc * ux, wc * uy
        a = (wax * ux + wcy * uy).sum(-1) + inertia[0]
        b = (wax * uy - wcy * ux).sum(-1)
        c = (wax * along - wcy * across).sum(-1)
        d = (way * uy + wcx * ux).sum(-1) + inertia[1]
        e = (way * along + wcx * across).sum(-1)
        f = (wa * along * along + wc * across * across).sum(-1) + inertia[2]
        drift = motion.step - weighing.motion.step
        gx = (wax * off.real - wcy * off.imag).sum(-1) + inertia[0] * drift.real
        gy = (way * off.real + wcx * off.imag).sum(-1) + inertia[1] * drift.imag
        gt = (wa * along * off.real + wc * across * off.imag).sum(-1)
        gt = gt + inertia[2] * (motion.turn - weighing.motion.turn)
        xx, xy, xt, yy, yt, tt = (
            d * f - e * e,
            c * e - b * f,
            b * e - c * d,
            a * f - c * c,
            b * c - a * e,
            a * d - b * b,
        )
        scale = 1.0 / (a * xx + b * xy + c * xt)
        step = operations.point((xx * gx + xy * gy + xt * gt) * scale, (xy * gx + yy * gy + yt * gt) * scale)
        motion = Motion(motion.step - step, motion.turn - (xt * gx + yt * gy + tt * gt) * scale)
        variances = xx * scale, yy * scale, tt * scale
    return motion, variances
