"""Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755, eqs. 4 to 6, in the signs of pysocialforce.

Of two people i and j, with e the unit vector from j to i, d their distance and

    D = λ (v_j − v_i) + e,    t = D/|D|,    θ the angle from e to t in (−π, π],    B = γ |D|,

i feels A (exp(−d/B − (n'Bθ)²) t − sign(θ) exp(−d/B − (nBθ)²) t⊥), t⊥ being t turned left. Exchanging i and j turns D
round and leaves θ as it is: j feels the opposite, and each pair is computed once.

`strict_rows` is the repulsion of pysocialforce 1.1.2 as it is: the angle is the plain difference of two atan2, which
may pass π. Each ordered pair is computed by itself. This is slower, and paths depend on how the world is turned; it
exists to compare with the library.
"""

import math

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_generators.crowds.social_force.basics import TINY, VX, VY, X, Y, atan_unit, exp_negative


@kernel
def moussaid_rows(
    people: FloatArray, first: int, stride: int, numbers: FloatArray, pairs: FloatArray, forces: FloatArray
) -> None:
    """Add the forces (m/s²) between i and all j > i to ``forces`` [2, K], for i = first, first + stride, ...

    ``pairs`` [4, N] is scratch of N ≥ K; ``numbers`` is one record of `SETTINGS`. Rows of pairs are gathered until
    the scratch is full, computed in one loop without branches, and handed out in the order of gathering.
    """
    count = people.shape[1]
    nothing = int(np.int64(0))  # for a constant numba would compile everything anew
    start, filled = first, nothing
    for i in range(first, count, stride):
        if filled + count - i - 1 > pairs.shape[1]:
            _compute(filled, numbers, pairs)
            _hand_out(start, i, stride, pairs, forces)
            start, filled = i, nothing
        _gather(people, i, pairs[:, filled:])
        filled += count - i - 1
    _compute(filled, numbers, pairs)
    _hand_out(start, count, stride, pairs, forces)


@kernel
def _gather(people: FloatArray, i: int, row: FloatArray) -> None:
    """Write places of i less j (m) and velocities of j less i (m/s) to ``row`` [4, ≥ K − 1 − i], for all j > i."""
    x, y, vx, vy = people[X, i + 1 :], people[Y, i + 1 :], people[VX, i + 1 :], people[VY, i + 1 :]
    xi, yi, vxi, vyi = people[X, i], people[Y, i], people[VX, i], people[VY, i]
    dx, dy, ux, uy = row[0], row[1], row[2], row[3]
    for n in range(len(x)):
        dx[n] = xi - x[n]
        dy[n] = yi - y[n]
    for n in range(len(x)):
        ux[n] = vx[n] - vxi
        uy[n] = vy[n] - vyi


@kernel
def _hand_out(start: int, end: int, stride: int, pairs: FloatArray, forces: FloatArray) -> None:
    """Give i = start, start + stride, ... < end the forces of its row, and all j > i the opposite."""
    count = forces.shape[1]
    filled = 0
    for i in range(start, end, stride):
        for axis in range(2):
            row = pairs[axis, filled : filled + count - i - 1]
            others = forces[axis, i + 1 :]
            for n in range(len(row)):
                others[n] -= row[n]
            forces[axis, i] += _sum(row)
        filled += count - i - 1


@kernel
def _sum(values: FloatArray) -> float:
    """Sum in a fixed order: four interleaved sums, which the processor can add at the same time."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = len(values) // 4 * 4
    for n in range(0, whole, 4):
        a += values[n]
        b += values[n + 1]
        c += values[n + 2]
        d += values[n + 3]
    for n in range(whole, len(values)):
        a += values[n]
    return (a + b) + (c + d)


@kernel
def _compute(filled: int, numbers: FloatArray, pairs: FloatArray) -> None:
    """Replace the first ``filled`` pairs by their forces."""
    s, x, y, ux, uy = numbers[0], pairs[0], pairs[1], pairs[2], pairs[3]
    moussaid_pairs(filled, s.factor, s.velocity_weight, s.reach, s.side_sharpness, s.brake_sharpness, x, y, ux, uy)


@kernel
def moussaid_pairs(
    filled: int,
    factor: float,
    weight: float,
    reach: float,
    side: float,
    brake: float,
    x: FloatArray,
    y: FloatArray,
    ux: FloatArray,
    uy: FloatArray,
) -> None:
    """Replace the places x, y (m) of i as seen from j by the force (m/s²) on i, given velocities of j less i (m/s).

    With r = (x, y), D is taken times d, which needs no division: d D = λ d u + r, and tan(θ/2) = |λ r × u| / (|d D| +
    d + λ r·u). Coinciding people have no e and feel nothing.
    """
    for n in range(filled):
        distance = math.sqrt(x[n] * x[n] + y[n] * y[n])
        distance = distance if distance > TINY else TINY
        ix, iy = weight * distance * ux[n] + x[n], weight * distance * uy[n] + y[n]
        length = math.sqrt(ix * ix + iy * iy)
        length = length if length > TINY else TINY
        cross = weight * (x[n] * uy[n] - y[n] * ux[n])
        dot = distance + weight * (x[n] * ux[n] + y[n] * uy[n])
        around = length + abs(dot)
        # One division gives all three inverses: divisions are what takes the time here.
        inverse = 1.0 / (distance * length * around)
        angle = 2.0 * atan_unit(abs(cross) * (inverse * distance * length))
        angle = angle if dot >= 0.0 else np.pi - angle
        unit = inverse * distance * around
        spread = reach * length * (inverse * length * around) * angle
        depth = distance * distance * unit * (-1.0 / reach)
        spread *= spread
        ahead = factor * exp_negative(depth - (brake * brake) * spread)
        aside = factor * exp_negative(depth - (side * side) * spread)
        aside = aside if cross > 0.0 else -aside
        aside = aside if cross != 0.0 else 0.0
        tx, ty = ix * unit, iy * unit
        x[n] = ahead * tx + aside * ty
        y[n] = ahead * ty - aside * tx


@kernel
def strict_rows(people: FloatArray, first: int, stride: int, numbers: FloatArray, forces: FloatArray) -> None:
    """Add the force (m/s²) of everybody on i to ``forces`` [2, K], for i = first, first + stride, ..."""
    for i in range(first, people.shape[1], stride):
        for j in range(people.shape[1]):
            if j != i:
                fx, fy = _strict_pair(people, i, j, numbers)
                forces[0, i] += fx
                forces[1, i] += fy


@kernel
def _strict_pair(people: FloatArray, i: int, j: int, numbers: FloatArray) -> tuple[float, float]:
    """Force (m/s²) of j on i; none where the library gets 0/0, of people with the same place and velocity."""
    settings = numbers[0]
    ex, ey, distance = _direction(people[X, i] - people[X, j], people[Y, i] - people[Y, j])
    tx, ty, length = _direction(
        settings.velocity_weight * (people[VX, j] - people[VX, i]) + ex,
        settings.velocity_weight * (people[VY, j] - people[VY, i]) + ey,
    )
    if length == 0.0:
        return 0.0, 0.0
    scale = settings.reach * length
    angle = math.atan2(ty, tx) - math.atan2(ey, ex)
    ahead = math.exp(-distance / scale - (settings.brake_sharpness * scale * angle) ** 2)
    aside = math.exp(-distance / scale - (settings.side_sharpness * scale * angle) ** 2)
    aside = math.copysign(aside, angle) if angle != 0.0 else 0.0
    return settings.factor * (ahead * tx + aside * ty), settings.factor * (ahead * ty - aside * tx)


@kernel
def _direction(x: float, y: float) -> tuple[float, float, float]:
    """Unit vector and length; zeros stay zeros."""
    length = math.sqrt(x * x + y * y)
    return (x / length, y / length, length) if length > 0.0 else (0.0, 0.0, 0.0)
