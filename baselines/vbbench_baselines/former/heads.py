"""What the observer's head shows of its step: who walks looks where the way leads, and comes round with a lag.

With the velocity v = d/dt of a step and the mean velocity s of late, both from the last pose, a head that turned by ψ
is off its way by

    e = ψ − arg w,   w = s + g (v − s),   g = 1 − exp(−dt/τ),   ∂e/∂ψ = 1,   ∂e/∂d = −(g/dt)·(−Im w, Re w)/|w|²,

which is one more residual of the pose's fit (`pose_fit`), e ~ Cauchy(γ). Other heads follow loosely, e ~ Cauchy(γ₁),
or turn whatever their bearer does, ψ ~ Cauchy(γ₀ dt). One head does the same all the time: all frames so far show how
probable each is, and the residual counts with the probability of the first. Nothing of this is learned: g and τ are
those of ``look = motion``, γ's were chosen on simulated crowds with three kinds of heads, and docs/learned-solver.md
says what the first odds trade.
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
    """What is known of the head before a frame, [...].

    Attributes
    ----------
    kept : (1 − g) s in m/s, complex.
    gain : g/dt in 1/s.
    share : how probable it is that the head just follows its way.
    """

    kept: Array
    gain: Array
    share: Array


def head_of(xp: Operations, smooth: Array, odds: Array, dt: Array) -> Head:
    """Before a frame of ``dt`` [...] s, at the mean velocity ``smooth`` [...] of late and the ``odds`` [...] so far."""
    gain = _gain(xp, dt)
    return Head(smooth * (1.0 - gain), gain / dt, xp.sigmoid(odds + FIRST_ODDS))


def smoothed(xp: Operations, smooth: Array, step: Array, dt: Array) -> Array:
    """The mean velocity [...] of late after one more ``step`` in m/s."""
    return smooth + (step - smooth) * _gain(xp, dt)


def odds_after(xp: Operations, odds: Array, smooth: Array, turn: Array, dt: Array) -> Array:
    """What frames say of the odds [...], in logarithms, after one that turned the head by ``turn`` in rad/s.

    ``smooth`` is the mean velocity of late, that of the frame included, from where the head looks now.
    """
    off, turned, wandering = _facing(xp, smooth) ** 2, (turn * dt) ** 2, WANDERING * dt
    others = LOOSE / (LOOSE**2 + off) + wandering / (wandering**2 + turned)
    told = xp.log(2.0 * FOLLOWING / (FOLLOWING**2 + off) / others)
    return xp.clip(odds + told * _walks(smooth), -MOST_ODDS, MOST_ODDS)


def head_equations(xp: Operations, head: Head, step: Array, turn: Array) -> list[Array]:
    """After a ``step`` in m and a ``turn``: the upper half of JᵀwJ by rows, and Jᵀwe, nine numbers [...]."""
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
    """In rad, where a velocity [...] points; 0 if it is 0."""
    return xp.angle(xp.point(way.real + 1e-4, way.imag))


def _walks(way: Array) -> Array:
    """How much a person walks at a velocity [...], from 0 to 1."""
    square = (way.real**2 + way.imag**2) ** 2
    return square / (square + STANDING**4)
