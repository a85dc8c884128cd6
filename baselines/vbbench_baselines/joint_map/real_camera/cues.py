"""What one box tells of the frame, the person and the place: three cues, and their slopes.

With the person's place at (R, F) = R(θ)ᵀ(x − c) before the camera, r = √(R² + F²), a = atan2(R, F), the residuals of a
box of the azimuth α, foot slope b and length λ (`bearings`), each in units of its own noise σ, are

    q_u = (α − a − β)/(ω σ_u),
    q_l = (ln λ + ln(r − δ) − η)/σ_l,
    q_b = (b − p cos a − ϱ sin a − h/(r − δ))/(λ σ_b).

Of the frame: p and ϱ its pitch and roll beyond the calibration, h the camera's height over the ground that people stand
on, β an offset of the columns. Of the person: η the logarithm of its height, and δ by how much the body's edge that a
box ends at is nearer than its middle. ω is the angle of a box height along the row: noise grows with the box, and a
little more where the box is small, σ² + (`PIXEL`/size)².

Consecutive errors of one person's boxes are alike, with the correlation ρ = e^(−Δ/τ) after Δ seconds: what counts is
what a box adds, e = (q − ρ q')/√(1 − ρ²), a Student-t variable.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.bearings import FEET_CUT, HEAD_CUT, SIDE_CUT, Bearings
from vbbench_baselines.common.ego_motion import wrapped
from vbbench_baselines.joint_map.motion.walks import REACH

CUES = 3
"""Column, length, foot."""

LENGTH = 1
"""The cue that is ln(r − δ), but for what does not depend on the place."""

FRAME = 7
"""Numbers of a frame: x, y, yaw, pitch, roll, height, column offset."""

PITCH, ROLL, HEIGHT, OFFSET = 3, 4, 5, 6
"""Their places."""

PERSON = 2
"""Numbers of a person: η and δ."""

USUAL = 2
"""Frames to either side over which a box's length is averaged for the noise of its foot."""

PIXEL = 0.5
"""In px; noise of an edge beside what grows with the box."""

CUT_LENGTH = 0.03
"""σ_l of a box that is cut, at least."""

CUT_SIDE = 4.0
"""How many times as uncertain the column of a box is that the picture's side cuts."""

NEAREST_EDGE = 0.2
"""In m: no body is nearer."""

HIDDEN, SHORTER = 0.4, 0.5
"""σ_l of a cut box that is shorter than the person, and its weight: a quarter of the person shows, or more."""


class Noise(NamedTuple):
    """Of the three cues: σ, τ in s, and the degrees of freedom, each [3]."""

    sigma: FloatArray
    tau: FloatArray
    nu: FloatArray


class Residuals(NamedTuple):
    """Of one person's m boxes, and how they move with what they depend on.

    Attributes
    ----------
    frame : [m] in frames since the person's first.
    value : [m, 3] q.
    counts : [m, 3] 1, or less for what does not count in full.
    scale : [m, 3] σ with the noise of an edge: what one unit of q is, as a share of the box.
    by_place, by_frame, by_person : [m, 3, 2], [m, 3, 7] and [m, 3, 2].
    """

    frame: IntArray
    value: FloatArray
    counts: FloatArray
    scale: FloatArray
    by_place: FloatArray
    by_frame: FloatArray
    by_person: FloatArray


@kernel
def residuals_of(
    k: int, first: int, seen: Bearings, frames: FloatArray, track: FloatArray, person: FloatArray, noise: Noise
) -> Residuals:
    """Of the boxes of person ``k`` along its ``track`` [n, 2] from the frame ``first`` on; ``frames`` [T, 7]."""
    n, m = len(track), 0
    at, value, counts, scale = np.empty(n, np.int64), np.empty((n, CUES)), np.ones((n, CUES)), np.empty((n, CUES))
    by_place, by_frame = np.empty((n, CUES, 2)), np.zeros((n, CUES, FRAME))
    by_person = np.zeros((n, CUES, PERSON))
    for i in range(n):
        t = first + i
        azimuth = seen.azimuth[t, k]
        if np.isnan(azimuth):
            continue
        length, size, cut = seen.length[t, k], seen.size[t, k], seen.cut[t, k]
        edge = (PIXEL / size) ** 2
        sigma_u, sigma_l = np.sqrt(noise.sigma[0] ** 2 + edge), np.sqrt(noise.sigma[1] ** 2 + edge)
        sigma_b = np.sqrt(noise.sigma[2] ** 2 + edge)
        if cut & SIDE_CUT:
            sigma_u *= CUT_SIDE
        sin, cos = np.sin(frames[t, 2]), np.cos(frames[t, 2])
        x, y = track[i, 0] - frames[t, 0], track[i, 1] - frames[t, 1]
        right, forward = sin * x - cos * y, cos * x + sin * y
        reach = max(np.sqrt(right * right + forward * forward), NEAREST_EDGE)
        edge_at, angle = max(reach - person[1], NEAREST_EDGE), np.arctan2(right, forward)
        side, ahead = right / reach, forward / reach
        taller = np.log(length) + np.log(edge_at) - person[0]
        if cut & (FEET_CUT | HEAD_CUT):
            sigma_l = max(sigma_l, CUT_LENGTH) if taller >= 0.0 else HIDDEN
            counts[m, 1] = 1.0 if taller >= 0.0 else SHORTER
        pitch, roll, height = frames[t, PITCH], frames[t, ROLL], frames[t, HEIGHT]
        scale[m, 0], scale[m, 1], scale[m, 2] = sigma_u, sigma_l, sigma_b
        by_angle, by_length, by_slope = (
            -1.0 / (seen.width[t, k] * sigma_u),
            1.0 / (edge_at * sigma_l),
            1.0 / (_usual(seen.length, t, k) * sigma_b),
        )
        value[m, 0] = -by_angle * wrapped(azimuth - angle - frames[t, OFFSET])
        value[m, 1] = taller / sigma_l
        value[m, 2] = by_slope * (seen.foot[t, k] - pitch * ahead - roll * side - height / edge_at)
        by_foot, lean = by_slope * height / (edge_at * edge_at), by_slope * (pitch * side - roll * ahead)
        turn_right, turn_forward = ahead / reach, -side / reach
        for j in range(CUES):
            if j == 0:
                by_right, by_forward = by_angle * turn_right, by_angle * turn_forward
            elif j == 1:
                by_right, by_forward = by_length * side, by_length * ahead
            else:
                by_right, by_forward = by_foot * side + lean * turn_right, by_foot * ahead + lean * turn_forward
            by_x, by_y = by_right * sin + by_forward * cos, by_forward * sin - by_right * cos
            by_place[m, j, 0], by_place[m, j, 1] = by_x, by_y
            by_frame[m, j, 0], by_frame[m, j, 1] = -by_x, -by_y
            by_frame[m, j, 2] = by_right * forward - by_forward * right
        by_frame[m, 0, OFFSET] = by_angle
        by_frame[m, 2, PITCH], by_frame[m, 2, ROLL] = -by_slope * ahead, -by_slope * side
        by_frame[m, 2, HEIGHT] = -by_slope / edge_at
        by_person[m, 1, 0], by_person[m, 1, 1], by_person[m, 2, 1] = -1.0 / sigma_l, -by_length, -by_foot
        if cut & FEET_CUT:
            counts[m, 2] = 0.0
        at[m] = i
        m += 1
    return Residuals(at[:m], value[:m], counts[:m], scale[:m], by_place[:m], by_frame[:m], by_person[:m])


@kernel
def _usual(length: FloatArray, t: int, k: int) -> float:
    """The mean ``length`` [T, K] of the boxes of person ``k`` in the frames about ``t``.

    Noise of the foot grows with the box. Held against the box's own length, a foot that is too low would count less,
    for it makes the box longer, and people would stand too far away: the more so, the more alike noise is taken to be
    from frame to frame, since differences then count so much. A mean with the boxes beside it has nothing of this.
    """
    total, count = 0.0, 0
    for at in range(max(t - USUAL, 0), min(t + USUAL + 1, len(length))):
        if not np.isnan(length[at, k]):
            total += length[at, k]
            count += 1
    return total / count


class Whitened(NamedTuple):
    """The energy ½qᵀΩq that touches that of the Student-t terms, Ω a tridiagonal matrix for each cue.

    Attributes
    ----------
    diagonal, beside : [m, 3] Ω of a box, and of a box and the one before it.
    force : [m, 3] Ωq.
    deviance : of the Student-t terms.
    """

    diagonal: FloatArray
    beside: FloatArray
    force: FloatArray
    deviance: float


@kernel
def whiten(found: Residuals, noise: Noise, dt: float) -> Whitened:
    """What the residuals add to those before them; boxes `REACH` frames apart or more know nothing of each other."""
    m, total = len(found.frame), 0.0
    diagonal, beside, force = np.zeros((m, CUES)), np.zeros((m, CUES)), np.zeros((m, CUES))
    for j in range(CUES):
        nu = noise.nu[j]
        for i in range(m):
            count = found.counts[i, j]
            if count == 0.0:
                continue
            rho, before = 0.0, 0.0
            if i > 0 and count == 1.0 and found.counts[i - 1, j] == 1.0:
                apart = found.frame[i] - found.frame[i - 1]
                if apart < REACH:
                    rho, before = np.exp(-apart * dt / noise.tau[j]), found.value[i - 1, j]
            variance, added = 1.0 - rho * rho, found.value[i, j] - rho * before
            weight = count * (nu + 1.0) / (nu * variance + added * added)
            total += 0.5 * count * (nu + 1.0) * np.log(1.0 + added * added / (nu * variance))
            diagonal[i, j] += weight
            force[i, j] += weight * added
            if rho > 0.0:
                diagonal[i - 1, j] += weight * rho * rho
                force[i - 1, j] -= weight * rho * added
                beside[i, j] = -weight * rho
    return Whitened(diagonal, beside, force, total)
