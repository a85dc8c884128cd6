"""The joint energy as a function of the poses alone, and its Gauss–Newton model.

Everybody eliminated (`vbbench_baselines.joint_map.people`), what is left has 3T unknowns. With G_t = ∂y_t/∂(c_t, θ_t) =
(I, J(x_t − c_t)), J the quarter turn, a person adds Gᵀ M (y − x) to the gradient and Gᵀ H_yy G to the Hessian: that of
the whole problem in poses and places together. It is x and not y that G turns about c: M turns with the camera, too.
The observer is a walker whose place is c itself. A Cauchy distribution of yaw increments d with scale γ counts as the
normal one with precision 2/(γ² + d²) that touches it.
"""

from typing import NamedTuple

import numpy as np

from vbbench.arrays import BoolArray, FloatArray
from vbbench_baselines.compiled import kernel
from vbbench_baselines.joint_map.banded import invert
from vbbench_baselines.joint_map.people import Person, Scene, eliminate
from vbbench_baselines.joint_map.walks import REACH, Walk, add_walk, walk_energy


class Anchor(NamedTuple):
    """What holds the poses.

    Attributes
    ----------
    fixed : [T] whether the pose is given.
    poses, slope, information : [T, 3], [3T] and [3T, 3T] what is kept of frames before, sᵀd + ½ dᵀΛd with d the poses'
        distance from ``poses``.
    """

    fixed: BoolArray
    poses: FloatArray
    slope: FloatArray
    information: FloatArray


@kernel
def energy_of(
    poses: FloatArray,
    scene: Scene,
    anchor: Anchor,
    walk: Walk,
    weights: FloatArray,
    yaw_weights: FloatArray,
    places: FloatArray,
    heights: FloatArray,
) -> float:
    """The least energy at poses [T, 3]; writes everybody's places [T, K, 2] and heights [K] there.

    Parameters
    ----------
    weights : [K + 1, T] of innovations, each person's counted from its first frame, the observer's last.
    yaw_weights : [T] precisions in 1/rad² of the yaw increments up to each frame.
    """
    total = _own_energy(poses, anchor, walk, weights[-1], yaw_weights)
    for k in range(len(scene.first)):
        if scene.last[k] < scene.first[k]:
            continue
        person = eliminate(k, poses, scene, weights[k], walk)
        total += person.energy
        _keep(person, k, scene, places, heights)
    return total


@kernel
def linearise(
    poses: FloatArray,
    scene: Scene,
    anchor: Anchor,
    walk: Walk,
    weights: FloatArray,
    yaw_weights: FloatArray,
    places: FloatArray,
    heights: FloatArray,
    inverse: FloatArray,
) -> tuple[float, FloatArray, FloatArray]:
    """As `energy_of`, with gradient [3T] and Hessian [3T, 3T]; ``inverse`` [2T, 2T] is room to work in."""
    frames = len(poses)
    gradient, hessian = np.zeros(3 * frames), np.zeros((3 * frames, 3 * frames))
    total = _own_energy(poses, anchor, walk, weights[-1], yaw_weights)
    _own_terms(poses, anchor, walk, weights[-1], yaw_weights, gradient, hessian)
    for k in range(len(scene.first)):
        if scene.last[k] < scene.first[k]:
            continue
        person = eliminate(k, poses, scene, weights[k], walk)
        total += person.energy
        _keep(person, k, scene, places, heights)
        invert(person.lower, inverse)
        _add(person, int(scene.first[k]), poses, inverse, gradient, hessian)
    for i in range(3 * frames):
        for j in range(i):
            hessian[j, i] = hessian[i, j]
    for t in range(frames):
        if anchor.fixed[t]:
            hessian[3 * t : 3 * t + 3] = 0.0
            hessian[:, 3 * t : 3 * t + 3] = 0.0
            for a in range(3):
                hessian[3 * t + a, 3 * t + a] = 1.0
                gradient[3 * t + a] = 0.0
    return total, gradient, hessian


@kernel
def _keep(person: Person, k: int, scene: Scene, places: FloatArray, heights: FloatArray) -> None:
    first = int(scene.first[k])
    places[first : first + len(person.track), k] = person.track
    heights[k] = person.height


@kernel
def _own_energy(poses: FloatArray, anchor: Anchor, walk: Walk, weights: FloatArray, yaw_weights: FloatArray) -> float:
    """The observer's walk, its turning, and what is kept of frames before."""
    total = walk_energy(poses[:, :2], weights, walk)
    for t in range(1, len(poses)):
        total += 0.5 * yaw_weights[t] * (poses[t, 2] - poses[t - 1, 2]) ** 2
    off = (poses - anchor.poses).ravel()
    return float(total + off @ anchor.slope + 0.5 * off @ (anchor.information @ off))


@kernel
def _own_terms(
    poses: FloatArray,
    anchor: Anchor,
    walk: Walk,
    weights: FloatArray,
    yaw_weights: FloatArray,
    gradient: FloatArray,
    hessian: FloatArray,
) -> None:
    """Gradient and the lower half of the Hessian of `_own_energy`."""
    frames = len(poses)
    band = np.zeros((frames, REACH + 1))
    add_walk(weights, walk, band)
    for i in range(frames):
        for d in range(min(i, REACH) + 1):
            for a in range(2):
                hessian[3 * i + a, 3 * (i - d) + a] += band[i, d]
                gradient[3 * i + a] += band[i, d] * poses[i - d, a]
                if d > 0:
                    gradient[3 * (i - d) + a] += band[i, d] * poses[i, a]
    for t in range(1, frames):
        w, here, before = yaw_weights[t], 3 * t + 2, 3 * t - 1
        slope = w * (poses[t, 2] - poses[t - 1, 2])
        gradient[here] += slope
        gradient[before] -= slope
        hessian[here, here] += w
        hessian[before, before] += w
        hessian[here, before] -= w
    gradient += anchor.slope + anchor.information @ (poses - anchor.poses).ravel()
    hessian += anchor.information


@kernel
def _add(
    person: Person, first: int, poses: FloatArray, inverse: FloatArray, gradient: FloatArray, hessian: FloatArray
) -> None:
    """Add a person's gradient and the lower half of its Hessian; ``inverse`` holds the lower half of A⁻¹."""
    n = len(person.track)
    turn, tilt = np.zeros((n, 2)), np.zeros(3 * n)
    for i in range(n):
        turn[i, 0], turn[i, 1] = poses[first + i, 1] - person.track[i, 1], person.track[i, 0] - poses[first + i, 0]
        xx, xy, yy = person.information[i]
        x, y = person.measured[i, 0] - person.track[i, 0], person.measured[i, 1] - person.track[i, 1]
        mx, my = xx * x + xy * y, xy * x + yy * y
        p = 3 * (first + i)
        gradient[p] += mx
        gradient[p + 1] += my
        gradient[p + 2] += mx * turn[i, 0] + my * turn[i, 1]
        rx, ry = person.response[2 * i], person.response[2 * i + 1]
        tilt[3 * i], tilt[3 * i + 1], tilt[3 * i + 2] = rx, ry, rx * turn[i, 0] + ry * turn[i, 1]
    _add_hessian(person, first, turn, inverse, hessian)
    if not np.isinf(person.height_information):
        for i in range(3 * n):
            scaled = tilt[i] / person.height_information
            for j in range(i + 1):
                hessian[3 * first + i, 3 * first + j] -= scaled * tilt[j]


@kernel
def _add_hessian(person: Person, first: int, turn: FloatArray, inverse: FloatArray, hessian: FloatArray) -> None:
    """Add the lower half of Gᵀ(M − M A⁻¹ M)G; ``turn`` [n, 2] is the yaw's column of G."""
    n = len(person.track)
    for i in range(n):
        if not person.seen[i]:
            continue
        xx, xy, yy = person.information[i]
        p = 3 * (first + i)
        for j in range(i + 1):
            if not person.seen[j]:
                continue
            oxx, oxy, oyy = person.information[j]
            a, b = inverse[2 * i, 2 * j], inverse[2 * i, 2 * j + 1]
            c, d = inverse[2 * i + 1, 2 * j], inverse[2 * i + 1, 2 * j + 1]
            if i == j:
                b = c
            # M_i X, then X M_j
            ma, mb, mc, md = xx * a + xy * c, xx * b + xy * d, xy * a + yy * c, xy * b + yy * d
            ha, hb = -(ma * oxx + mb * oxy), -(ma * oxy + mb * oyy)
            hc, hd = -(mc * oxx + md * oxy), -(mc * oxy + md * oyy)
            if i == j:
                ha, hb, hc, hd = ha + xx, hb + xy, hc + xy, hd + yy
            q = 3 * (first + j)
            jx, jy = turn[j]
            ta, tc = ha * jx + hb * jy, hc * jx + hd * jy
            ix, iy = turn[i]
            hessian[p, q] += ha
            hessian[p, q + 1] += hb
            hessian[p, q + 2] += ta
            hessian[p + 1, q] += hc
            hessian[p + 1, q + 1] += hd
            hessian[p + 1, q + 2] += tc
            hessian[p + 2, q] += ix * ha + iy * hc
            hessian[p + 2, q + 1] += ix * hb + iy * hd
            hessian[p + 2, q + 2] += ix * ta + iy * tc
