"""Damped Gauss–Newton on the poses, with the Student-t weights renewed between steps.

A step minimises the quadratic model of the weighted energy (Levenberg–Marquardt, the damping scaled by the Hessian's
diagonal) and is taken only if that energy falls; renewed weights lower the robust energy, too, because the weighted one
touches it from above. The loop has converged when a whole step is shorter than the tolerance.
"""

from typing import NamedTuple

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_baselines.compiled import kernel
from vbbench_baselines.joint_map.people import Scene
from vbbench_baselines.joint_map.poses import Anchor, energy_of, linearise
from vbbench_baselines.joint_map.sighted import farther
from vbbench_baselines.joint_map.walks import Walk, reweigh, walk_deviance, walk_energy

LONGEST = 1.0
"""No step moves a pose further, in m and rad."""

TRIES = 8
"""Dampings tried before a step is given up."""


class Settled(NamedTuple):
    """Where the descent ended.

    Attributes
    ----------
    poses, places, heights : [T, 3], [T, K, 2] (NaN where a person is not followed) and [K].
    weights, yaw_weights : [K + 1, T] and [T], see `vbbench_baselines.joint_map.poses.energy_of`.
    variances : [K + 1] σ_k² in m².
    deviance : −ln of the robust posterior density, up to a constant.
    converged : whether the last step was shorter than the tolerance.
    rounds : steps taken.
    scene : what was known, with the boxes' noise that belongs to the distances found.
    """

    poses: FloatArray
    places: FloatArray
    heights: FloatArray
    weights: FloatArray
    yaw_weights: FloatArray
    variances: FloatArray
    deviance: float
    converged: bool
    rounds: int
    scene: Scene


@kernel
def settle(
    poses: FloatArray,
    places: FloatArray,
    scene: Scene,
    anchor: Anchor,
    walk: Walk,
    rounds: int,
    tolerance: float,
) -> Settled:
    """Descend from poses [T, 3] (yaws unwrapped) and places [T, K, 2] (NaN = unknown, which only costs a round)."""
    frames, people = len(poses), len(scene.first)
    poses, places, heights = unwrapped(poses), places.copy(), scene.stature.copy()
    weights = np.full((people + 1, frames), 1.0 / walk.sigma**2)
    variances, yaw_weights = np.full(people + 1, walk.sigma**2), np.zeros(frames)
    inverse = np.empty((2 * frames, 2 * frames))
    renew(poses, places, scene, walk, weights, variances, yaw_weights)
    boxes = scene
    scene = rescaled(boxes, poses, places, heights)
    damping, converged, done = 1e-6, False, 0
    trial_places = places.copy()
    while done < rounds and not converged:
        done += 1
        energy, gradient, hessian = linearise(
            poses, scene, anchor, walk, weights, yaw_weights, places, heights, inverse
        )
        taken, length = False, np.inf
        for _ in range(TRIES):
            damped = hessian.copy()
            for i in range(3 * frames):
                damped[i, i] += damping * hessian[i, i] + 1e-9
            step = np.linalg.solve(damped, -gradient).reshape((frames, 3))
            length = np.max(np.abs(step))
            if length > LONGEST:
                step *= LONGEST / length
            trial = poses + step
            fallen = energy_of(trial, scene, anchor, walk, weights, yaw_weights, trial_places, heights)
            if fallen <= energy + 1e-9 * abs(energy) + 1e-12:
                taken = True
                break
            damping = max(damping, 1e-6) * 10.0
        if taken:
            poses, damping = trial, max(damping * 0.1, 1e-9)
            places[:] = trial_places
        renew(poses, places, scene, walk, weights, variances, yaw_weights)
        scene = rescaled(boxes, poses, places, heights)
        converged = length < tolerance
        if not taken:
            break
    energy = energy_of(poses, scene, anchor, walk, weights, yaw_weights, places, heights)
    deviance = _deviance(energy, poses, places, scene, walk, weights, variances, yaw_weights)
    return Settled(poses, places, heights, weights, yaw_weights, variances, deviance, converged, done, scene)


@kernel
def rescaled(scene: Scene, poses: FloatArray, places: FloatArray, heights: FloatArray) -> Scene:
    """The scene with its boxes linearised about these poses, places and heights, where known (see `farther`)."""
    relative, information = scene.relative.copy(), scene.information.copy()
    for t in range(len(poses)):
        for k in range(len(scene.first)):
            if not np.isnan(places[t, k, 0] + relative[t, k, 0]):
                q = farther(relative[t, k] * (heights[k] / scene.stature[k]), places[t, k], poses[t])
                relative[t, k] *= 2.0 * q - q * q
                information[t, k] /= q**4
    return Scene(relative, information, scene.given, scene.first, scene.last, scene.stature, scene.stature_variance)


@kernel
def unwrapped(poses: FloatArray) -> FloatArray:
    """Poses [T, 3] whose yaws never jump by more than half a turn."""
    poses = poses.copy()
    for t in range(1, len(poses)):
        turns = np.round((poses[t - 1, 2] - poses[t, 2]) / (2.0 * np.pi))
        poses[t, 2] += turns * 2.0 * np.pi
    return poses


@kernel
def renew(
    poses: FloatArray,
    places: FloatArray,
    scene: Scene,
    walk: Walk,
    weights: FloatArray,
    variances: FloatArray,
    yaw_weights: FloatArray,
) -> None:
    """Weights and scales of everybody's innovations at these poses and places, as far as these are known."""
    for k in range(len(scene.first)):
        first, last = int(scene.first[k]), int(scene.last[k])
        if last < first or np.any(np.isnan(places[first : last + 1, k])):
            continue
        track = places[first : last + 1, k].copy()
        variances[k] = reweigh(track, walk, weights[k], variances[k])
    variances[-1] = reweigh(poses[:, :2].copy(), walk, weights[-1], variances[-1])
    for t in range(1, len(poses)):
        yaw_weights[t] = 2.0 / (walk.yaw_scale**2 + (poses[t, 2] - poses[t - 1, 2]) ** 2)


@kernel
def _deviance(
    energy: float,
    poses: FloatArray,
    places: FloatArray,
    scene: Scene,
    walk: Walk,
    weights: FloatArray,
    variances: FloatArray,
    yaw_weights: FloatArray,
) -> float:
    """The weighted energy with the weighted motion terms replaced by the robust ones."""
    total = energy
    for k in range(len(scene.first) + 1):
        if k == len(scene.first):
            track = poses[:, :2].copy()
        elif scene.last[k] >= scene.first[k]:
            track = places[int(scene.first[k]) : int(scene.last[k]) + 1, k].copy()
        else:
            continue
        total += walk_deviance(track, variances[k], walk) - walk_energy(track, weights[k], walk)
    for t in range(1, len(poses)):
        d = poses[t, 2] - poses[t - 1, 2]
        total += np.log(1.0 + (d / walk.yaw_scale) ** 2) - 0.5 * yaw_weights[t] * d * d
    return float(total)
