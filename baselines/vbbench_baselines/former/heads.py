"""A factor between the yaw and the motion of a walking observer: the head follows the walking direction with a lag.

Let v = d/dt be the velocity of a step and s the smoothed velocity before it, both seen from the last pose. A head that
turned by ψ then has the residual

    e = ψ − arg w,   w = s + g (v − s),   g = 1 − exp(−dt/τ),   ∂e/∂ψ = 1,   ∂e/∂d = −(g/dt)·(−Im w, Re w)/|w|²,

in the pose fit (`pose_fit`), e ~ Cauchy(γ). Other heads follow loosely, e ~ Cauchy(γ₁), or turn independently of the
motion, ψ ~ Cauchy(γ₀ dt). An observer keeps one of the three modes; the residual is weighted by the posterior of the
first. Nothing here is learned: g and τ are those of ``look = motion``, and the γ were chosen on simulated crowds with
heads of all three modes. docs/learned-solver.md explains the choice of prior odds.
"""

import math
from typing import NamedTuple

from vbbench_baselines.former.operations import Array, Operations

LAG = 0.8
"""τ in s: about one stride."""
STANDING = 0.3
"""In m/s; the heads of those who are slower show nothing."""
FOLLOWING, LOOSE, WANDERING = 0.005, 0.03, 0.4
"""γ and γ₁ in rad, γ₀ in rad/s."""
FIRST_ODDS, MOST_ODDS = math.log(1.0 / 3.0), 10.0
"""The logarithm of the odds that a head just follows its way, before any frame, and by how much frames change it."""


class Head(NamedTuple):
    """The head before a frame, arrays [...].

    Attributes
    ----------
    kept : (1 − g) s in m/s, complex.
    gain : g/dt in 1/s.
    share : posterior probability of the first mode, in which the head follows the motion closely.
    """

    kept: Array
    gain: Array
    share: Array


def head_of(xp: Operations, smooth: Array, odds: Array, dt: Array) -> Head:
    """The head before a frame of ``dt`` [...] s, by the smoothed velocity ``smooth`` [...] and the log ``odds``."""
    gain = _gain(xp, dt)
    return Head(smooth * (1.0 - gain), gain / dt, xp.sigmoid(odds + FIRST_ODDS))


def smoothed(xp: Operations, smooth: Array, step: Array, dt: Array) -> Array:
    """The smoothed velocity [...] after one more ``step`` in m/s."""
    return smooth + (step - smooth) * _gain(xp, dt)


def odds_after(xp: Operations, odds: Array, smooth: Array, turn: Array, dt: Array) -> Array:
    """The log odds [...] of the first mode after a frame in which the head turned by ``turn`` in rad/s.

    ``smooth`` is the smoothed velocity, this frame included, in the axes of the new pose.
    """
    off, turned, wandering = _facing(xp, smooth) ** 2, (turn * dt) ** 2, WANDERING * dt
    others = LOOSE / (LOOSE**2 + off) + wandering / (wandering**2 + turned)
    evidence = xp.log(2.0 * FOLLOWING / (FOLLOWING**2 + off) / others)
    return xp.clip(odds + evidence * _walks(smooth), -MOST_ODDS, MOST_ODDS)


def head_equations(xp: Operations, head: Head, step: Array, turn: Array) -> list[Array]:
    """Normal equations [...] at a ``step`` in m and a ``turn`` in rad: six of the upper half of JᵀwJ, three of Jᵀwe."""
    way = head.kept + step * head.gain
    off = turn - _facing(xp, way)
    weight = 2.0 * head.share * _walks(way) / (FOLLOWING**2 + off**2)
    scale = head.gain / (way.real**2 + way.imag**2 + 1e-4)
    ahead, left = way.imag * scale, -way.real * scale
    wx, wy = weight * ahead, weight * left
    return [wx * ahead, wx * left, wx, wy * left, wy, weight, wx * off, wy * off, weight * off]


def _gain(xp: Operations, dt: Array) -> Array:
    return 1.0 - xp.exp(dt * (-1.0 / LAG))


def _facing(xp: Operations, way: Array) -> Array:
    """Direction in rad of a velocity [...]; 0 if it is 0."""
    return xp.angle(way + 1e-4)


def _walks(way: Array) -> Array:
    """Weight from 0 (stands) to 1 (walks) of a velocity [...]."""
    square = (way.real**2 + way.imag**2) ** 2
    return square / (square + STANDING**4)
