"""The joint energy as a function of the poses alone, and its Gauss–Newton model.

With all people eliminated (`optimiser.people`), 3T unknowns are left. With G_t = ∂y_t/∂(c_t, θ_t) =
(I, J(x_t − c_t)), J the quarter turn, a person adds Gᵀ M (y − x) to the gradient and Gᵀ H_yy G to the Hessian: that of
the whole problem in poses and places together. It is x and not y that G turns about c: M turns with the camera, too.
The observer is a walker whose place is c itself, and a head that turns (`vbbench_baselines.joint_map.motion.heads`).
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.heads import add_curvature, add_slope
from vbbench_baselines.joint_map.motion.odometry import add_motion_curvature, add_motions
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, add_walk, observer_of
from vbbench_baselines.joint_map.optimiser.banded import BAND, invert
from vbbench_baselines.joint_map.optimiser.people import Person, arms_of, axes_of, eliminate, to_poses, weighed
from vbbench_baselines.joint_map.optimiser.state import JointProblem, State


@kernel
def linearise(state: State, problem: JointProblem) -> tuple[FloatArray, FloatArray]:
    """Gradient [3T] and Hessian [3T, 3T] at a point's poses, with all people at their least energy."""
    people = eliminate_all(state, problem.walk)
    return gradient_of(people, state, problem), hessian_of(people, state, problem)


@kernel
def eliminate_all(state: State, walk: Walk) -> list[Person]:
    """Everyone who is followed, see `eliminate`."""
    axes, data = axes_of(state.poses), state.data
    followed = [k for k in range(len(data.last)) if data.last[k] >= data.first[k]]
    return [eliminate(k, state.poses, axes, data, state.weights[k], walk) for k in followed]


@kernel
def gradient_of(people: list[Person], state: State, problem: JointProblem) -> FloatArray:
    """[3T], zero at given poses."""
    poses, anchor, walk = state.poses, problem.anchor, problem.walk
    frames = len(poses)
    gradient = anchor.slope + anchor.information @ (poses - anchor.poses).ravel()
    band = np.zeros((frames, REACH + 1))
    add_walk(state.weights[-1], observer_of(walk), band)
    for i in range(frames):
        for d in range(min(i, REACH) + 1):
            for a in range(2):
                gradient[3 * i + a] += band[i, d] * poses[i - d, a]
                if d > 0:
                    gradient[3 * (i - d) + a] += band[i, d] * poses[i, a]
    add_slope(poses, walk.head, state.yaw_weights, gradient)
    add_motions(poses, problem.motions, gradient)
    for person in people:
        pull = weighed(person.information, (person.measured - person.track).ravel())
        rows = slice(3 * person.first, 3 * (person.first + len(person.track)))
        gradient[rows] += to_poses(pull, arms_of(person, poses))
    for t in range(frames):
        if anchor.fixed[t]:
            gradient[3 * t : 3 * t + 3] = 0.0
    return gradient


@kernel
def hessian_of(people: list[Person], state: State, problem: JointProblem) -> FloatArray:
    """[3T, 3T], that of the identity at given poses."""
    poses, anchor, walk = state.poses, problem.anchor, problem.walk
    frames = len(poses)
    hessian = anchor.information.copy()
    band, inverse = np.zeros((frames, REACH + 1)), np.zeros((2 * frames + BAND, 2 * frames))
    add_walk(state.weights[-1], observer_of(walk), band)
    for i in range(frames):
        for d in range(min(i, REACH) + 1):
            hessian[3 * (i - d), 3 * i] += band[i, d]
            hessian[3 * (i - d) + 1, 3 * i + 1] += band[i, d]
    add_curvature(poses, walk.head, state.yaw_weights, hessian)
    add_motion_curvature(poses, problem.motions, hessian)
    for person in people:
        invert(person.lower, inverse)
        _add_hessian(person, arms_of(person, poses), inverse, hessian)
    for i in range(3 * frames):
        for j in range(i):
            hessian[i, j] = hessian[j, i]
    for t in range(frames):
        if anchor.fixed[t]:
            hessian[3 * t : 3 * t + 3] = 0.0
            hessian[:, 3 * t : 3 * t + 3] = 0.0
            for a in range(3):
                hessian[3 * t + a, 3 * t + a] = 1.0
    return hessian


@kernel
def _add_hessian(person: Person, arms: FloatArray, inverse: FloatArray, hessian: FloatArray) -> None:
    """Add the upper half of Gᵀ(M − M A⁻¹ M)G, less the height's share; ``inverse`` holds the upper half of A⁻¹."""
    n, first = len(person.track), person.first
    for i in range(n):
        if not person.seen[i]:
            continue
        xx, xy, yy = person.information[i]
        p = 3 * (first + i)
        for j in range(i, n):
            if not person.seen[j]:
                continue
            oxx, oxy, oyy = person.information[j]
            a, b = inverse[2 * i, 2 * j], inverse[2 * i, 2 * j + 1]
            c, d = inverse[2 * i + 1, 2 * j], inverse[2 * i + 1, 2 * j + 1]
            # M_i X, then X M_j
            ma, mb, mc, md = xx * a + xy * c, xx * b + xy * d, xy * a + yy * c, xy * b + yy * d
            ha, hb = -(ma * oxx + mb * oxy), -(ma * oxy + mb * oyy)
            hc, hd = -(mc * oxx + md * oxy), -(mc * oxy + md * oyy)
            if i == j:
                ha, hb, hc, hd = ha + xx, hb + xy, hc + xy, hd + yy
            q = 3 * (first + j)
            jx, jy = arms[j]
            ta, tc = ha * jx + hb * jy, hc * jx + hd * jy
            ix, iy = arms[i]
            hessian[p, q] += ha
            hessian[p, q + 1] += hb
            hessian[p, q + 2] += ta
            hessian[p + 1, q] += hc
            hessian[p + 1, q + 1] += hd
            hessian[p + 1, q + 2] += tc
            hessian[p + 2, q] += ix * ha + iy * hc
            hessian[p + 2, q + 1] += ix * hb + iy * hd
            hessian[p + 2, q + 2] += ix * ta + iy * tc
    if not np.isinf(person.height_information):
        tilt = to_poses(person.response, arms)
        for i in range(3 * n):
            scaled = tilt[i] / person.height_information
            for j in range(i, 3 * n):
                hessian[3 * first + i, 3 * first + j] -= scaled * tilt[j]
