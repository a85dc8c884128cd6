"""One person of the joint problem, eliminated exactly.

Poses (c_t, θ_t) fixed, a person's track x, in the world, has the energy

    ½ Σ_t (x_t − y_t)ᵀ M_t (x_t − y_t) + ½ (Dx)ᵀ W (Dx) + ½ Σ_t ‖x_t − g_t‖²/ε²  + ½ (s − μ)²/σ_s²,

y_t = c_t + R_t z_t the measured places, M_t = R_t N_t⁻¹ R_tᵀ, g_t the given places (ε = 1 mm) and s the stature, by
which z_t = s ρ_t scales; of a walk that began before, frames that are gone tell ½ dᵀQd + qᵀd besides, d the distance of
its first places from x̄ (`measurement.window.Continued`). It is least at A x = M y + g/ε² + Qx̄ − q, with the banded
matrix A = DᵀWD + M + E + Q (half-bandwidth 8, see `optimiser.banded`). With x eliminated the energy of the y has the
gradient M(y − x) and the Hessian

    H_yy = M − M A⁻¹ M,

and the stature, y_t = … + s u_t with u_t = R_t ρ_t, goes in the same way, by one more Schur complement (rank one).
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.joint_map.measurement.window import Continued, Measurements
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, add_walk
from vbbench_baselines.joint_map.optimiser.banded import BAND, factor, solve


class Person(NamedTuple):
    """One person with its track eliminated; n frames from its first.

    Attributes
    ----------
    number, first : k and the frame it begins with.
    track, measured : [n, 2] x and y in m.
    arms : [n, 2] J(x_t − c_t) in m: how a turn of the camera moves the track.
    seen : [n] whether there is a box.
    information : [n, 3] M as (xx, xy, yy) in 1/m², zero where there is no box.
    precisions : [n] of innovations in 1/m², zero where they are accounted for elsewhere.
    lower : Cholesky factor of A [2n, 2n], see `vbbench_baselines.joint_map.optimiser.banded`.
    along : [2n] u, zero where there is no box.
    response : [2n] H_yy u.
    height : s in m.
    height_information : its own, with x eliminated, in 1/m².
    """

    number: int
    first: int
    track: FloatArray
    measured: FloatArray
    arms: FloatArray
    seen: BoolArray
    information: FloatArray
    precisions: FloatArray
    lower: FloatArray
    along: FloatArray
    response: FloatArray
    height: float
    height_information: float


@kernel
def axes_of(poses: FloatArray) -> FloatArray:
    """Sine and cosine [T, 2] of the yaws of poses [T, 3]."""
    axes = np.empty((len(poses), 2))
    axes[:, 0], axes[:, 1] = np.sin(poses[:, 2]), np.cos(poses[:, 2])
    return axes


@kernel
def eliminate(
    k: int, poses: FloatArray, axes: FloatArray, data: Measurements, weights: FloatArray, walk: Walk
) -> Person:
    """Person ``k`` at its least energy, given poses [T, 3] and the weights [T] of its innovations from its first on.

    ``axes`` are the poses' `axes_of`.
    """
    first, n = int(data.first[k]), int(data.last[k] - data.first[k]) + 1
    measured, information, seen, along = _measured(k, first, n, poses, axes, data)
    lower, right = np.zeros((2 * n + BAND, 2 * BAND + 1)), np.zeros(2 * n)
    band, held = np.zeros((n, REACH + 1)), data.continued.held[k]
    add_walk(weights[:n], walk, band, held)
    if held > 0:
        _add_continued(k, data.continued, band, right)
    anchor = 1.0 / ANCHOR_STD**2
    for i in range(n):
        gx, gy = data.given[first + i, k, 0], data.given[first + i, k, 1]
        if not np.isnan(gx):
            band[i, 0] += anchor
            right[2 * i] += anchor * gx
            right[2 * i + 1] += anchor * gy
        for d in range(min(i, REACH) + 1):
            lower[2 * (i - d), 2 * d] = lower[2 * (i - d) + 1, 2 * d] = band[i, d]
    for i in range(n):
        xx, xy, yy = information[i, 0], information[i, 1], information[i, 2]
        x, y = measured[i, 0], measured[i, 1]
        right[2 * i] += xx * x + xy * y
        right[2 * i + 1] += xy * x + yy * y
        lower[2 * i, 0] += xx
        lower[2 * i + 1, 0] += yy
        lower[2 * i, 1] += xy
    factor(lower)
    solve(lower, right)
    track = right.reshape((n, 2))
    height, height_information = data.stature[k], np.inf
    response = np.zeros(2 * n)
    if data.stature_variance[k] > 0.0:
        response, height_information, move = _raise(measured, information, lower, track, along, data, k)
        height += move
    arms, precisions = np.empty((n, 2)), np.zeros(n)
    for i in range(max(held, 1), n):
        precisions[i] = (1.0 if i == 1 else weights[i]) / walk.spreads[min(i, REACH)] ** 2
    for i in range(n):
        arms[i, 0], arms[i, 1] = poses[first + i, 1] - track[i, 1], track[i, 0] - poses[first + i, 0]
    own = height_information
    return Person(k, first, track, measured, arms, seen, information, precisions, lower, along, response, height, own)


@kernel
def follow(person: Person, step: FloatArray, turns: FloatArray) -> tuple[FloatArray, float]:
    """The track [n, 2] and height after a ``step`` [T, 3] of the poses.

    What was measured turns with the camera on a circle, ``turns`` [T, 2] being the sines of the steps' turns and the
    cosines less 1: along straight lines, a long path that bends as a whole would seem to stretch.
    """
    n, first = len(person.track), person.first
    move, height = np.empty(2 * n), person.height
    arms = person.arms
    for i in range(n):
        sin, less = turns[first + i, 0], turns[first + i, 1]
        move[2 * i] = step[first + i, 0] + sin * arms[i, 0] + less * arms[i, 1]
        move[2 * i + 1] = step[first + i, 1] + sin * arms[i, 1] - less * arms[i, 0]
    if not np.isinf(person.height_information):
        lean = float(-(person.response @ move) / person.height_information)
        move += lean * person.along
        height += lean
    move = weighed(person.information, move)
    solve(person.lower, move)
    return person.track + move.reshape((n, 2)), height


@kernel
def _add_continued(k: int, continued: Continued, band: FloatArray, right: FloatArray) -> None:
    """Add Q of person ``k`` to ``band`` [n, 5] and Qx̄ − q to ``right`` [2n]."""
    for i in range(continued.held[k]):
        for d in range(i + 1):
            band[i, d] += continued.information[k, i, i - d]
        for a in range(2):
            right[2 * i + a] -= continued.slope[k, i, a]
            for j in range(continued.held[k]):
                right[2 * i + a] += continued.information[k, i, j] * continued.places[k, j, a]


@kernel
def continued_energy(k: int, track: FloatArray, continued: Continued) -> float:
    """½ dᵀQd + qᵀd of person ``k`` at a track [n, 2]."""
    total = 0.0
    for i in range(continued.held[k]):
        for a in range(2):
            pull = continued.slope[k, i, a]
            for j in range(continued.held[k]):
                pull += 0.5 * continued.information[k, i, j] * (track[j, a] - continued.places[k, j, a])
            total += pull * (track[i, a] - continued.places[k, i, a])
    return total


@kernel
def _turned(rr: float, rf: float, ff: float, sin: float, cos: float) -> tuple[float, float, float]:
    """M as (xx, xy, yy) of N⁻¹ as (rr, rf, ff) in a camera whose yaw has this sine and cosine."""
    xx = sin * sin * rr + 2.0 * sin * cos * rf + cos * cos * ff
    xy = sin * cos * (ff - rr) + (sin * sin - cos * cos) * rf
    yy = cos * cos * rr - 2.0 * sin * cos * rf + sin * sin * ff
    return xx, xy, yy


@kernel
def _measured(
    k: int, first: int, n: int, poses: FloatArray, axes: FloatArray, data: Measurements
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """The y [n, 2], M [n, 3], whether there is a box [n], and u [2n]."""
    measured, information = np.zeros((n, 2)), np.zeros((n, 3))
    seen, along = np.zeros(n, np.bool_), np.zeros(2 * n)
    for i in range(n):
        t = first + i
        right, forward = data.relative[t, k, 0], data.relative[t, k, 1]
        if np.isnan(right):
            continue
        rr, rf, ff = data.information[t, k, 0], data.information[t, k, 1], data.information[t, k, 2]
        sin, cos = axes[t, 0], axes[t, 1]
        wx, wy = right * sin + forward * cos, forward * sin - right * cos
        seen[i] = True
        measured[i, 0], measured[i, 1] = poses[t, 0] + wx, poses[t, 1] + wy
        along[2 * i], along[2 * i + 1] = wx / data.stature[k], wy / data.stature[k]
        information[i, 0], information[i, 1], information[i, 2] = _turned(rr, rf, ff, sin, cos)
    return measured, information, seen, along


@kernel
def _raise(
    measured: FloatArray,
    information: FloatArray,
    lower: FloatArray,
    track: FloatArray,
    along: FloatArray,
    data: Measurements,
    k: int,
) -> tuple[FloatArray, float, float]:
    """H_yy u, the height's information, and by how much the height moves; y and x are moved with it."""
    n, slope, response = len(track), 0.0, weighed(information, along)
    for i in range(n):
        mx, my = response[2 * i], response[2 * i + 1]
        slope += mx * (measured[i, 0] - track[i, 0]) + my * (measured[i, 1] - track[i, 1])
    moved = response.copy()
    solve(lower, moved)
    total, back = 1.0 / data.stature_variance[k], weighed(information, moved)
    for i in range(n):
        response[2 * i] -= back[2 * i]
        response[2 * i + 1] -= back[2 * i + 1]
        total += response[2 * i] * along[2 * i] + response[2 * i + 1] * along[2 * i + 1]
    move = -slope / total
    for i in range(n):
        for a in range(2):
            measured[i, a] += move * along[2 * i + a]
            track[i, a] += move * moved[2 * i + a]
    return response, total, move


@kernel
def misfit(k: int, track: FloatArray, poses: FloatArray, axes: FloatArray, height: float, data: Measurements) -> float:
    """½ Σ of person ``k``'s squared errors of boxes, given places and stature, at a track [n, 2] as it is."""
    first, stretch, total = int(data.first[k]), height / data.stature[k], 0.0
    for i in range(len(track)):
        t = first + i
        right, forward = data.relative[t, k, 0], data.relative[t, k, 1]
        if not np.isnan(right):
            rr, rf, ff = data.information[t, k, 0], data.information[t, k, 1], data.information[t, k, 2]
            sin, cos = axes[t, 0], axes[t, 1]
            wx, wy = right * sin + forward * cos, forward * sin - right * cos
            xx, xy, yy = _turned(rr, rf, ff, sin, cos)
            x = track[i, 0] - (poses[t, 0] + stretch * wx)
            y = track[i, 1] - (poses[t, 1] + stretch * wy)
            total += xx * x * x + 2.0 * xy * x * y + yy * y * y
        gx, gy = data.given[t, k, 0], data.given[t, k, 1]
        if not np.isnan(gx):
            total += ((track[i, 0] - gx) ** 2 + (track[i, 1] - gy) ** 2) / ANCHOR_STD**2
    move = height - data.stature[k]
    stature = 0.5 * move * move / data.stature_variance[k] if data.stature_variance[k] > 0.0 else 0.0
    return stature + 0.5 * total


@kernel
def weighed(information: FloatArray, values: FloatArray) -> FloatArray:
    """M v for ``values`` v [2n]."""
    product = np.empty_like(values)
    for i in range(len(information)):
        xx, xy, yy = information[i, 0], information[i, 1], information[i, 2]
        x, y = values[2 * i], values[2 * i + 1]
        product[2 * i], product[2 * i + 1] = xx * x + xy * y, xy * x + yy * y
    return product


@kernel
def to_poses(forces: FloatArray, arms: FloatArray) -> FloatArray:
    """Gᵀ v [3n] of ``forces`` v [2n] on the measured places; ``arms`` as of `Person`."""
    pulls = np.empty(3 * len(arms))
    for i in range(len(arms)):
        x, y = forces[2 * i], forces[2 * i + 1]
        pulls[3 * i], pulls[3 * i + 1], pulls[3 * i + 2] = x, y, x * arms[i, 0] + y * arms[i, 1]
    return pulls
