"""One person of the joint problem, eliminated exactly.

Poses (c_t, θ_t) fixed, a person's track x, in the world, has the energy

    ½ Σ_t (x_t − y_t)ᵀ M_t (x_t − y_t) + ½ (Dx)ᵀ W (Dx) + ½ Σ_t ‖x_t − g_t‖²/ε²  + ½ (s − μ)²/σ_s²,

y_t = c_t + R_t z_t the measured places, M_t = R_t N_t⁻¹ R_tᵀ, g_t the given places (ε = 1 mm) and s the stature, by
which z_t = s ρ_t scales. It is least at A x = M y + g/ε², A = DᵀWD + M + E, a banded matrix (half-bandwidth 8, see
`optimiser.banded`). With x eliminated the energy of the y has the gradient M(y − x) and the Hessian

    H_yy = M − M A⁻¹ M,

and the stature, y_t = … + s u_t with u_t = R_t ρ_t, goes in the same way, by one more Schur complement (rank one).
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.joint_map.measurement.window import Measurements
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, add_walk
from vbbench_baselines.joint_map.optimiser.banded import BAND, factor, solve


class Person(NamedTuple):
    """One person with its track eliminated; n frames from its first.

    Attributes
    ----------
    number, first : k and the frame it begins with.
    track, measured : [n, 2] x and y in m.
    seen : [n] whether there is a box.
    information : [n, 3] M as (xx, xy, yy) in 1/m², zero where there is no box.
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
    seen: BoolArray
    information: FloatArray
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
    band = np.zeros((n, REACH + 1))
    add_walk(weights[:n], walk, band)
    for i in range(n):  # DᵀWD, the same for both coordinates
        for d in range(min(i, REACH) + 1):
            lower[2 * (i - d), 2 * d] = lower[2 * (i - d) + 1, 2 * d] = band[i, d]
    anchor = 1.0 / ANCHOR_STD**2
    for i in range(n):
        xx, xy, yy = information[i]
        x, y = measured[i]
        right[2 * i], right[2 * i + 1] = xx * x + xy * y, xy * x + yy * y
        lower[2 * i, 0] += xx
        lower[2 * i + 1, 0] += yy
        lower[2 * i, 1] += xy
        gx, gy = data.given[first + i, k]
        if not np.isnan(gx):
            lower[2 * i, 0] += anchor
            lower[2 * i + 1, 0] += anchor
            right[2 * i] += anchor * gx
            right[2 * i + 1] += anchor * gy
    factor(lower)
    solve(lower, right)
    track = right.reshape((n, 2))
    height, height_information = data.stature[k], np.inf
    response = np.zeros(2 * n)
    if data.stature_variance[k] > 0.0:
        response, height_information, move = _raise(measured, information, lower, track, along, data, k)
        height += move
    return Person(k, first, track, measured, seen, information, lower, along, response, height, height_information)


@kernel
def follow(person: Person, poses: FloatArray, step: FloatArray) -> tuple[FloatArray, float]:
    """The track [n, 2] and height after a ``step`` [T, 3] of the ``poses`` [T, 3], to first order."""
    n, first = len(person.track), person.first
    move, height = np.empty(2 * n), person.height
    arms = arms_of(person, poses)
    for i in range(n):
        x, y, yaw = step[first + i]
        move[2 * i], move[2 * i + 1] = x + yaw * arms[i, 0], y + yaw * arms[i, 1]
    if not np.isinf(person.height_information):
        lean = float(-(person.response @ move) / person.height_information)
        move += lean * person.along
        height += lean
    move = weighed(person.information, move)
    solve(person.lower, move)
    return person.track + move.reshape((n, 2)), height


@kernel
def _measured(
    k: int, first: int, n: int, poses: FloatArray, axes: FloatArray, data: Measurements
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """The y [n, 2], M [n, 3], whether there is a box [n], and u [2n]."""
    measured, information = np.zeros((n, 2)), np.zeros((n, 3))
    seen, along = np.zeros(n, np.bool_), np.zeros(2 * n)
    for i in range(n):
        right, forward = data.relative[first + i, k]
        if np.isnan(right):
            continue
        seen[i] = True
        x, y, _ = poses[first + i]
        sin, cos = axes[first + i]
        wx, wy = right * sin + forward * cos, forward * sin - right * cos
        measured[i, 0], measured[i, 1] = x + wx, y + wy
        along[2 * i], along[2 * i + 1] = wx / data.stature[k], wy / data.stature[k]
        rr, rf, ff = data.information[first + i, k]
        information[i, 0] = sin * sin * rr + 2.0 * sin * cos * rf + cos * cos * ff
        information[i, 1] = sin * cos * (ff - rr) + (sin * sin - cos * cos) * rf
        information[i, 2] = cos * cos * rr - 2.0 * sin * cos * rf + sin * sin * ff
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
    first = int(data.first[k])
    measured, information, _, along = _measured(k, first, len(track), poses, axes, data)
    move, total = height - data.stature[k], 0.0
    for i in range(len(track)):
        x = track[i, 0] - (measured[i, 0] + move * along[2 * i])
        y = track[i, 1] - (measured[i, 1] + move * along[2 * i + 1])
        xx, xy, yy = information[i]
        total += xx * x * x + 2.0 * xy * x * y + yy * y * y
        gx, gy = data.given[first + i, k]
        if not np.isnan(gx):
            total += ((track[i, 0] - gx) ** 2 + (track[i, 1] - gy) ** 2) / ANCHOR_STD**2
    stature = 0.5 * move * move / data.stature_variance[k] if data.stature_variance[k] > 0.0 else 0.0
    return stature + 0.5 * total


@kernel
def weighed(information: FloatArray, values: FloatArray) -> FloatArray:
    """M v for ``values`` v [2n]."""
    product = np.empty_like(values)
    for i in range(len(information)):
        xx, xy, yy = information[i]
        x, y = values[2 * i], values[2 * i + 1]
        product[2 * i], product[2 * i + 1] = xx * x + xy * y, xy * x + yy * y
    return product


@kernel
def arms_of(person: Person, poses: FloatArray) -> FloatArray:
    """J(x_t − c_t) [n, 2] in m: how a turn of the camera moves the person's track."""
    arms, first = np.empty((len(person.track), 2)), person.first
    for i in range(len(arms)):
        arms[i, 0], arms[i, 1] = poses[first + i, 1] - person.track[i, 1], person.track[i, 0] - poses[first + i, 0]
    return arms


@kernel
def to_poses(forces: FloatArray, arms: FloatArray) -> FloatArray:
    """Gᵀ v [3n] of ``forces`` v [2n] on the measured places; ``arms`` as of `arms_of`."""
    pulls = np.empty(3 * len(arms))
    for i in range(len(arms)):
        x, y = forces[2 * i], forces[2 * i + 1]
        pulls[3 * i], pulls[3 * i + 1], pulls[3 * i + 2] = x, y, x * arms[i, 0] + y * arms[i, 1]
    return pulls
