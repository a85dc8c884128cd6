"""What the walks of a solved window tell of the scale of innovations: how large they are, and how well known."""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, innovation
from vbbench_baselines.joint_map.optimiser.banded import forward, solve
from vbbench_baselines.joint_map.optimiser.people import Person, to_poses, weighed
from vbbench_baselines.joint_map.optimiser.state import JointProblem, State


@kernel
def innovations_tell(people: list[Person], state: State, problem: JointProblem, lower: FloatArray) -> FloatArray:
    """Σ (e² − r(1 − r)σ_k²) in m² and Σ r² [2] of the innovations that leave with a window's first frame.

    They are those into the frame `REACH` of ``people`` with a box in it and in all before it; see `joint_map.crowd`.
    ``lower`` is the Cholesky factor of the Hessian of the poses.
    """
    told = np.zeros(2)
    for person in people:
        if len(person.track) <= REACH or not person.seen[: REACH + 1].all():
            continue
        variance, weight = state.variances[person.number], state.weights[person.number, REACH]
        left = _variance(person, problem.walk, problem.anchor.fixed, lower)
        share = min(max(1.0 - 0.5 * weight * left, 0.0), 1.0)
        told[0] += weight * variance * innovation(person.track, REACH, problem.walk)
        told[0] -= 2.0 * share * (1.0 - share) * variance
        told[1] += 2.0 * share * share
    return told


@kernel
def _variance(person: Person, walk: Walk, fixed: BoolArray, lower: FloatArray) -> float:
    """The sum in m² of the variances of both coordinates of the innovation into the frame `REACH` of a track.

    What it would be if poses were known, and what these add.
    """
    count, total = len(person.track), 0.0
    for a in range(2):
        by_places, by_poses = np.zeros(2 * count), np.zeros(3 * len(fixed))
        for d in range(REACH + 1):
            by_places[2 * (REACH - d) + a] = walk.filters[REACH, d]
        moved = by_places.copy()
        solve(person.lower, moved)
        total += float(by_places @ moved)
        by_poses[: 3 * count] = to_poses(weighed(person.information, moved), person.arms)
        for p in range(3 * count):
            if fixed[p // 3]:
                by_poses[p] = 0.0
        forward(lower, by_poses, lower.shape[1] - 1)
        total += float(by_poses @ by_poses)
    return total
