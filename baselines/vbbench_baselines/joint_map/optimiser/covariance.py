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
from vbbench_baselines.joint_map.optimiser.banded import solve
from vbbench_baselines.joint_map.optimiser.people import Person, arms_of, axes_of, eliminate, to_poses, weighed
from vbbench_baselines.joint_map.optimiser.poses import linearise
from vbbench_baselines.joint_map.optimiser.state import JointProblem, State


@kernel
def pose_covariance_of(state: State, problem: JointProblem) -> FloatArray:
    """Σ [3T, 3T] of the poses at the energy's minimum; zero for given ones."""
    frames = len(state.poses)
    _, hessian = linearise(state, problem)
    for t in range(frames):
        hessian[3 * t + 2, 3 * t + 2] += 1e-9
    sigma = np.ascontiguousarray(np.linalg.inv(hessian))
    for t in range(frames):
        if problem.anchor.fixed[t]:
            sigma[3 * t : 3 * t + 3] = 0.0
            sigma[:, 3 * t : 3 * t + 3] = 0.0
    return sigma


@kernel
def place_covariances(state: State, walk: Walk, sigma: FloatArray, oldest: int) -> FloatArray:
    """[T, K, 2, 2] in m² of the places from frame ``oldest`` on, NaN where there is no box; ``sigma`` as above."""
    data = state.data
    frames, people = len(state.poses), len(data.first)
    spread, axes = np.full((frames, people, 2, 2), np.nan), axes_of(state.poses)
    for k in range(people):
        if data.last[k] < data.first[k]:
            continue
        person = eliminate(k, state.poses, axes, data, state.weights[k], walk)
        _spread_person(person, int(data.first[k]), k, state.poses, sigma, oldest, spread)
    return spread


@kernel
def _spread_person(
    person: Person, first: int, k: int, poses: FloatArray, sigma: FloatArray, oldest: int, spread: FloatArray
) -> None:
    """Write the covariances of one person's places to ``spread`` [T, K, 2, 2]."""
    n = len(person.track)
    arms = arms_of(person, poses)
    tilt = to_poses(person.response, arms)
    raised = np.zeros(2 * n)
    if not np.isinf(person.height_information):
        raised = weighed(person.information, person.along)
        solve(person.lower, raised)
    own = np.ascontiguousarray(sigma[3 * first : 3 * (first + n), 3 * first : 3 * (first + n)])
    for i in range(max(oldest - first, 0), n):
        if not person.seen[i]:
            continue
        follow, alone = np.zeros((2, 3 * n)), np.zeros((2, 2))
        for a in range(2):
            row = np.zeros(2 * n)
            row[2 * i + a] = 1.0
            solve(person.lower, row)
            alone[a] = row[2 * i : 2 * i + 2]
            follow[a] = to_poses(weighed(person.information, row), arms)
            follow[a] -= raised[2 * i + a] / person.height_information * tilt
        for a in range(2):
            for b in range(2):
                alone[a, b] += raised[2 * i + a] * raised[2 * i + b] / person.height_information
        spread[first + i, k] = alone + follow @ own @ follow.T
