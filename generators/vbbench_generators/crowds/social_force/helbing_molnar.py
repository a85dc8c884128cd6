"""Repulsion of Helbing & Molnár, Phys. Rev. E 51 (1995) 4282: elliptical potentials about people, round ones at walls.

With r from j to i, s = speed of j times Δt and e the direction in which j wants to walk (eqs. 3 and 4 there):

    V(b) = V0 exp(−b/σ),    2b = √((|r| + |r − s e|)² − s²),    f = −∇_r V

f counts c times if −f lies outside the field of view of i: e_i·(−f) < |f| cos φ (eqs. 6 and 7). The nearest point of
every wall repels with −∇ U0 exp(−d/R) (eq. 5).
"""

import math

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_generators.crowds.social_force.basics import TARGET_X, TARGET_Y, TINY, VX, VY, X, Y, exp_negative

FORCE_ERROR = 1e-8
"""What a person may miss in m/s² because pairs too far apart are skipped."""

SOFTEST = 1e-6
"""b in m is at least this; on the line that the other is about to walk the gradient has no direction."""


@kernel
def helbing_molnar_rows(
    people: FloatArray,
    first: int,
    stride: int,
    numbers: FloatArray,
    pairs: FloatArray,
    partners: IntArray,
    forces: FloatArray,
) -> None:
    """Add the force (m/s²) of everybody on i to ``forces`` [2, K], for i = first, first + stride, ...

    ``pairs`` [4, N] and ``partners`` [2, N] are scratch of N ≥ K; ``numbers`` is one record of `SETTINGS`.
    """
    count = people.shape[1]
    settings = numbers[0]
    strides = _strides(people, settings.stride_time)
    # b² ≥ r·(r − s e); the gradient of b is at most (b + s)/b long, which the margin of 20 stands for.
    depth = math.log(max(20.0 * settings.factor / settings.fall_off * count / FORCE_ERROR, 1.0))
    bound = (depth * settings.fall_off) ** 2
    nothing = int(np.int64(0))  # for a constant numba would compile everything anew
    filled = nothing
    for i in range(first, count, stride):
        if filled + count > pairs.shape[1]:
            _push(filled, people, numbers, pairs, partners, forces)
            filled = nothing
        filled = _gather(people, strides, i, bound, pairs, partners, filled)
    _push(filled, people, numbers, pairs, partners, forces)


@kernel
def _strides(people: FloatArray, stride_time: float) -> FloatArray:
    """[2, K] s e in m: what each person walks within ``stride_time`` towards the current goal."""
    length = np.sqrt(people[VX] * people[VX] + people[VY] * people[VY]) * stride_time
    strides: FloatArray = people[TARGET_X : TARGET_Y + 1] * length
    return strides


@kernel
def _gather(
    people: FloatArray,
    strides: FloatArray,
    i: int,
    bound: float,
    pairs: FloatArray,
    partners: IntArray,
    filled: int,
) -> int:
    """Append the pairs (i, j ≠ i) that are near enough to matter; returns how many there are now."""
    x, y, sx, sy = people[X], people[Y], strides[0], strides[1]
    for j in range(people.shape[1]):
        dx, dy = x[i] - x[j], y[i] - y[j]
        pairs[0, filled], pairs[1, filled], pairs[2, filled], pairs[3, filled] = dx, dy, sx[j], sy[j]
        partners[0, filled] = i
        near = dx * (dx - sx[j]) + dy * (dy - sy[j]) <= bound
        filled += 1 if near and j != i else 0
    return filled


@kernel
def _push(
    filled: int,
    people: FloatArray,
    numbers: FloatArray,
    pairs: FloatArray,
    partners: IntArray,
    forces: FloatArray,
) -> None:
    """Compute the gathered pairs and hand i the force, less of it where i does not see j."""
    settings = numbers[0]
    helbing_molnar_pairs(filled, settings.factor, settings.fall_off, pairs[0], pairs[1], pairs[2], pairs[3])
    for n in range(filled):
        i, fx, fy = partners[0, n], pairs[0, n], pairs[1, n]
        facing = -(people[TARGET_X, i] * fx + people[TARGET_Y, i] * fy)
        seen = facing >= math.sqrt(fx * fx + fy * fy) * settings.view_cosine
        weight = 1.0 if seen else settings.unseen_weight
        forces[0, i] += weight * fx
        forces[1, i] += weight * fy


@kernel
def helbing_molnar_pairs(
    filled: int, strength: float, fall_off: float, x: FloatArray, y: FloatArray, sx: FloatArray, sy: FloatArray
) -> None:
    """Replace the places x, y (m) of i as seen from j by −∇V (m/s²), given the strides s e of j (m)."""
    for n in range(filled):
        near = math.sqrt(x[n] * x[n] + y[n] * y[n])
        qx, qy = x[n] - sx[n], y[n] - sy[n]
        far = math.sqrt(qx * qx + qy * qy)
        both = near + far
        squared = both * both - (sx[n] * sx[n] + sy[n] * sy[n])
        b = 0.5 * math.sqrt(squared if squared > 0.0 else 0.0)
        b = b if b > SOFTEST else SOFTEST
        near, far = near if near > TINY else TINY, far if far > TINY else TINY
        slope = 0.25 * strength / fall_off * exp_negative(b * (-1.0 / fall_off)) * both / (b * near * far)
        x[n] = slope * (x[n] * far + qx * near)
        y[n] = slope * (y[n] * far + qy * near)
