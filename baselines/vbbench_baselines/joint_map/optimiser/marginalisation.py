"""What is kept of the frame that leaves the window: a quadratic form on poses, and one on each walk that goes on.

A walk that goes on keeps what the innovations that reach back to the frame say of its next four places, and its given
place, as `vbbench_baselines.joint_map.measurement.window.Continued`: they are eliminated with the place that is gone.
So the walk does not begin anew in the next window; and that is exactly the part of the energy that is left without the
frame's pose and the boxes in it. Eliminating people makes the energy's Hessian H in the poses, and H' that of the part.
What the frame tells of the other poses, besides what the walks keep, is

    Λ = H_rr − H_r0 H_00⁻¹ H_0r − H',   s = g_r − H_r0 H_00⁻¹ g_0 − g',

with the gradients g and g', where 0 is the pose that leaves and r the others. Added to the window's energy it keeps the
minimum and its curvature: a sliding window only loses the freedom to linearise again. All terms that are gone are
positive, and a sum has its least value not below that of a part, whatever it is taken over: Λ has no direction of
negative curvature.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.odometry import Motions, unmeasured
from vbbench_baselines.joint_map.measurement.window import (
    HELD,
    Continued,
    Measurements,
    spans_of,
)
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, evidence
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, innovation
from vbbench_baselines.joint_map.optimiser.descent import Settled
from vbbench_baselines.joint_map.optimiser.innovations import innovations_tell
from vbbench_baselines.joint_map.optimiser.people import Person
from vbbench_baselines.joint_map.optimiser.poses import eliminate_those, full, gradient_of, hessian_of
from vbbench_baselines.joint_map.optimiser.state import Anchor, JointProblem, State

REMEMBERED = 0.85
"""How much of its innovations that are gone counts in a walk's scale from frame to frame: six of them in the end."""


class Marginal(NamedTuple):
    """Information of earlier frames on the first n frames of the next window.

    Attributes
    ----------
    poses, slope, information, odds : [n, 3], [3n], [3n, 3n] and [M], as in `Anchor`.
    """

    poses: FloatArray
    slope: FloatArray
    information: FloatArray
    odds: FloatArray


NOTHING_KEPT = Marginal(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 0)), np.zeros(FOLLOWERS))


class Left(NamedTuple):
    """What a frame leaves behind: for the poses, of the walks that go on, and `innovations_tell` [2]."""

    kept: Marginal
    continued: Continued
    told: FloatArray


def anchor_of(fixed: BoolArray, kept: Marginal) -> Anchor:
    """What constrains the poses of a window, of which ``fixed`` [T] are given."""
    return Anchor(fixed, *kept)


def marginalise(settled: Settled, problem: JointProblem, tells: bool) -> Left:
    """What the first frame of a window that has ``settled`` leaves behind, if it ``tells`` of innovations, too."""
    slope, information, continued, odds, told = _leave(settled.state, settled.lower, problem, tells)
    return Left(Marginal(settled.state.poses[1:], slope, information, odds), continued, told)


def keep(whole: Continued, part: Continued, columns: IntArray | None) -> None:
    """Write what goes on of the people ``columns`` [M] to that of all; of nobody else anything goes on."""
    rows = slice(None) if columns is None else columns
    whole.held[:-1] = 0
    for every, some in ((whole.held, part.held), (whole.tally, part.tally)):
        every[:-1][rows], every[-1] = some[:-1], some[-1]
    for every, some in zip(whole[1:4], part[1:4], strict=True):
        every[rows] = some


def only_those(whole: Continued, columns: IntArray | None) -> Continued:
    """What goes on of the people ``columns`` [M], and of the observer."""
    if columns is None:
        return whole
    rows = np.append(columns, len(whole.held) - 1)
    places, slope, information = (values[columns] for values in whole[1:4])
    return Continued(whole.held[rows], places, slope, information, whole.tally[rows])


def move_kept(moved: FloatArray, kept: Marginal, continued: Continued) -> Marginal:
    """``kept`` about poses that ``moved`` [n, 2] with all people; the walks in ``continued`` are moved in place."""
    poses, reach = kept.poses.copy(), min(len(moved), continued.places.shape[1])
    poses[:, :2] += moved[: len(poses)]
    continued.places[:, :reach] += moved[:reach]
    return kept._replace(poses=poses)


@kernel
def _leave(
    state: State, lower: FloatArray, problem: JointProblem, tells: bool
) -> tuple[FloatArray, FloatArray, Continued, FloatArray, FloatArray]:
    """Slope [3(T − 1)] and information [3(T − 1), 3(T − 1)] that the first of T frames leaves, and more of `Left`."""
    everybody = eliminate_those(state, problem.walk, state.data.first == 0)  # who comes later changes nothing
    slope, information, continued = _schur_complement(state, everybody, problem)
    odds = problem.anchor.odds.copy()
    if unmeasured(problem.motions)[1]:
        odds += evidence(state.poses[:2], problem.walk.head)
    told = innovations_tell(everybody, state, problem, lower) if tells else np.zeros(2)
    return slope, information, continued, odds, told


@kernel
def _schur_complement(
    state: State, everybody: list[Person], problem: JointProblem
) -> tuple[FloatArray, FloatArray, Continued]:
    """Slope s, information Λ and walks that go on after the first of T frames, in which ``everybody`` begins."""
    data, walk, motions, anchor = state.data, problem.walk, problem.motions, problem.anchor
    frames, continued = len(state.poses), go_on(state, problem)
    relative, given = data.relative[1:], data.given[1:]
    first, last = spans_of(relative, given, continued.held)
    for k in range(len(last)):
        if last[k] < 0:
            continued.held[k] = 0
    shorter = Measurements(
        relative, data.information[1:], given, first, last, data.stature, data.stature_variance, continued
    )
    weights = np.zeros((len(state.weights), frames - 1))
    for k in range(len(weights)):
        begun = int(k == len(data.first) or data.first[k] == 0)
        weights[k] = state.weights[k, begun : begun + frames - 1]
    poses, places, yaw_weights = state.poses[1:], state.places[1:], state.yaw_weights[1:]
    later = State(poses, places, state.heights, weights, yaw_weights, state.variances, shorter, np.nan)
    nothing = Anchor(anchor.fixed[1:], np.zeros((0, 3)), np.zeros(0), np.zeros((0, 0)), anchor.odds)
    rest = JointProblem(shorter, nothing, walk, Motions(motions.moved[1:], motions.information[1:]))
    others = eliminate_those(later, walk, continued.held[:-1] > 0)
    arms = np.zeros((frames, len(data.first), 2))
    for person in everybody:
        arms[: len(person.arms), person.number] = person.arms
    for person in others:  # the same, so that what is taken away is a part of what is there
        person.arms[:] = arms[1 : 1 + len(person.arms), person.number]
    slope, whole = gradient_of(everybody, state, problem), full(hessian_of(everybody, state, problem, frames))
    across, before = np.ascontiguousarray(whole[3:, :3]), np.ascontiguousarray(whole[:3, :3])
    for i in range(3):
        before[i, i] += 1e-9
    share = np.ascontiguousarray(np.linalg.solve(before, np.ascontiguousarray(across.T)).T)
    slope = slope[3:] - share @ slope[:3] - gradient_of(others, later, rest)
    information = whole[3:, 3:] - share @ np.ascontiguousarray(across.T) - full(hessian_of(others, later, rest, frames))
    return slope, information, continued


@kernel
def go_on(state: State, problem: JointProblem) -> Continued:
    """What the first of T frames leaves behind of the walks that go on."""
    data, walk, past = state.data, problem.walk, state.data.continued
    people, frames = len(data.first), len(state.poses)
    held, tally = np.zeros(people + 1, np.int64), np.zeros((people + 1, 2))
    places, slope = np.zeros((people, HELD, 2)), np.zeros((people, HELD, 2))
    information = np.zeros((people, HELD, HELD))
    for k in range(people):
        if data.first[k] > 0 or data.last[k] < 1:
            continue
        count = min(int(data.last[k]) + 1, HELD + 1)
        if np.isnan(np.sum(state.places[:count, k])):
            continue
        held[k] = count - 1
        for i in range(1, count):
            for a in range(2):
                places[k, i - 1, a] = state.places[i, k, a]
        for a in range(2):
            tally[k, a] = REMEMBERED * past.tally[k, a]
        energy, pull = _first_places(k, count, state, walk)
        for i in range(1, count):
            share = energy[0, i] / energy[0, 0] if energy[0, 0] > 0.0 else 0.0
            for a in range(2):
                slope[k, i - 1, a] = pull[i, a] - share * pull[0, a]
            for j in range(1, count):
                information[k, i - 1, j - 1] = energy[i, j] - share * energy[0, j]
        _count(state.places[:count, k].copy(), state.weights[k], state.variances[k], past.held[k], walk, tally[k])
    held[people], tally[people] = min(frames - 1, HELD), REMEMBERED * past.tally[people]
    own, steps = state.poses[: held[people] + 1, :2].copy(), past.held[people]
    _count(own, state.weights[people], state.variances[people], steps, walk, tally[people])
    return Continued(held, places, slope, information, tally)


@kernel
def _first_places(k: int, count: int, state: State, walk: Walk) -> tuple[FloatArray, FloatArray]:
    """The Hessian [5, 5] and the gradient [5, 2] by the first places of what leaves with the very first."""
    data, past, energy, pull = state.data, state.data.continued, np.zeros((5, 5)), np.zeros((5, 2))
    track = state.places[:count, k]
    for i in range(past.held[k]):
        for a in range(2):
            pull[i, a] += past.slope[k, i, a]
        for j in range(past.held[k]):
            information = past.information[k, i, j]
            energy[i, j] += information
            for a in range(2):
                pull[i, a] += information * (track[j, a] - past.places[k, j, a])
    for i in range(max(past.held[k], 1), count):
        precision = (1.0 if i == 1 else state.weights[k, i]) / walk.spreads[i] ** 2
        _add_square(track, i, walk.filters[i], precision, energy, pull)
    if walk.rest > 0.0:
        _add_square(track, 1, walk.filters[1], walk.rest, energy, pull)
    if not np.isnan(data.given[0, k, 0]):
        energy[0, 0] += 1.0 / ANCHOR_STD**2
        for a in range(2):
            pull[0, a] += (track[0, a] - data.given[0, k, a]) / ANCHOR_STD**2
    return energy, pull


@kernel
def _add_square(
    track: FloatArray, i: int, coefficients: FloatArray, precision: float, energy: FloatArray, pull: FloatArray
) -> None:
    """Add half the square of a filter of places i, i − 1, … 0."""
    for a in range(2):
        off = 0.0
        for d in range(i + 1):
            off += coefficients[d] * track[i - d, a]
        for d in range(i + 1):
            pull[i - d, a] += precision * coefficients[d] * off
    for d in range(i + 1):
        for e in range(i + 1):
            energy[i - d, i - e] += precision * coefficients[d] * coefficients[e]


@kernel
def _count(track: FloatArray, weights: FloatArray, variance: float, held: int, walk: Walk, tally: FloatArray) -> None:
    """Add the innovations that leave with the first place of a track [n, 2] to ``tally`` [2]."""
    for i in range(max(held, 2), min(len(track), REACH + 1)):
        if weights[i] > 0.0:
            tally[0] += 1.0
            tally[1] += weights[i] * variance * innovation(track, i, walk)
