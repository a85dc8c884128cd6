"""The camera's part of the energy, by the shares of the laws: its slope and its curvature."""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, turn
from vbbench_baselines.joint_map.motion.walks import REACH, innovation
from vbbench_baselines.joint_map.real_camera.cues import FRAME
from vbbench_baselines.joint_map.real_camera.observer import VEHICLE, Observer, step_of
from vbbench_baselines.joint_map.real_camera.shares import Shares

NEGLIGIBLE = 1e-4
"""A law that is less probable does not count."""


@kernel
def level_deviance(frames: FloatArray, free: BoolArray, blind: BoolArray, observer: Observer, shares: Shares) -> float:
    """−ln of what a vehicle's steps are expected to be, by their ``shares``, and of the first step."""
    total = 0.0
    for t in range(1, len(frames)):
        if free[t]:
            step = step_of(frames[t - 1], frames[t])
            length = step.forward**2 + step.right**2
            told = np.log(1.0 + (step.right / observer.level[0]) ** 2)
            told += observer.swing * np.log(1.0 + (step.turned / observer.level[1]) ** 2)
            if not blind[t]:
                told += observer.drag * np.log(1.0 + length / observer.level[2] ** 2)
            total += shares.laws[VEHICLE] * (1.0 - shares.standing[t]) * told
            if t == 1:
                total += 0.5 * length / observer.pace**2
            total += 0.5 * observer.walk.own_rest * length
            total += 0.5 * observer.backing * min(step.forward, 0.0) ** 2
    return total


@kernel
def add_observer(
    frames: FloatArray,
    free: BoolArray,
    blind: BoolArray,
    observer: Observer,
    shares: Shares,
    gradient: FloatArray,
    hessian: FloatArray,
) -> None:
    """Add the slope of `shares_of` and `level_deviance`, the shares held, to the gradient [7T], and their curvature.

    The first step's density, if the vehicle moves, counts whole in `level_deviance`: standing takes its share back. The
    curvature goes to the lower half of the Hessian [7T, 7T].
    """
    for t in range(1, len(frames)):
        if not free[t]:
            continue
        stands = shares.laws[VEHICLE] * shares.standing[t]
        share = shares.laws[VEHICLE] - stands
        step = step_of(frames[t - 1], frames[t])
        slip, swing, slow = observer.level[0], observer.level[1], observer.level[2]
        length = step.forward**2 + step.right**2
        stiffness = stands / observer.still[0] ** 2 + observer.walk.own_rest
        if not blind[t]:
            stiffness += share * observer.drag * 2.0 / (slow * slow + length)
        if t == 1:
            stiffness += (1.0 - stands) / observer.pace**2
        sideways = stiffness + share * 2.0 / (slip * slip + step.right**2)
        swings = observer.swing * (share - stands if t == 1 else share)
        turning = swings * 2.0 / (swing * swing + step.turned**2) + stands / observer.still[1] ** 2
        onwards = stiffness + (observer.backing if step.forward < 0.0 else 0.0)
        _add(step.forward_by, t - 1, onwards, step.forward, gradient, hessian)
        _add(step.right_by, t - 1, sideways, step.right, gradient, hessian)
        _add(step.turned_by, t - 1, turning, step.turned, gradient, hessian)
        if t < 2:
            continue
        if share > NEGLIGIBLE:
            _add_vehicle(frames, t, observer, share, gradient, hessian)
        if shares.laws[VEHICLE] < 1.0 - NEGLIGIBLE:
            _add_pedestrian(frames, t, observer, shares.laws, gradient, hessian)


@kernel
def _add_vehicle(
    frames: FloatArray, t: int, observer: Observer, share: float, gradient: FloatArray, hessian: FloatArray
) -> None:
    """What the changes of a vehicle's step into frame ``t`` add, by its ``share``."""
    step, before = step_of(frames[t - 1], frames[t]), step_of(frames[t - 2], frames[t - 1])
    row = np.empty(9)
    for a in range(3):
        now, then, changed = step.turned_by, before.turned_by, step.turned - before.turned
        if a == 0:
            now, then, changed = step.forward_by, before.forward_by, step.forward - before.forward
        elif a == 1:
            now, then, changed = step.right_by, before.right_by, step.right - before.right
        for i in range(9):
            row[i] = (now[i - 3] if i >= 3 else 0.0) - (then[i] if i < 6 else 0.0)
        _add(row, t - 2, share * _weight(changed, a, observer), changed, gradient, hessian)


@kernel
def _weight(changed: float, a: int, observer: Observer) -> float:
    nu = observer.nu[a]
    return float((nu + 1.0) / (nu * observer.change[a] ** 2 + changed * changed))


@kernel
def _add_pedestrian(
    frames: FloatArray, t: int, observer: Observer, shares: FloatArray, gradient: FloatArray, hessian: FloatArray
) -> None:
    """What a pedestrian's step and turn into frame ``t`` add, by the shares."""
    walk, head, order = observer.walk, observer.walk.head, min(t, REACH)
    square = innovation(frames, t, walk)
    weight = (1.0 - shares[VEHICLE]) * (walk.nu + 2.0) / (walk.nu * walk.sigma**2 + square) / walk.spreads[order] ** 2
    for a in range(2):
        off = 0.0
        for d in range(order + 1):
            off += walk.filters[order, d] * frames[t - d, a]
        for d in range(order + 1):
            p = FRAME * (t - d) + a
            gradient[p] += weight * walk.filters[order, d] * off
            for e in range(d, order + 1):
                hessian[p, FRAME * (t - e) + a] += weight * walk.filters[order, d] * walk.filters[order, e]
    for law in range(FOLLOWERS):
        if shares[1 + law] > NEGLIGIBLE:
            off, _, slopes = turn(frames[t - 1], frames[t], head, law)
            scale = head.following[law]
            _add(slopes, t - 1, 2.0 * shares[1 + law] / (scale * scale + off * off), off, gradient, hessian)
    step = step_of(frames[t - 1], frames[t])
    wandering = 2.0 * shares[-1] / (head.wandering**2 + step.turned**2)
    _add(step.turned_by, t - 1, wandering, step.turned, gradient, hessian)


@kernel
def _add(row: FloatArray, first: int, weight: float, value: float, gradient: FloatArray, hessian: FloatArray) -> None:
    """Add a residual with the slopes ``row`` [3n] by the poses of the frames from ``first`` on."""
    for i in range(len(row)):
        if row[i] == 0.0:
            continue
        p = FRAME * (first + i // 3) + i % 3
        gradient[p] += weight * row[i] * value
        for j in range(i + 1):
            hessian[p, FRAME * (first + j // 3) + j % 3] += weight * row[i] * row[j]
