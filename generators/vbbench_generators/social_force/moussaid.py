"""Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755, eqs. 4 to 6, in the signs of pysocialforce.

Of two people i and j, with e the unit vector from j to i, d their distance and

    D = λ (v_j − v_i) + e,    t = D/|D|,    θ the angle from e to t in (−π, π],    B = γ |D|,

i feels A (exp(−d/B − (n'Bθ)²) t − sign(θ) exp(−d/B − (nBθ)²) t⊥), t⊥ being t turned left. Exchanging i and j turns D
round and leaves θ as it is: j feels the opposite, and each pair is computed once.
"""

import math

import numpy as np

from vbbench.arrays import FloatArray, IntArray
from vbbench_generators.social_force.compiled import kernel
from vbbench_generators.social_force.elementary import TINY, atan_unit, exp_negative
from vbbench_generators.social_force.layout import VX, VY, X, Y

FORCE_ERROR = 1e-8
"""What a person may miss in m/s² because pairs too far apart are skipped."""


@kernel
def moussaid_rows(
    people: FloatArray,
    first: int,
    stride: int,
    numbers: FloatArray,
    pairs: FloatArray,
    partners: IntArray,
    forces: FloatArray,
) -> None:
    """Add the forces (m/s²) between i and all j > i to ``forces`` [2, K], for i = first, first + stride, ...

    ``pairs`` [4, N] and ``partners`` [2, N] are scratch of N ≥ K; ``numbers`` is one record of `SETTINGS`.
    """
    count = people.shape[1]
    weight = numbers[0].velocity_weight
    # |force| ≤ √2 A exp(−d/B), and B² ≤ 2γ² (1 + λ²|v_j − v_i|²) because (1 + a)² ≤ 2(1 + a²).
    depth = math.log(max(1.5 * numbers[0].factor * count / FORCE_ERROR, 1.0))
    bound = 2.0 * (depth * numbers[0].reach) ** 2
    filled = 0
    for i in range(first, count, stride):
        if filled + count - i > pairs.shape[1]:
            _push(filled, numbers, pairs, partners, forces)
            filled = 0
        filled = _gather(people, i, bound, weight * weight, pairs, partners, filled)
    _push(filled, numbers, pairs, partners, forces)


@kernel
def _gather(
    people: FloatArray,
    i: int,
    bound: float,
    squared_weight: float,
    pairs: FloatArray,
    partners: IntArray,
    filled: int,
) -> int:
    """Append the pairs (i, j > i) that are near enough to matter; returns how many there are now."""
    x, y, vx, vy = people[X], people[Y], people[VX], people[VY]
    for j in range(i + 1, people.shape[1]):
        dx, dy = x[i] - x[j], y[i] - y[j]
        ux, uy = vx[j] - vx[i], vy[j] - vy[i]
        pairs[0, filled], pairs[1, filled], pairs[2, filled], pairs[3, filled] = dx, dy, ux, uy
        partners[0, filled], partners[1, filled] = i, j
        near = dx * dx + dy * dy <= bound * (1.0 + squared_weight * (ux * ux + uy * uy))
        filled += 1 if near else 0
    return filled


@kernel
def _push(filled: int, numbers: FloatArray, pairs: FloatArray, partners: IntArray, forces: FloatArray) -> None:
    """Compute the gathered pairs and hand both people their force, in the order of gathering."""
    settings = numbers[0]
    moussaid_pairs(
        filled,
        settings.factor,
        settings.velocity_weight,
        settings.reach,
        settings.side_sharpness,
        settings.brake_sharpness,
        pairs[0],
        pairs[1],
        pairs[2],
        pairs[3],
    )
    fx, fy = forces[0], forces[1]
    for n in range(filled):
        i, j = partners[0, n], partners[1, n]
        fx[i] += pairs[0, n]
        fy[i] += pairs[1, n]
        fx[j] -= pairs[0, n]
        fy[j] -= pairs[1, n]


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

    Coinciding people have e = 0 and are pushed along their relative velocity; with the same velocity, not at all.
    """
    for n in range(filled):
        distance = math.sqrt(x[n] * x[n] + y[n] * y[n])
        inverse = 1.0 / (distance if distance > TINY else TINY)
        ex, ey = x[n] * inverse, y[n] * inverse
        ix, iy = weight * ux[n] + ex, weight * uy[n] + ey
        length = math.sqrt(ix * ix + iy * iy)
        length = length if length > TINY else TINY
        tx, ty = ix / length, iy / length
        cross = weight * (ex * uy[n] - ey * ux[n])
        dot = 1.0 + weight * (ex * ux[n] + ey * uy[n])
        angle = 2.0 * atan_unit(abs(cross) / (length + abs(dot)))
        angle = angle if dot >= 0.0 else np.pi - angle
        scale = reach * length
        spread = scale * angle
        depth = -distance / scale
        ahead = factor * exp_negative(depth - (brake * spread) * (brake * spread))
        aside = factor * exp_negative(depth - (side * spread) * (side * spread))
        aside = aside if cross > 0.0 else -aside
        aside = aside if cross != 0.0 else 0.0
        x[n] = ahead * tx + aside * ty
        y[n] = ahead * ty - aside * tx
