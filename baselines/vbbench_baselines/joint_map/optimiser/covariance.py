"""Covariances of poses and places: the inverse of the joint energy's Hessian.

With Σ = H⁻¹ of the poses, people eliminated, a place has the covariance A⁻¹ given the poses, and follows them:

    Cov(x) = A⁻¹ + (∂x/∂p) Σ (∂x/∂p)ᵀ,   ∂x/∂p = A⁻¹ M G,

to which an unknown stature adds its own part. H takes the Student-t terms at their weights, so the covariances hold if
the weights are right.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.walks import Walk
from vbbench_baselines.joint_map.optimiser.banded import (
    BAND,
    factor_wide,
    invert,
    invert_wide,
    solve,
    solve_wide,
)
from vbbench_baselines.joint_map.optimiser.people import Person, axes_of, eliminate, to_poses, weighed
from vbbench_baselines.joint_map.optimiser.poses import eliminate_all, hessian_of, reach_of
from vbbench_baselines.joint_map.optimiser.state import JointProblem, State


@kernel
def pose_covariance_of(state: State, problem: JointProblem) -> FloatArray:
    """The band [3T, w + 1] of Σ of the poses at the energy's minimum; zero for given ones.

    Row i holds Σ[i, i] to Σ[i, i + w], as far as twice the reach goes: what half of it to either side of a frame says.
    """
    frames, people = len(state.poses), eliminate_all(state, problem.walk)
    reach = 2 * reach_of(people)
    band, tall = _factored(people, state, problem, reach)
    while not band[0, 0] > 0.0:
        reach *= 2
        band, tall = _factored(people, state, problem, reach)
    sigma = invert_wide(band)
    if len(tall) > 0:
        _add_heights(band, tall, sigma)
    for t in range(frames):
        if problem.anchor.fixed[t]:
            for p in range(3 * t, 3 * t + 3):
                sigma[p] = 0.0
                for d in range(1, min(sigma.shape[1] - 1, p) + 1):
                    sigma[p - d, d] = 0.0
    return sigma


@kernel
def _factored(people: list[Person], state: State, problem: JointProblem, reach: int) -> tuple[FloatArray, FloatArray]:
    """Cholesky factor of B, and V, of the Hessian; the first number is zero if it was cut too short to be positive."""
    band, tall = hessian_of(people, state, problem, reach)
    for t in range(len(state.poses)):
        band[3 * t + 2, 0] += 1e-9
    if not factor_wide(band) and reach < len(state.poses) - 1:
        band[0, 0] = 0.0
    return band, tall


@kernel
def _add_heights(lower: FloatArray, tall: FloatArray, sigma: FloatArray) -> None:
    """Add what unknown heights that span more than the band do to the covariance (Woodbury)."""
    across = tall.copy()
    for i in range(len(across)):
        solve_wide(lower, across[i])
    shared = np.linalg.solve(np.eye(len(tall)) - tall @ across.T, across)
    for i in range(len(sigma)):
        for d in range(min(sigma.shape[1], len(sigma) - i)):
            for k in range(len(tall)):
                sigma[i, d] += across[k, i] * shared[k, i + d]


@kernel
def block_of(sigma: FloatArray, first: int, last: int) -> FloatArray:
    """Σ [3m, 3m] of the m frames from ``first`` to ``last``, of its band ``sigma``."""
    size = 3 * (last - first + 1)
    block = np.empty((size, size))
    for i in range(size):
        for j in range(i, size):
            block[i, j] = block[j, i] = sigma[3 * first + i, j - i]
    return block


@kernel
def place_covariances(state: State, walk: Walk, sigma: FloatArray, oldest: int) -> FloatArray:
    """[T, K, 2, 2] in m² of the places from frame ``oldest`` on, NaN where there is no box; ``sigma`` as above."""
    data = state.data
    frames, people = len(state.poses), len(data.first)
    spread, axes = np.full((frames, people, 2, 2), np.nan), axes_of(state.poses)
    reach = frames - 1 if sigma.shape[1] >= 3 * frames else (sigma.shape[1] - 3) // 6
    inverse = np.zeros((2 * frames + BAND, BAND + 2 * reach + 2))
    for k in range(people):
        if data.last[k] < max(data.first[k], oldest):
            continue
        person = eliminate(k, state.poses, axes, data, state.weights[k], walk)
        invert(person.lower, inverse)
        _spread_person(person, inverse, sigma, oldest, reach, spread)
    return spread


@kernel
def _spread_person(
    person: Person, inverse: FloatArray, sigma: FloatArray, oldest: int, reach: int, spread: FloatArray
) -> None:
    """Write the covariances of one person's places to ``spread`` [T, K, 2, 2]; ``inverse`` holds the band of A⁻¹."""
    n, first = len(person.track), person.first
    tilt, raised = to_poses(person.response, person.arms), np.zeros(2 * n)
    if not np.isinf(person.height_information):
        raised = weighed(person.information, person.along)
        solve(person.lower, raised)
    for i in range(max(oldest - first, 0), n):
        if not person.seen[i]:
            continue
        low, high = max(i - reach, 0), min(i + reach, n - 1)
        across, rows, alone = np.zeros((2, 2 * n)), np.empty((2, 3 * (high - low + 1))), np.zeros((2, 2))
        for a in range(2):
            p = 2 * i + a
            for q in range(2 * low, 2 * high + 2):
                across[a, q] = inverse[p, BAND + q - p] if q >= p else inverse[q, BAND + p - q]
            alone[a] = across[a, 2 * i : 2 * i + 2]
            moved = to_poses(weighed(person.information, across[a]), person.arms)
            moved -= raised[p] / person.height_information * tilt
            rows[a] = moved[3 * low : 3 * high + 3]
        for a in range(2):
            for b in range(2):
                alone[a, b] += raised[2 * i + a] * raised[2 * i + b] / person.height_information
        spread[first + i, person.number] = alone + rows @ block_of(sigma, first + low, first + high) @ rows.T
