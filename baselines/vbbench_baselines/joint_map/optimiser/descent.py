"""Damped Gauss–Newton on the poses, with the Student-t weights renewed between steps.

A step minimises the quadratic model of the weighted energy (Levenberg–Marquardt, the damping scaled by the Hessian's
diagonal), with all people following, and is taken only if the deviance falls. The Hessian, most of a step's cost, is
renewed only now and then: the gradient is that of the point, so that an old Hessian costs steps but not exactness.

Renewed weights, and the turns of whole paths, for which Gauss–Newton takes the energy for far stiffer than it is, make
such steps too short, many in a row in the same direction. So from the third on each is stretched: its line is followed
farther as long as the deviance falls (`_stretched`).

The loop has converged when a whole step is short in metres or in standard deviations, λ² = gᵀH⁻¹g, or when two in a row
gain next to nothing: the exact place of poses that are hardly known does not matter.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import factor_wide, solve_wide
from vbbench_baselines.joint_map.optimiser.people import Person, follow
from vbbench_baselines.joint_map.optimiser.poses import eliminate_all, gradient_of, hessian_of, reach_of
from vbbench_baselines.joint_map.optimiser.state import JointProblem, State, believe, deviance_of

LONGEST = 1.0
"""Maximum length of a step of a pose, in m and rad."""

TRIES = 8
"""Dampings tried before a step is given up."""

STIFFER = 30.0
"""Factor of the damping from try to try: what is hardly known is softer than the rest by nine orders of magnitude."""

MOST_DAMPED = 1e6
"""A Hessian that needs more is not finite; its step fails."""

RENEWED, LONG, OLDEST = 3, 0.4, 5
"""The Hessian is renewed in the first steps if the last was longer (standard deviations), and when it is so old; steps
are stretched from the last of the first on."""

STRETCHES, SHORTEST_STRETCH = 3, 0.25
"""How often a line is followed farther, and by how much at least, in steps."""

IDLE = 25.0
"""Two steps in a row that each gain less than so many times ½λ² of a step that is short enough are the last."""


class Settled(NamedTuple):
    """Where the descent ended.

    Attributes
    ----------
    state : the last point.
    converged : whether the last step was short enough, or the last two gained next to nothing.
    rounds : how many steps it took.
    lower : Cholesky factor of the poses' Hessian at one of the last points, as `Model` has it.
    """

    state: State
    converged: bool
    rounds: int
    lower: FloatArray


@kernel
def settle(
    poses: FloatArray, places: FloatArray, problem: JointProblem, rounds: int, tolerance: float, certain: float
) -> Settled:
    """Descend from poses [T, 3] and places [T, K, 2] (NaN = unknown, which only costs a round).

    Parameters
    ----------
    rounds : most steps.
    tolerance, certain : in m and rad, and in standard deviations: a step shorter than either is the last (and `IDLE`).
    """
    variances = np.full(len(problem.data.first) + 1, problem.walk.sigma**2)
    state = believe(unwrapped(poses), places.copy(), problem.data.stature.copy(), problem, variances)
    model, done, spread, converged, stretch, idle = _no_model(), 0, np.inf, False, 1.0, 0
    while done < rounds and not converged:
        people = eliminate_all(state, problem.walk)
        gradient = gradient_of(people, state, problem)
        if (done < RENEWED and spread > LONG) or model.age >= OLDEST:
            model = _renewed(state, people, problem, model.reach, model.damping)
        before = deviance_of(state, state.data)
        trial, step, model, fallen = _try(state, before, people, gradient, model, problem)
        if np.isnan(fallen):
            break
        done, spread = done + 1, float(np.sqrt(max(float(-(step @ gradient)), 0.0)))
        known = not np.isnan(state.improbable)
        converged = bool(known and (np.max(np.abs(step)) < tolerance or spread < certain))
        if known and not converged and done >= RENEWED:
            trial, lowest, stretch = _stretched(state, trial, fallen, stretch, problem)
            idle = idle + 1 if before - lowest < 0.5 * IDLE * certain**2 else 0
            converged = idle >= 2
        state = trial
    return Settled(state, converged, done, model.lower)


class Model(NamedTuple):
    """The quadratic model of the energy.

    Attributes
    ----------
    lower : Cholesky factor of the band of the damped Hessian, see `optimiser.banded.factor_wide`.
    tall, across : [m, 3T] V of `Curvature` and VB⁻¹.
    rest : Cholesky factor of 1 − VB⁻¹Vᵀ, likewise.
    reach : beyond so many frames poses are not coupled directly.
    damping : in units of the Hessian's diagonal.
    age : steps since it was renewed.
    """

    lower: FloatArray
    tall: FloatArray
    across: FloatArray
    rest: FloatArray
    reach: int
    damping: float
    age: int


@kernel
def _no_model() -> Model:
    nothing = np.empty((0, 0))
    return Model(nothing, nothing, nothing, nothing, 0, 1e-6, OLDEST)


@kernel
def _renewed(state: State, people: list[Person], problem: JointProblem, reach: int, damping: float) -> Model:
    """The model at a point, with so long a reach, and damped so far, that it has a least energy."""
    reach, frames = max(reach, reach_of(people)), len(state.poses)
    band, tall = hessian_of(people, state, problem, reach)
    while True:
        lower, across = band.copy(), tall.copy()
        for i in range(tall.shape[1]):
            lower[i, 0] += damping * band[i, 0] + 1e-9
        sound = factor_wide(lower)
        for i in range(len(across)):
            solve_wide(lower, across[i])
        rest = _rest(tall, across)
        if (sound and factor_wide(rest)) or damping > MOST_DAMPED:
            return Model(lower, tall, across, rest, reach, damping, 0)
        if reach < frames - 1:
            reach *= 2
            band, tall = hessian_of(people, state, problem, reach)
            continue
        damping *= STIFFER


@kernel
def _rest(tall: FloatArray, across: FloatArray) -> FloatArray:
    """1 − VB⁻¹Vᵀ of m rows, as a band [2m − 1, m], or nothing."""
    count = len(tall)
    rest = np.zeros((max(2 * count - 1, 0), max(count, 1)))
    for i in range(count):
        for j in range(i, count):
            rest[i, j - i] = (1.0 if i == j else 0.0) - np.dot(tall[i], across[j])
    return rest


@kernel
def _solved(model: Model, right: FloatArray) -> FloatArray:
    """H⁻¹ right [3T]: by B alone, and what unknown heights that span more than it add (Woodbury)."""
    found = right.copy()
    solve_wide(model.lower, found)
    if len(model.tall) > 0:
        share = model.tall @ found
        solve_wide(model.rest, share)
        found += share @ model.across
    return found


@kernel
def _try(
    state: State, before: float, people: list[Person], gradient: FloatArray, model: Model, problem: JointProblem
) -> tuple[State, FloatArray, Model, float]:
    """A step [3T] that does not raise the deviance, where it leads, and the deviance there; NaN if none was found.

    If a step fails the model is renewed, and damped more if that is not enough.
    """
    most = np.inf if np.isnan(before) else before + 1e-9 * abs(before) + 1e-12
    trial, step = state, np.zeros_like(gradient)
    for _ in range(TRIES):
        step = -_solved(model, gradient)
        length = np.max(np.abs(step))
        if length > LONGEST:
            step *= LONGEST / length
        trial = _moved(state, people, step.reshape(state.poses.shape), problem)
        fallen = deviance_of(trial, state.data)
        if fallen <= most:
            lighter = max(model.damping * 0.1, 1e-9)
            older = Model(model.lower, model.tall, model.across, model.rest, model.reach, lighter, model.age + 1)
            return trial, step, older, fallen
        damping = model.damping * STIFFER if model.age == 0 else model.damping
        model = _renewed(state, people, problem, model.reach, damping)
    return trial, step, model, np.nan


@kernel
def _moved(state: State, people: list[Person], step: FloatArray, problem: JointProblem) -> State:
    """The state after a step [T, 3] of the poses, with all people following."""
    places, heights, turns = state.places.copy(), state.heights.copy(), np.empty((len(step), 2))
    turns[:, 0], turns[:, 1] = np.sin(step[:, 2]), np.cos(step[:, 2]) - 1.0
    for person in people:
        track, heights[person.number] = follow(person, step, turns)
        for t in range(len(track)):
            places[person.first + t, person.number, 0] = track[t, 0]
            places[person.first + t, person.number, 1] = track[t, 1]
    return believe(state.poses + step, places, heights, problem, state.variances)


@kernel
def _stretched(
    before: State, after: State, fallen: float, stretch: float, problem: JointProblem
) -> tuple[State, float, float]:
    """The lowest state found on the line from ``before`` through ``after``, its deviance, and the next stretch.

    It begins with ``stretch`` steps beyond ``after``, whose deviance is ``fallen``, and goes on as long as that falls.
    """
    found, lowest = after, fallen
    for _ in range(STRETCHES):
        poses = after.poses + stretch * (after.poses - before.poses)
        places = after.places + stretch * (after.places - before.places)
        heights = after.heights + stretch * (after.heights - before.heights)
        farther = believe(poses, places, heights, problem, after.variances)
        deviance = deviance_of(farther, before.data)
        if not deviance < lowest:
            return found, lowest, max(0.5 * stretch, SHORTEST_STRETCH)
        found, lowest, stretch = farther, deviance, 2.0 * stretch
    return found, lowest, stretch


@kernel
def unwrapped(poses: FloatArray) -> FloatArray:
    """Poses [T, 3] whose yaws never jump by more than half a turn."""
    poses = poses.copy()
    for t in range(1, len(poses)):
        turns = np.round((poses[t - 1, 2] - poses[t, 2]) / (2.0 * np.pi))
        poses[t, 2] += turns * 2.0 * np.pi
    return poses
