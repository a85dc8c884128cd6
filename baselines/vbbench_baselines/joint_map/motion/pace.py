"""How fast people walk, which tells how fast all move where nothing else does: most walk alike, and some stand.

The density of a velocity u in the plane is a mixture: of walkers, as N(μ, σ_w²) of its length in any direction, of
people who stand, N(0, σ_s²), and of others, N(0, σ_o²). What people want to walk has a mean of 1.34 m/s and a standard
deviation of .26 (Weidmann, Transporttechnik der Fussgänger, ETH Zürich 1993). Nobody keeps a speed for ever, and so
a velocity is told anew about once every `ANEW` seconds.

In a descent the shares of the three in a velocity are held (expectation and maximisation): its curvature is that of
three normal laws, and is never negative.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel

ANEW = 3.0
"""In s: a velocity counts once in so long."""

WALKING, STANDING, OTHERS = 0.67, 0.08, 0.25
"""Shares of people."""

SPEED, SPREADS = 1.3, (0.25, 0.2, 1.0)
"""In m/s: μ, and σ_w, σ_s and σ_o."""

LEAST = 1e-30
"""A density, in s²/m², that nothing is below."""


class Pace(NamedTuple):
    """How much velocities count: ``weight`` for each frame, which takes ``dt`` seconds; 0 = not at all."""

    weight: float
    dt: float


def pace_of(dt: float, share: float) -> Pace:
    """Of frames of ``dt`` seconds, where velocities count a ``share`` of once in `ANEW` seconds."""
    return Pace(share * dt / ANEW, dt)


@kernel
def density(x: float, y: float) -> float:
    """Of a velocity in m/s, in s²/m²."""
    walk, stand, other = _parts(x, y)
    return walk + stand + other + LEAST


@kernel
def _parts(x: float, y: float) -> tuple[float, float, float]:
    """What walkers, people who stand and others add to the density of a velocity."""
    square = x * x + y * y
    off, walk, stand, other = np.sqrt(square) - SPEED, SPREADS[0], SPREADS[1], SPREADS[2]
    return (
        WALKING * np.exp(-0.5 * (off / walk) ** 2) / ((2.0 * np.pi) ** 1.5 * SPEED * walk),
        STANDING * np.exp(-0.5 * square / stand**2) / (2.0 * np.pi * stand**2),
        OTHERS * np.exp(-0.5 * square / other**2) / (2.0 * np.pi * other**2),
    )


@kernel
def pace_deviance(track: FloatArray, pace: Pace) -> float:
    """−ln of the density of the velocities of a ``track`` [n, 2]."""
    total = 0.0
    if pace.weight > 0.0:
        for i in range(1, len(track)):
            x, y = track[i, 0] - track[i - 1, 0], track[i, 1] - track[i - 1, 1]
            total -= pace.weight * np.log(density(x / pace.dt, y / pace.dt))
    return total


@kernel
def add_pace(track: FloatArray, pace: Pace, lower: FloatArray, pull: FloatArray) -> None:
    """Add its curvature to a band (`joint_map.optimiser.banded`) and its slope to ``pull`` [2n]."""
    if pace.weight == 0.0:
        return
    for i in range(1, len(track)):
        x, y = (track[i, 0] - track[i - 1, 0]) / pace.dt, (track[i, 1] - track[i - 1, 1]) / pace.dt
        walk, stand, other = _parts(x, y)
        scale, square = pace.weight / (walk + stand + other + LEAST), x * x + y * y + LEAST
        slow = scale * (stand / SPREADS[1] ** 2 + other / SPREADS[2] ** 2)
        along = scale * walk / SPREADS[0] ** 2
        off = 1.0 - SPEED / np.sqrt(square)
        across = along * max(off, 0.0)
        a, b, c = 2 * (i - 1), 2 * i, 1.0 / pace.dt**2
        for e in range(2):
            push = (slow + along * off) * (x if e == 0 else y) / pace.dt
            pull[a + e] -= push
            pull[b + e] += push
        xx = c * (slow + across + (along - across) * x * x / square)
        xy = c * (along - across) * x * y / square
        yy = c * (slow + across + (along - across) * y * y / square)
        for p in (a, b):
            lower[p, 0] += xx
            lower[p, 1] += xy
            lower[p + 1, 0] += yy
        lower[a, 2] -= xx
        lower[a, 3] -= xy
        lower[a + 1, 1] -= xy
        lower[a + 1, 2] -= yy
