"""One person of the joint problem, eliminated: what is left are the frames.

At a point, the energy of a person with the track x, the numbers p = (η, δ) and the frames f is, to second order,

    ½‖q + Q_x dx + Q_p dp + Q_f df‖²_Ω + ½(x + dx)ᵀDᵀWD(x + dx) + what is given of x and expected of p,

with the residuals q of the boxes (`cues`) and the walk's DᵀWD (`joint_map.motion.walks`). What frames told that are no
longer there (`past`) adds to the terms of x and of p, and dxᵀC dp. A = DᵀWD + Q_xᵀΩQ_x + E is banded, A = LLᵀ. With
Z = L⁻¹Q_xᵀΩ and y = L⁻¹g_x, dx eliminated leaves

    Ψ = Ω − ZᵀZ,   force φ = Ωq − Zᵀy,

to which dp and df are linear; with U = ΨQ_p − ZᵀL⁻¹C, I_p = Q_pᵀU − CᵀA⁻¹(Q_xᵀΩQ_p + C) + P_p and
g_p = Q_pᵀφ − CᵀA⁻¹g_x + P_p(p − p̄), dp eliminated leaves

    Ψ' = Ψ − U I_p⁻¹Uᵀ,   φ' = φ − U I_p⁻¹g_p:   gradient Q_fᵀφ', Hessian Q_fᵀΨ'Q_f.

With I_p = MMᵀ, the rows of M⁻¹Uᵀ are two more of Z.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.joint_map.motion.pace import add_pace
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, add_walk
from vbbench_baselines.joint_map.optimiser.banded import BAND, factor, forward
from vbbench_baselines.joint_map.real_camera.cholesky import padded
from vbbench_baselines.joint_map.real_camera.cues import (
    CUES,
    FRAME,
    HEIGHT,
    OFFSET,
    PERSON,
    PITCH,
    ROLL,
    Residuals,
    Whitened,
)
from vbbench_baselines.joint_map.real_camera.past import PLACES, Past, pull_of
from vbbench_baselines.joint_map.real_camera.spreading import add_numbers, fill_spread, information_of, sides_of

SOMEWHERE = 1e-4
"""In 1/m²: keeps a place of which nothing is known."""


class PeoplePrior(NamedTuple):
    """Means and standard deviations [2] of η, for people who stand, and δ."""

    mean: FloatArray
    std: FloatArray


class Person(NamedTuple):
    """A person with its track eliminated, over n frames and m boxes.

    Attributes
    ----------
    number, first : k, and the frame it begins with.
    found : the residuals.
    white : Ω and Ωq.
    lower, pull : L (see `joint_map.optimiser.banded`), and y [2n].
    inner, slope : I_p⁻¹ [2, 2] and g_p [2].
    across : Uᵀ [2, 3m], `padded` with zeros.
    tie : C [2n, 2], what the past tells of places and numbers together.
    """

    number: int
    first: int
    found: Residuals
    white: Whitened
    lower: FloatArray
    pull: FloatArray
    inner: FloatArray
    slope: FloatArray
    across: FloatArray
    tie: FloatArray


class Scratch(NamedTuple):
    """What is written down for one person after the other while they are eliminated; columns are `padded`.

    Attributes
    ----------
    spread : Z and M⁻¹Uᵀ, below `BAND` rows of zeros.
    force : φ' [3m].
    information : rows of Ψ' [3, 3m].
    """

    spread: FloatArray
    force: FloatArray
    information: FloatArray


@kernel
def scratch_for(frames: int) -> Scratch:
    """Enough for people who are followed over so many frames."""
    columns = padded(CUES * frames)
    spread = np.zeros((2 * frames + 3 * BAND, columns))
    return Scratch(spread, np.empty(columns), np.empty((CUES, columns)))


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
    past: Past,
    damping: float,
    scratch: Scratch,
) -> tuple[Person, IntArray]:
    """The person with the ``track`` and what is ``given`` of it [n, 2], and the walk's ``weights`` [n].

    ``scratch`` gets Z, M⁻¹Uᵀ and φ'; returns the person, and how many columns of each row [2n] of Z have begun.
    """
    n, m = len(track), len(found.frame)
    spread, force = scratch.spread, scratch.force
    lower, pull = _track_terms(track, given, found, white, weights, walk)
    add_pace(track, walk.pace, lower, pull)
    told, tie = _add_past(past, number, track, person, lower, pull)
    for i in range(2 * n):
        lower[i, 0] = lower[i, 0] * (1.0 + damping) + SOMEWHERE
    factor(lower)
    forward(lower, pull, BAND)
    across, sides = sides_of(found, white, lower, pull, tie)
    filled = fill_spread(found, white, lower, spread)
    for p in range(padded(CUES * m)):
        force[p] = white.force[p // CUES, p % CUES] if p < CUES * m else 0.0
    add_numbers(spread, filled, sides, across, force)
    slope, information = told[PLACES:].copy(), past.information[number, PLACES:, PLACES:].copy()
    for a in range(PERSON):
        slope[a] += (person[a] - prior.mean[a]) / prior.std[a] ** 2
        information[a, a] += 1.0 / prior.std[a] ** 2
    _add_numbers_told(found, across, force, slope, information)
    _take_tie(lower, tie, sides, slope, information)
    i00, i01, i11 = information[0, 0], information[0, 1], information[1, 1]
    inner, determinant = np.empty((PERSON, PERSON)), i00 * i11 - i01 * i01
    inner[0, 0], inner[1, 1] = i11 / determinant, i00 / determinant
    inner[0, 1] = inner[1, 0] = -i01 / determinant
    scale, own = 1.0 / np.sqrt(i00), 1.0 / np.sqrt(determinant / i00)
    height, edge = spread[BAND + 2 * n], spread[BAND + 2 * n + 1]
    for p in range(CUES * m):
        u, v = across[0, p], across[1, p]
        height[p], edge[p] = scale * u, own * (v - i01 / i00 * u)
        force[p] -= (inner[0, 0] * u + inner[0, 1] * v) * slope[0] + (inner[1, 0] * u + inner[1, 1] * v) * slope[1]
    return Person(number, first, found, white, lower, pull, inner, slope, across, tie), filled


@kernel
def _add_past(
    past: Past, number: int, track: FloatArray, person: FloatArray, lower: FloatArray, pull: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Add what the past tells of the first places to A and g_x; returns its gradient [10], and C [2n, 2]."""
    told, _ = pull_of(past, number, track, person)
    tie = np.zeros((len(pull), PERSON))
    for i in range(min(len(pull), PLACES)):
        pull[i] += told[i]
        for j in range(i + 1):
            lower[j, i - j] += past.information[number, i, j]
        for a in range(PERSON):
            tie[i, a] = past.information[number, i, PLACES + a]
    return told, tie


@kernel
def _add_numbers_told(
    found: Residuals, across: FloatArray, force: FloatArray, slope: FloatArray, information: FloatArray
) -> None:
    """Add Q_pᵀφ to g_p, and Q_pᵀU to the upper half of I_p."""
    for i in range(len(found.frame)):
        for j in range(CUES):
            p, by_height, by_edge = CUES * i + j, found.by_person[i, j, 0], found.by_person[i, j, 1]
            slope[0] += by_height * force[p]
            slope[1] += by_edge * force[p]
            information[0, 0] += by_height * across[0, p]
            information[0, 1] += by_height * across[1, p]
            information[1, 1] += by_edge * across[1, p]


@kernel
def _take_tie(
    lower: FloatArray, tie: FloatArray, sides: FloatArray, slope: FloatArray, information: FloatArray
) -> None:
    """Take from g_p and I_p what C and the places' elimination leave of it, with L⁻¹C and the ``sides`` [2n, 3]."""
    for a in range(PERSON):
        alone = tie[:, a].copy()
        forward(lower, alone, BAND)
        for i in range(len(alone)):
            slope[a] -= alone[i] * sides[i, PERSON]
            for b in range(a, PERSON):
                information[a, b] -= alone[i] * sides[i, b]


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
            x, y = found.by_place[i, j, 0], found.by_place[i, j, 1]
            lower[r, 0] += white.diagonal[i, j] * x * x
            lower[r, 1] += white.diagonal[i, j] * x * y
            lower[r + 1, 0] += white.diagonal[i, j] * y * y
            pull[r] += x * white.force[i, j]
            pull[r + 1] += y * white.force[i, j]
            link = white.beside[i, j]
            if link != 0.0:
                p = 2 * found.frame[i - 1]
                other_x, other_y = found.by_place[i - 1, j, 0], found.by_place[i - 1, j, 1]
                lower[p, r - p] += link * x * other_x
                lower[p, r + 1 - p] += link * y * other_x
                lower[p + 1, r - p - 1] += link * x * other_y
                lower[p + 1, r - p] += link * y * other_y
    return lower, pull


@kernel
def add_person(person: Person, filled: IntArray, scratch: Scratch, gradient: FloatArray, hessian: FloatArray) -> None:
    """Add Q_fᵀφ' to the gradient [7T], and Q_fᵀΨ'Q_f to the lower half of the Hessian [7T, 7T].

    A column depends on x, y, yaw and offset, a length on x and y, and a foot on all but the offset. ``filled`` and
    ``scratch`` are as `eliminate` leaves them.
    """
    found, start = person.found, FRAME * person.first
    some, begin = np.zeros((CUES, FRAME * (len(filled) // 2))), 0  # rows of Ψ'Q_f
    for i in range(len(found.frame)):
        here, by_frame = FRAME * found.frame[i], found.by_frame[i]
        for a in range(FRAME):
            for j in range(CUES):
                gradient[start + here + a] += by_frame[j, a] * scratch.force[CUES * i + j]
        begin = information_of(i, begin, person.white, scratch.spread, filled, scratch.information)
        for j in range(CUES):
            row, told = some[j], scratch.information[j]
            for h in range(i + 1):
                q, other = FRAME * found.frame[h], found.by_frame[h]
                u, v, w = told[CUES * h], told[CUES * h + 1], told[CUES * h + 2]
                row[q] = u * other[0, 0] + v * other[1, 0] + w * other[2, 0]
                row[q + 1] = u * other[0, 1] + v * other[1, 1] + w * other[2, 1]
                row[q + 2] = u * other[0, 2] + w * other[2, 2]
                row[q + PITCH], row[q + ROLL] = w * other[2, PITCH], w * other[2, ROLL]
                row[q + HEIGHT], row[q + OFFSET] = w * other[2, HEIGHT], u * other[0, OFFSET]
        column, length, foot = some[0], some[1], some[2]
        for a in range(FRAME):
            target = hessian[start + here + a, start:]
            if a < PITCH:
                u, v, w = by_frame[0, a], by_frame[1, a], by_frame[2, a]
                for c in range(here + FRAME):
                    target[c] += u * column[c] + v * length[c] + w * foot[c]
            else:
                only, share = (column, by_frame[0, a]) if a == OFFSET else (foot, by_frame[2, a])
                for c in range(here + FRAME):
                    target[c] += share * only[c]
