"""The joint energy as a function of the poses alone, and its Gauss–Newton model.

With all people eliminated (`optimiser.people`), 3T unknowns are left. With G_t = ∂y_t/∂(c_t, θ_t) =
(I, J(x_t − c_t)), J the quarter turn, a person adds Gᵀ M (y − x) to the gradient and Gᵀ H_yy G to the Hessian: that of
the whole problem in poses and places together. It is x and not y that G turns about c: M turns with the camera, too.
The observer is a walker whose place is c itself, and a head that turns (`vbbench_baselines.joint_map.motion.heads`).
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.odometry import Motions, add_motion_curvature, add_motions
from vbbench_baselines.joint_map.motion.heads import add_curvature, add_slope
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, add_walk, observer_of
from vbbench_baselines.joint_map.optimiser.banded import BAND, invert
from vbbench_baselines.joint_map.optimiser.people import Person, axes_of, eliminate, to_poses, weighed
from vbbench_baselines.joint_map.optimiser.state import JointProblem, State

SHORTEST_REACH, SMOOTHED, MOST = 24, 6.0, 0.8
"""See `reach_of`: in frames, in l, and the quantile of people that counts."""


class Curvature(NamedTuple):
    """The Hessian in the poses of T frames, B − VᵀV.

    Attributes
    ----------
    band : [3T + w, w + 1] of B, as `vbbench_baselines.joint_map.optimiser.banded.factor_wide` takes it.
    tall : [m, 3T] V, of unknown heights of people who are followed for longer than the reach.
    """

    band: FloatArray
    tall: FloatArray


@kernel
def linearise(state: State, problem: JointProblem) -> tuple[FloatArray, FloatArray]:
    """Gradient [3T] and Hessian [3T, 3T] at a point's poses, with all people at their least energy."""
    people = eliminate_all(state, problem.walk)
    return gradient_of(people, state, problem), full(hessian_of(people, state, problem, len(state.poses)))


@kernel
def full(curvature: Curvature) -> FloatArray:
    """The Hessian [3T, 3T]."""
    hessian = -curvature.tall.T @ curvature.tall
    for i in range(len(hessian)):
        for j in range(i, min(i + curvature.band.shape[1], len(hessian))):
            hessian[i, j] += curvature.band[i, j - i]
        for j in range(i):
            hessian[i, j] = hessian[j, i]
    return hessian


@kernel
def eliminate_all(state: State, walk: Walk) -> list[Person]:
    """Everyone who is followed, see `eliminate`."""
    return eliminate_those(state, walk, np.ones(len(state.data.last), np.bool_))


@kernel
def eliminate_those(state: State, walk: Walk, those: BoolArray) -> list[Person]:
    """Everyone of ``those`` [K] who is followed."""
    axes, data = axes_of(state.poses), state.data
    followed = [k for k in range(len(data.last)) if those[k] and data.last[k] >= data.first[k]]
    return [eliminate(k, state.poses, axes, data, state.weights[k], walk) for k in followed]


@kernel
def gradient_of(people: list[Person], state: State, problem: JointProblem) -> FloatArray:
    """[3T], zero at given poses."""
    poses, anchor, walk = state.poses, problem.anchor, problem.walk
    frames, known = len(poses), len(anchor.poses)
    gradient = np.zeros(3 * frames)
    gradient[: 3 * known] = anchor.slope + anchor.information @ (poses[:known] - anchor.poses).ravel()
    band = np.zeros((frames, REACH + 1))
    add_walk(state.weights[-1], observer_of(walk), band, state.data.continued.held[-1])
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
        gradient[rows] += to_poses(pull, person.arms)
    for t in range(frames):
        if anchor.fixed[t]:
            gradient[3 * t : 3 * t + 3] = 0.0
    return gradient


@kernel
def reach_of(people: list[Person]) -> int:
    """How many frames apart poses are coupled directly: beyond, what one place says of another counts for little.

    Places are smoothed over l = (wN)^¼ frames, w the precision of innovations and N the larger noise of boxes, and what
    one says of another falls like exp(−t/√2 l). l is that of most people; where it should have been more the Hessian is
    not positive, and the descent takes twice as many frames.
    """
    lengths = np.zeros(len(people) + 1)
    for k, person in enumerate(people):
        noise, boxes = 0.0, 0
        for xx, xy, yy in person.information:
            if xx * yy - xy * xy > 0.0:
                noise += (xx + yy) / (xx * yy - xy * xy)
                boxes += 1
        lengths[k] = (np.mean(person.precisions) * noise / max(boxes, 1)) ** 0.25
    return max(int(SMOOTHED * np.quantile(lengths, MOST)), SHORTEST_REACH)


@kernel
def hessian_of(people: list[Person], state: State, problem: JointProblem, reach: int) -> Curvature:
    """That of the identity at given poses.

    Beyond ``reach`` frames it is cut, in a form that keeps what no box tells, a common motion of all, exactly as stiff
    as it is, not at all: where no place is given, H_yy = M − M A⁻¹ M = Dᵀ(W − W D A⁻¹ Dᵀ W)D. What is in brackets,
    the information of the boxes on innovations, falls exponentially away from its diagonal.
    """
    anchor, frames = problem.anchor, len(state.poses)
    reach = min(reach, frames - 1)
    width = 3 * reach + 2
    band, tall = np.zeros((3 * frames + width, width + 1)), np.zeros((_long(people, reach), 3 * frames))
    for i in range(len(anchor.slope)):
        for j in range(i, len(anchor.slope)):
            band[i, j - i] = anchor.information[i, j]
    _add_observer(state, problem, band)
    inverse, raised = np.zeros((2 * frames + BAND, BAND + 2 * reach + 2)), 0
    for person in people:
        invert(person.lower, inverse)
        _add_person(person, problem.walk, inverse, reach, band)
        if not np.isinf(person.height_information):
            tilt = to_poses(person.response, person.arms) / np.sqrt(person.height_information)
            if len(person.track) > reach + 1:
                tall[raised, 3 * person.first : 3 * person.first + len(tilt)] = tilt
                raised += 1
            else:
                for i in range(len(tilt)):
                    for j in range(i, len(tilt)):
                        band[3 * person.first + i, j - i] -= tilt[i] * tilt[j]
    _hold(anchor.fixed, band, tall)
    return Curvature(band, tall)


@kernel
def _hold(fixed: BoolArray, band: FloatArray, tall: FloatArray) -> None:
    """Make the Hessian that of the identity at ``fixed`` [T] poses."""
    for p in range(3 * len(fixed)):
        if fixed[p // 3]:
            band[p], tall[:, p] = 0.0, 0.0
            for d in range(1, min(band.shape[1] - 1, p) + 1):
                band[p - d, d] = 0.0
            band[p, 0] = 1.0


@kernel
def _long(people: list[Person], reach: int) -> int:
    """How many people of unknown height are followed for longer than the reach."""
    count = 0
    for person in people:
        if len(person.track) > reach + 1 and not np.isinf(person.height_information):
            count += 1
    return count


@kernel
def _add_observer(state: State, problem: JointProblem, band: FloatArray) -> None:
    """Add what the observer's own walk, head and odometry say."""
    poses, walk, motions = state.poses, problem.walk, problem.motions
    own = np.zeros((len(poses), REACH + 1))
    add_walk(state.weights[-1], observer_of(walk), own, state.data.continued.held[-1])
    for i in range(len(poses)):
        for d in range(min(i, REACH) + 1):
            band[3 * (i - d), 3 * d] += own[i, d]
            band[3 * (i - d) + 1, 3 * d] += own[i, d]
    pair = np.zeros((6, 6))
    for t in range(1, len(poses)):
        two = slice(t - 1, t + 1)
        pair[:] = 0.0
        add_curvature(poses[two], walk.head, state.yaw_weights[two], pair)
        add_motion_curvature(poses[two], Motions(motions.moved[two], motions.information[two]), pair)
        for i in range(6):
            for j in range(i, 6):
                band[3 * t - 3 + i, j - i] += pair[i, j]


@kernel
def _add_person(person: Person, walk: Walk, inverse: FloatArray, reach: int, band: FloatArray) -> None:
    """Add GᵀH_yyG, unknown heights left out; ``inverse`` holds the band of A⁻¹."""
    n, arms, information = len(person.track), person.arms, person.information
    near = n - 1 if n <= reach + 1 else reach - BAND
    for i in range(n):
        if not person.seen[i]:
            continue
        xx, xy, yy = information[i, 0], information[i, 1], information[i, 2]
        for j in range(i, min(i + near + 1, n)):
            if not person.seen[j]:
                continue
            oxx, oxy, oyy = information[j, 0], information[j, 1], information[j, 2]
            e = BAND + 2 * (j - i)
            a, b, c, d = inverse[2 * i, e], inverse[2 * i, e + 1], inverse[2 * i + 1, e - 1], inverse[2 * i + 1, e]
            # M_i X, then X M_j
            ma, mb, mc, md = xx * a + xy * c, xx * b + xy * d, xy * a + yy * c, xy * b + yy * d
            ha, hb = -(ma * oxx + mb * oxy), -(ma * oxy + mb * oyy)
            hc, hd = -(mc * oxx + md * oxy), -(mc * oxy + md * oyy)
            if i == j:
                ha, hb, hc, hd = ha + xx, hb + xy, hc + xy, hd + yy
            turns = arms[i, 0], arms[i, 1], arms[j, 0], arms[j, 1]
            _add_block(band, 3 * (person.first + i), 3 * (j - i), turns, (ha, hb, hc, hd))
    if n > reach + 1:
        _add_far(person, walk, inverse, reach, band)


@kernel
def _add_block(
    band: FloatArray,
    p: int,
    e: int,
    turns: tuple[float, float, float, float],
    block: tuple[float, float, float, float],
) -> None:
    """Add GᵢᵀHGⱼ, i ≤ j, at row ``p`` and column ``p`` + ``e``; ``turns`` are their arms, ``block`` is H row by row."""
    (ix, iy, jx, jy), (a, b, c, d) = turns, block
    right, below = a * jx + b * jy, c * jx + d * jy
    band[p, e] += a
    band[p, e + 1] += b
    band[p, e + 2] += right
    band[p + 1, e] += d
    band[p + 1, e + 1] += below
    band[p + 2, e] += ix * right + iy * below
    if e > 0:
        band[p + 1, e - 1] += c
        band[p + 2, e - 2] += ix * a + iy * c
        band[p + 2, e - 1] += ix * b + iy * d


@kernel
def _add_far(person: Person, walk: Walk, inverse: FloatArray, reach: int, band: FloatArray) -> None:
    """Add GᵀDᵀUDG where it feels that U = −W D A⁻¹ Dᵀ W is cut `REACH` frames before the reach of A⁻¹."""
    n, arms, last = len(person.track), person.arms, reach - REACH
    cut = np.zeros((n, BAND, 4))  # U of frames a and b, by a and b − a, from last − BAND + 1 to last
    for a in range(n):
        for b in range(a + last - BAND + 1, min(a + last, n - 1) + 1):
            u, both = cut[a, b - a - last + BAND - 1], -person.precisions[a] * person.precisions[b]
            for d in range(min(a, REACH) + 1):
                for e in range(REACH + 1):
                    share = both * walk.filters[min(a, REACH), d] * walk.filters[REACH, e]
                    p, q = 2 * (a - d), BAND + 2 * (b - e - a + d)
                    u[0] += share * inverse[p, q]
                    u[1] += share * inverse[p, q + 1]
                    u[2] += share * inverse[p + 1, q - 1]
                    u[3] += share * inverse[p + 1, q]
    for i in range(n):
        for j in range(i + reach - BAND + 1, min(i + reach, n - 1) + 1):
            ha = hb = hc = hd = 0.0
            for a in range(i, min(i + REACH, n - 1) + 1):
                for b in range(j, min(j + REACH, n - 1, a + last) + 1):
                    share = walk.filters[min(a, REACH), a - i] * walk.filters[REACH, b - j]
                    u = cut[a, b - a - last + BAND - 1]
                    ha, hb, hc, hd = ha + share * u[0], hb + share * u[1], hc + share * u[2], hd + share * u[3]
            turns = arms[i, 0], arms[i, 1], arms[j, 0], arms[j, 1]
            _add_block(band, 3 * (person.first + i), 3 * (j - i), turns, (ha, hb, hc, hd))
