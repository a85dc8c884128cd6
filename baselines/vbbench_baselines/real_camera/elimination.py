"""One person of the joint problem, eliminated: what is left are the frames.

At a point, the energy of a person with the track x, the numbers p = (η, δ) and the frames f is, to second order,

    ½‖q + Q_x dx + Q_p dp + Q_f df‖²_Ω + ½(x + dx)ᵀDᵀWD(x + dx) + what is given of x and expected of p,

with the residuals q of the boxes (`real_camera.cues`) and the walk's DᵀWD (`joint_map.motion.walks`). A = DᵀWD +
Q_xᵀΩQ_x + E is banded, A = LLᵀ. With Z = L⁻¹Q_xᵀΩ and y = L⁻¹g_x, dx eliminated leaves

    Ψ = Ω − ZᵀZ,   force φ = Ωq − Zᵀy,

to which dp and df are linear; with U = ΨQ_p, I_p = Q_pᵀU + P_p and g_p = Q_pᵀφ + P_p(p − p̄), dp eliminated leaves

    Ψ' = Ψ − U I_p⁻¹Uᵀ,   φ' = φ − U I_p⁻¹g_p:   gradient Q_fᵀφ', Hessian Q_fᵀΨ'Q_f.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, add_walk
from vbbench_baselines.joint_map.optimiser.banded import BAND, factor
from vbbench_baselines.real_camera.cues import CUES, FRAME, PERSON, Residuals, Whitened

SOMEWHERE = 1e-4
"""In 1/m²: keeps a place of which nothing is known."""


class PeoplePrior(NamedTuple):
    """Means and standard deviations [2] of η and δ."""

    mean: FloatArray
    std: FloatArray


class Person(NamedTuple):
    """A person with its track eliminated, over n frames and m boxes.

    Attributes
    ----------
    number, first : k, and the frame it begins with.
    found : the residuals.
    lower, spread, pull : L (see `joint_map.optimiser.banded`), Z [2n, 3m] and y [2n].
    inner, slope : I_p⁻¹ [2, 2] and g_p [2].
    across : U [3m, 2].
    information, force : Ψ' [3m, 3m] and φ' [3m].
    """

    number: int
    first: int
    found: Residuals
    lower: FloatArray
    spread: FloatArray
    pull: FloatArray
    inner: FloatArray
    slope: FloatArray
    across: FloatArray
    information: FloatArray
    force: FloatArray


@kernel
def eliminate(
    number: int,
    first: int,
    track: FloatArray,
    given: FloatArray,
    person: FloatArray,
    found: Residuals,
    white: Whitened,
    weights: FloatArray,
    walk: Walk,
    prior: PeoplePrior,
    damping: float,
) -> Person:
    """The person with the ``track`` and what is ``given`` of it [n, 2], and the walk's ``weights`` [n]."""
    n, m = len(track), len(found.frame)
    lower, pull = _track_terms(track, given, found, white, weights, walk)
    for i in range(2 * n):
        lower[i, 0] = lower[i, 0] * (1.0 + damping) + SOMEWHERE
    factor(lower)
    spread = _spread(found, white, lower, n)
    for row in range(2 * n):
        pull[row] *= lower[row, 0]
        for e in range(1, min(BAND, 2 * n - 1 - row) + 1):
            pull[row + e] -= lower[row, e] * pull[row]
    across_time = np.ascontiguousarray(spread.T)
    information = -(across_time @ spread)
    force = -(across_time @ pull)
    for i in range(m):
        for j in range(CUES):
            p = CUES * i + j
            information[p, p] += white.diagonal[i, j]
            force[p] += white.force[i, j]
            if i > 0:
                information[p, p - CUES] += white.beside[i, j]
                information[p - CUES, p] += white.beside[i, j]
    by_person = found.by_person.copy().reshape((CUES * m, PERSON))
    across = information @ by_person
    inner, slope = by_person.T @ across, by_person.T @ force
    for a in range(PERSON):
        inner[a, a] += 1.0 / prior.std[a] ** 2
        slope[a] += (person[a] - prior.mean[a]) / prior.std[a] ** 2
    inner = np.ascontiguousarray(np.linalg.inv(inner))
    gain = across @ inner
    information -= gain @ np.ascontiguousarray(across.T)
    force -= gain @ slope
    return Person(number, first, found, lower, spread, pull, inner, slope, across, information, force)


@kernel
def _track_terms(
    track: FloatArray, given: FloatArray, found: Residuals, white: Whitened, weights: FloatArray, walk: Walk
) -> tuple[FloatArray, FloatArray]:
    """A, as a band, and g_x [2n]."""
    n = len(track)
    lower, pull = np.zeros((2 * n + BAND, 2 * BAND + 1)), np.zeros(2 * n)
    band = np.zeros((n, REACH + 1))
    add_walk(weights, walk, band)
    anchor = 1.0 / ANCHOR_STD**2
    for i in range(n):
        for e in range(min(i, REACH) + 1):
            for a in range(2):
                lower[2 * (i - e) + a, 2 * e] = band[i, e]
                pull[2 * i + a] += band[i, e] * track[i - e, a]
                if e > 0:
                    pull[2 * (i - e) + a] += band[i, e] * track[i, a]
        if not np.isnan(given[i, 0]):
            for a in range(2):
                lower[2 * i + a, 0] += anchor
                pull[2 * i + a] += anchor * (track[i, a] - given[i, a])
    for i in range(len(found.frame)):
        r = 2 * found.frame[i]
        for j in range(CUES):
            x, y = found.by_place[i, j]
            lower[r, 0] += white.diagonal[i, j] * x * x
            lower[r, 1] += white.diagonal[i, j] * x * y
            lower[r + 1, 0] += white.diagonal[i, j] * y * y
            pull[r] += x * white.force[i, j]
            pull[r + 1] += y * white.force[i, j]
            link = white.beside[i, j]
            if link != 0.0:
                p = 2 * found.frame[i - 1]
                other_x, other_y = found.by_place[i - 1, j]
                lower[p, r - p] += link * x * other_x
                lower[p, r + 1 - p] += link * y * other_x
                lower[p + 1, r - p - 1] += link * x * other_y
                lower[p + 1, r - p] += link * y * other_y
    return lower, pull


@kernel
def _spread(found: Residuals, white: Whitened, lower: FloatArray, n: int) -> FloatArray:
    """Z [2n, 3m]; a column begins with the frame of the box before."""
    m = len(found.frame)
    spread, filled = np.zeros((2 * n + BAND, CUES * m)), np.zeros(2 * n, np.int64)
    for i in range(m):
        begins = found.frame[i]
        for j in range(CUES):
            column = spread[:, CUES * i + j]
            _put(column, found, i, j, white.diagonal[i, j])
            if white.beside[i, j] != 0.0:
                begins = found.frame[i - 1]
                _put(column, found, i - 1, j, white.beside[i, j])
            if i + 1 < m:
                _put(column, found, i + 1, j, white.beside[i + 1, j])
        filled[2 * begins :] = CUES * (i + 1)
    for row in range(2 * n):
        here, columns = spread[row], filled[row]
        for c in range(columns):
            here[c] *= lower[row, 0]
        for e in range(1, BAND + 1):
            share, other = lower[row, e], spread[row + e]
            if share != 0.0:
                for c in range(columns):
                    other[c] -= share * here[c]
    return spread[: 2 * n]


@kernel
def _put(column: FloatArray, found: Residuals, i: int, j: int, share: float) -> None:
    """Write a share of a box's slopes by its place to where it is in a ``column`` [2n] of Z."""
    at = 2 * found.frame[i]
    column[at], column[at + 1] = share * found.by_place[i, j, 0], share * found.by_place[i, j, 1]


@kernel
def add_person(person: Person, gradient: FloatArray, hessian: FloatArray) -> None:
    """Add Q_fᵀφ' to the gradient [7T], and Q_fᵀΨ'Q_f to the lower half of the Hessian [7T, 7T]."""
    found, share = person.found, np.empty((FRAME, CUES))
    for i in range(len(found.frame)):
        p, by_frame = FRAME * (person.first + found.frame[i]), found.by_frame[i]
        for a in range(FRAME):
            for j in range(CUES):
                gradient[p + a] += by_frame[j, a] * person.force[CUES * i + j]
        for h in range(i + 1):
            q, other = FRAME * (person.first + found.frame[h]), found.by_frame[h]
            block = person.information[CUES * i : CUES * i + CUES, CUES * h : CUES * h + CUES]
            for a in range(FRAME):
                u, v, w = by_frame[0, a], by_frame[1, a], by_frame[2, a]
                for j in range(CUES):
                    share[a, j] = u * block[0, j] + v * block[1, j] + w * block[2, j]
            for a in range(FRAME):
                u, v, w = share[a, 0], share[a, 1], share[a, 2]
                row = hessian[p + a]
                for b in range(FRAME):
                    row[q + b] += u * other[0, b] + v * other[1, b] + w * other[2, b]


@kernel
def follow(person: Person, step: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How track [n, 2] and numbers [2] move when the frames move by ``step`` [T, 7]."""
    found, n = person.found, person.spread.shape[0] // 2
    m = len(found.frame)
    move = np.zeros(CUES * m)
    for i in range(m):
        for j in range(CUES):
            for a in range(FRAME):
                move[CUES * i + j] += found.by_frame[i, j, a] * step[person.first + found.frame[i], a]
    numbers = -(person.inner @ (person.slope + move @ person.across))
    for i in range(m):
        for j in range(CUES):
            for a in range(PERSON):
                move[CUES * i + j] += found.by_person[i, j, a] * numbers[a]
    track = -(person.pull + person.spread @ move)
    for row in range(2 * n - 1, -1, -1):
        total = track[row]
        for e in range(1, min(BAND, 2 * n - 1 - row) + 1):
            total -= person.lower[row, e] * track[row + e]
        track[row] = total * person.lower[row, 0]
    return track.reshape((n, 2)), numbers


@kernel
def place_covariance(person: Person, frame: int, covariance: FloatArray) -> FloatArray:
    """[2, 2] of the person's place in a frame of its track; ``covariance`` [7T, 7T] of the frames."""
    found, n = person.found, person.spread.shape[0] // 2
    m = len(found.frame)
    back = np.zeros((2, 2 * n))  # L⁻¹ of the place's unit vectors
    for a in range(2):
        row = back[a]
        row[2 * frame + a] = 1.0
        for i in range(2 * frame, 2 * n):
            row[i] *= person.lower[i, 0]
            for e in range(1, min(BAND, 2 * n - 1 - i) + 1):
                row[i + e] -= person.lower[i, e] * row[i]
    by_residual = -(back @ person.spread)  # [2, 3m]: of the place by the residuals
    by_numbers = by_residual @ found.by_person.copy().reshape((CUES * m, PERSON))
    by_residual = by_residual - (by_numbers @ person.inner) @ np.ascontiguousarray(person.across.T)
    by_frames = np.zeros((2, FRAME * m))
    columns = np.empty(FRAME * m, np.int64)
    for i in range(m):
        for a in range(FRAME):
            columns[FRAME * i + a] = FRAME * (person.first + found.frame[i]) + a
            for j in range(CUES):
                for b in range(2):
                    by_frames[b, FRAME * i + a] += by_residual[b, CUES * i + j] * found.by_frame[i, j, a]
    own = np.empty((FRAME * m, FRAME * m))
    for i in range(FRAME * m):
        for j in range(FRAME * m):
            own[i, j] = covariance[columns[i], columns[j]]
    alone = back @ np.ascontiguousarray(back.T)
    of_numbers = by_numbers @ person.inner @ np.ascontiguousarray(by_numbers.T)
    total: FloatArray = alone + of_numbers + by_frames @ own @ np.ascontiguousarray(by_frames.T)
    return total
