"""One person of the joint problem, eliminated exactly.

Poses (c_t, θ_t) fixed, a person's track x, in the world, has the energy

    ½ Σ_t (x_t − y_t)ᵀ M_t (x_t − y_t) + ½ (Dx)ᵀ W (Dx) + ½ Σ_t ‖x_t − g_t‖²/ε²  + ½ (s − μ)²/σ_s²,

y_t = c_t + R_t z_t the measured places, M_t = R_t N_t⁻¹ R_tᵀ, g_t the given places (ε = 1 mm) and s the stature, by
which z_t = s ρ_t scales. It is least at A x = M y + g/ε², A = DᵀWD + M + E, a banded matrix (half-bandwidth 8, see
`vbbench_baselines.joint_map.banded`). With x eliminated the energy of the y has the gradient M(y − x) and the Hessian

    H_yy = M − M A⁻¹ M,

and the stature, y_t = … + s u_t with u_t = R_t ρ_t, goes in the same way, by one more Schur complement (rank one).
"""

from typing import NamedTuple

import numpy as np

from vbbench.arrays import BoolArray, FloatArray, IntArray
from vbbench_baselines.compiled import kernel
from vbbench_baselines.joint_map.banded import factor, solve
from vbbench_baselines.joint_map.walks import REACH, Walk, add_walk, walk_energy
from vbbench_baselines.motion import ANCHOR_STD

WIDTH = 2 * REACH + 1
"""Columns of a banded A: a frame's two coordinates and those four frames back."""


class Scene(NamedTuple):
    """What is known of T frames and K people, as the kernels take it; NaN = absent.

    Attributes
    ----------
    relative : [T, K, 2] z in m for the statures' means.
    information : [T, K, 3] N⁻¹ as (rr, rf, ff) in 1/m².
    given : [T, K, 2] positions in m.
    first, last : [K] the frames between which a person is followed; last < first for nobody.
    stature, stature_variance : [K] μ in m and σ_s² in m².
    """

    relative: FloatArray
    information: FloatArray
    given: FloatArray
    first: IntArray
    last: IntArray
    stature: FloatArray
    stature_variance: FloatArray


class Person(NamedTuple):
    """One person with its track eliminated; n frames from its first.

    Attributes
    ----------
    track, measured : [n, 2] x and y in m.
    seen : [n] whether there is a box.
    information : [n, 3] M as (xx, xy, yy) in 1/m², nought where there is no box.
    lower : [2n, 9] Cholesky factor of A.
    along : [2n] u, nought where there is no box.
    response : [2n] H_yy u.
    height : s in m.
    height_information : its own, with x eliminated, in 1/m².
    energy : the least energy.
    """

    track: FloatArray
    measured: FloatArray
    seen: BoolArray
    information: FloatArray
    lower: FloatArray
    along: FloatArray
    response: FloatArray
    height: float
    height_information: float
    energy: float


@kernel
def eliminate(k: int, poses: FloatArray, scene: Scene, weights: FloatArray, walk: Walk) -> Person:
    """Person ``k`` at its least energy, given poses [T, 3] and the weights [T] of its innovations from its first on."""
    first, n = int(scene.first[k]), int(scene.last[k] - scene.first[k]) + 1
    measured, information, seen, along = _measured(k, first, n, poses, scene)
    lower, right = np.zeros((2 * n, WIDTH)), np.zeros(2 * n)
    _fill(weights[:n], walk, lower)
    anchor = 1.0 / ANCHOR_STD**2
    for i in range(n):
        xx, xy, yy = information[i]
        x, y = measured[i]
        right[2 * i], right[2 * i + 1] = xx * x + xy * y, xy * x + yy * y
        lower[2 * i, 0] += xx
        lower[2 * i + 1, 0] += yy
        lower[2 * i + 1, 1] += xy
        gx, gy = scene.given[first + i, k]
        if not np.isnan(gx):
            lower[2 * i, 0] += anchor
            lower[2 * i + 1, 0] += anchor
            right[2 * i] += anchor * gx
            right[2 * i + 1] += anchor * gy
    factor(lower)
    solve(lower, right)
    track = right.reshape((n, 2))
    height, height_information = scene.stature[k], np.inf
    response = np.zeros(2 * n)
    if scene.stature_variance[k] > 0.0:
        response, height_information, move = _raise(measured, information, lower, track, along, scene, k)
        height += move
    energy = walk_energy(track, weights, walk) + _misfit(k, first, track, measured, information, scene)
    if scene.stature_variance[k] > 0.0:
        energy += 0.5 * (height - scene.stature[k]) ** 2 / scene.stature_variance[k]
    return Person(track, measured, seen, information, lower, along, response, height, height_information, energy)


@kernel
def _measured(
    k: int, first: int, n: int, poses: FloatArray, scene: Scene
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """The y [n, 2], M [n, 3], whether there is a box [n], and u [2n]."""
    measured, information = np.zeros((n, 2)), np.zeros((n, 3))
    seen, along = np.zeros(n, np.bool_), np.zeros(2 * n)
    for i in range(n):
        right, forward = scene.relative[first + i, k]
        if np.isnan(right):
            continue
        seen[i] = True
        x, y, yaw = poses[first + i]
        sin, cos = np.sin(yaw), np.cos(yaw)
        wx, wy = right * sin + forward * cos, forward * sin - right * cos
        measured[i, 0], measured[i, 1] = x + wx, y + wy
        along[2 * i], along[2 * i + 1] = wx / scene.stature[k], wy / scene.stature[k]
        rr, rf, ff = scene.information[first + i, k]
        information[i, 0] = sin * sin * rr + 2.0 * sin * cos * rf + cos * cos * ff
        information[i, 1] = sin * cos * (ff - rr) + (sin * sin - cos * cos) * rf
        information[i, 2] = cos * cos * rr - 2.0 * sin * cos * rf + sin * sin * ff
    return measured, information, seen, along


@kernel
def _fill(weights: FloatArray, walk: Walk, lower: FloatArray) -> None:
    """Write DᵀWD, the same for both coordinates, to ``lower`` [2n, 9]."""
    n = len(weights)
    band = np.zeros((n, REACH + 1))
    add_walk(weights, walk, band)
    for i in range(n):
        for d in range(min(i, REACH) + 1):
            lower[2 * i, 2 * d] = lower[2 * i + 1, 2 * d] = band[i, d]


@kernel
def _raise(
    measured: FloatArray,
    information: FloatArray,
    lower: FloatArray,
    track: FloatArray,
    along: FloatArray,
    scene: Scene,
    k: int,
) -> tuple[FloatArray, float, float]:
    """H_yy u, the height's information, and by how much the height moves; y and x are moved with it."""
    n = len(track)
    response = np.empty(2 * n)
    slope = 0.0
    for i in range(n):
        xx, xy, yy = information[i]
        ux, uy = along[2 * i], along[2 * i + 1]
        mx, my = xx * ux + xy * uy, xy * ux + yy * uy
        response[2 * i], response[2 * i + 1] = mx, my
        slope += mx * (measured[i, 0] - track[i, 0]) + my * (measured[i, 1] - track[i, 1])
    moved = response.copy()
    solve(lower, moved)
    total = 1.0 / scene.stature_variance[k]
    for i in range(n):
        xx, xy, yy = information[i]
        ax, ay = moved[2 * i], moved[2 * i + 1]
        response[2 * i] -= xx * ax + xy * ay
        response[2 * i + 1] -= xy * ax + yy * ay
        total += response[2 * i] * along[2 * i] + response[2 * i + 1] * along[2 * i + 1]
    move = -slope / total
    for i in range(n):
        for a in range(2):
            measured[i, a] += move * along[2 * i + a]
            track[i, a] += move * moved[2 * i + a]
    return response, total, move


@kernel
def _misfit(
    k: int, first: int, track: FloatArray, measured: FloatArray, information: FloatArray, scene: Scene
) -> float:
    """½ Σ of the squared errors of boxes and given places."""
    total = 0.0
    for i in range(len(track)):
        x, y = track[i, 0] - measured[i, 0], track[i, 1] - measured[i, 1]
        xx, xy, yy = information[i]
        total += xx * x * x + 2.0 * xy * x * y + yy * y * y
        gx, gy = scene.given[first + i, k]
        if not np.isnan(gx):
            total += ((track[i, 0] - gx) ** 2 + (track[i, 1] - gy) ** 2) / ANCHOR_STD**2
    return 0.5 * total
