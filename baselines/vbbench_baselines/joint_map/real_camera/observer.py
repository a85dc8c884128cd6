"""How the camera moves: on a vehicle, or on a pedestrian whose head follows the path by one of two laws, or wanders.

In the axes of the middle of two headings a step has the parts F forward and S to the right, and a turn ω. A vehicle
that moves changes all three slowly (Student-t), seldom slips sideways, seldom turns, and is seldom fast (Cauchy: S, ω,
‖step‖). The last keeps apart what people cannot tell: whether all walk one way or the vehicle goes the other. It is
told anew in every frame that shows anybody, and so must not be sharp. Or the vehicle stands, and F, S and ω are nearly
0 (normal). It goes on as it does, moving or standing, for some seconds, and the highest density of either is the same:
where nothing is seen, a vehicle that moves is not taken to stop because that would be more certain. Both states are
weighed in each frame by all frames.
A pedestrian is one more walker (`joint_map.motion.walks`) with a head (`joint_map.motion.heads`).

One law m holds all the time, so that all steps together tell which: with E_m the sum of −ln of the densities of the
steps under it, and o_m what earlier frames added, π_m ∝ p_m exp(o_m − E_m), and each law counts by its share π_m: a
step of expectation and maximisation.
"""

from math import lgamma, log, pi
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, strays, turn
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, innovation
from vbbench_baselines.joint_map.real_camera.cues import FRAME

LAWS = FOLLOWERS + 2
"""Vehicle, heads that follow, and the head that wanders."""

VEHICLE = 0

RULED_OUT = 1e3
"""A deviance of what cannot be."""

MOST = 700.0
"""The largest number of which eˣ is taken."""

NEGLIGIBLE = 1e-4
"""A law that is less probable does not count."""


class Observer(NamedTuple):
    """The laws' numbers.

    Attributes
    ----------
    change, nu : [3] scales in m, m and rad of changes of F, S and ω from frame to frame, and degrees of freedom.
    normalisers : [3] −ln of their densities at 0, for scales of 1.
    level, drag : [3] scales of S, ω and ‖step‖, in m, rad and m; and the weight of the last.
    pace : standard deviation in m of a component of the first step.
    walk : of a pedestrian, with the head.
    odds : [4] ln of how probable each law is at first.
    still : [2] standard deviations in m and rad of a step and of a turn of a vehicle that stands.
    leaving : how probable it is that a vehicle that stands moves in the next frame, or the other way.
    going : of so many newest frames it is taken for granted that a vehicle moves; 0 unless `Tracking` tries this.
    """

    change: FloatArray
    nu: FloatArray
    normalisers: FloatArray
    level: FloatArray
    drag: float
    pace: float
    walk: Walk
    odds: FloatArray
    still: FloatArray
    leaving: float
    going: int


class Shares(NamedTuple):
    """What the steps tell of the laws.

    Attributes
    ----------
    laws : π [4].
    standing : [T] how probable it is that a vehicle stands during the step into a frame.
    deviance : −ln of the density of all steps, of whichever law.
    """

    laws: FloatArray
    standing: FloatArray
    deviance: float


class Step(NamedTuple):
    """F, S and ω, and the slopes [6] of each by both poses, the earlier first."""

    forward: float
    right: float
    turned: float
    forward_by: FloatArray
    right_by: FloatArray
    turned_by: FloatArray


@kernel
def step_of(before: FloatArray, now: FloatArray) -> Step:
    """Between two frames' poses [≥ 3], whose yaws do not jump."""
    turned, heading = now[2] - before[2], 0.5 * (now[2] + before[2])
    sin, cos = np.sin(heading), np.cos(heading)
    x, y = now[0] - before[0], now[1] - before[1]
    forward, right = cos * x + sin * y, sin * x - cos * y
    forward_by, right_by = np.empty(6), np.empty(6)
    forward_by[0], forward_by[1], forward_by[3], forward_by[4] = -cos, -sin, cos, sin
    right_by[0], right_by[1], right_by[3], right_by[4] = -sin, cos, sin, -cos
    forward_by[2] = forward_by[5] = -0.5 * right
    right_by[2] = right_by[5] = 0.5 * forward
    turned_by = np.zeros(6)
    turned_by[2], turned_by[5] = -1.0, 1.0
    return Step(forward, right, turned, forward_by, right_by, turned_by)


def normaliser(nu: float) -> float:
    """−ln of the density of a Student-t variable of scale 1 at 0."""
    return lgamma(0.5 * nu) - lgamma(0.5 * (nu + 1.0)) + 0.5 * log(nu * pi)


@kernel
def surprise(frames: FloatArray, t: int, observer: Observer, told: FloatArray) -> None:
    """Add −ln of the density of the step into frame ``t`` ≥ 2 under each law to ``told`` [4].

    A vehicle may change between standing and moving as often as it likes.
    """
    told[VEHICLE] += min(moving_deviance(frames, t, observer), standing_deviance(frames, t, observer))
    _add_pedestrian_deviances(frames, t, observer, told)


@kernel
def moving_deviance(frames: FloatArray, t: int, observer: Observer) -> float:
    """−ln of the density of the step into frame ``t`` ≥ 1 of a vehicle that moves, given the one before."""
    now, total = step_of(frames[t - 1], frames[t]), least_deviance(t, observer)
    if t == 1:
        total += 0.5 * (now.forward**2 + now.right**2) / observer.pace**2
        return float(total + np.log(1.0 + (now.turned / observer.level[1]) ** 2))
    before = step_of(frames[t - 2], frames[t - 1])
    changes = (now.forward - before.forward, now.right - before.right, now.turned - before.turned)
    for a in range(3):
        nu = observer.nu[a]
        total += 0.5 * (nu + 1.0) * np.log(1.0 + (changes[a] / observer.change[a]) ** 2 / nu)
    return float(total)


@kernel
def standing_deviance(frames: FloatArray, t: int, observer: Observer) -> float:
    """The same of a vehicle that stands, but scaled: it is `least_deviance` where nothing moves."""
    step = step_of(frames[t - 1], frames[t])
    moved, turned = observer.still[0], observer.still[1]
    far = (step.forward**2 + step.right**2) / moved**2 + (step.turned / turned) ** 2
    return float(0.5 * far + least_deviance(t, observer))


@kernel
def least_deviance(t: int, observer: Observer) -> float:
    """−ln of the highest density of the step into frame ``t`` ≥ 1: at first of no step, then of one like the last."""
    if t == 1:
        return float(np.log(2.0 * np.pi**2 * observer.pace**2 * observer.level[1]))
    return float(np.log(observer.change).sum() + observer.normalisers.sum())


@kernel
def _add_pedestrian_deviances(frames: FloatArray, t: int, observer: Observer, told: FloatArray) -> None:
    """Add −ln of the density of the step into frame ``t`` ≥ 2 under each pedestrian's law to ``told`` [4]."""
    walk, head = observer.walk, observer.walk.head
    order = min(t, REACH)
    scale = walk.sigma * walk.spreads[order]
    walked = innovation(frames, t, walk) / walk.sigma**2
    path = np.log(2.0 * np.pi * scale * scale) + 0.5 * (walk.nu + 2.0) * np.log(1.0 + walked / walk.nu)
    residuals = np.empty(FOLLOWERS + 1)
    strays(frames[t - 1], frames[t], head, residuals)
    for law in range(FOLLOWERS + 1):
        gamma = head.following[law] if law < FOLLOWERS else head.wandering
        told[1 + law] += path + np.log(np.pi * gamma * (1.0 + (residuals[law] / gamma) ** 2))


@kernel
def _standing(frames: FloatArray, free: BoolArray, fixed: BoolArray, observer: Observer) -> tuple[FloatArray, float]:
    """[T] how probable it is that a vehicle stands, and −ln of the density of its steps.

    Forwards and backwards through a chain of two states, after Rabiner (Proceedings of the IEEE 77(2), 1989). The first
    step is taken as of a vehicle that moves, whose density is in `level_deviance`; only what standing adds counts here.
    A first step that is known tells more, since it can be held against the narrow law of standing as that is; it tells
    nothing of the other laws.
    """
    count = len(frames)
    moves, stands = np.zeros(count), np.zeros(count)
    for t in range(1, count):
        if free[t]:
            moves[t], stands[t] = moving_deviance(frames, t, observer), standing_deviance(frames, t, observer)
            if t >= count - observer.going:
                stands[t] += RULED_OUT
    known = count > 1 and free[1] and fixed[1]
    if known:
        stands[1] += least_deviance(2, observer) - least_deviance(1, observer)
    stay, leave = np.log(1.0 - observer.leaving), np.log(observer.leaving)
    log_moving, log_standing = np.full(count, np.log(0.5)), np.full(count, np.log(0.5))
    for t in range(1, count):
        log_moving[t] = _either(log_moving[t - 1] + stay, log_standing[t - 1] + leave) - moves[t]
        log_standing[t] = _either(log_standing[t - 1] + stay, log_moving[t - 1] + leave) - stands[t]
    standing, later_moving, later_standing = np.zeros(count), 0.0, 0.0
    for t in range(count - 1, 0, -1):
        more = log_moving[t] + later_moving - log_standing[t] - later_standing
        standing[t] = 1.0 / (1.0 + np.exp(min(more, MOST)))
        move, stand = later_moving - moves[t], later_standing - stands[t]
        later_moving, later_standing = _either(move + stay, stand + leave), _either(stand + stay, move + leave)
    first = moves[1] if count > 1 else 0.0  # 0 where it was measured
    if known:
        first = -_either(-moves[1], -stands[1]) - np.log(0.5)
    return standing, -_either(log_moving[-1], log_standing[-1]) - first


@kernel
def _either(a: float, b: float) -> float:
    """ln(eᵃ + eᵇ)."""
    most = max(a, b)
    return float(most + np.log(np.exp(a - most) + np.exp(b - most)))


@kernel
def shares_of(frames: FloatArray, free: BoolArray, fixed: BoolArray, observer: Observer, odds: FloatArray) -> Shares:
    """What steps into ``free`` frames tell of the laws, after ``odds`` of frames before; ``fixed`` poses are known."""
    told, shares, least, total = np.empty(LAWS), np.empty(LAWS), np.inf, 0.0
    for law in range(LAWS):
        told[law] = -(observer.odds[law] + odds[law])
    standing, steps = _standing(frames, free, fixed, observer)
    told[VEHICLE] += steps
    for t in range(2, len(frames)):
        if free[t]:
            _add_pedestrian_deviances(frames, t, observer, told)
    for law in range(LAWS):
        least = min(least, told[law])
    for law in range(LAWS):
        shares[law] = np.exp(least - told[law])
        total += shares[law]
    for law in range(LAWS):
        shares[law] /= total
    return Shares(shares, standing, least - np.log(total))


@kernel
def level_deviance(frames: FloatArray, free: BoolArray, blind: BoolArray, observer: Observer, shares: Shares) -> float:
    """−ln of what a vehicle's steps are expected to be, by their ``shares``, and of the first step."""
    total = 0.0
    for t in range(1, len(frames)):
        if free[t]:
            step = step_of(frames[t - 1], frames[t])
            length = step.forward**2 + step.right**2
            told = np.log(1.0 + (step.right / observer.level[0]) ** 2)
            told += np.log(1.0 + (step.turned / observer.level[1]) ** 2)
            if not blind[t]:
                told += observer.drag * np.log(1.0 + length / observer.level[2] ** 2)
            total += shares.laws[VEHICLE] * (1.0 - shares.standing[t]) * told
            if t == 1:
                total += 0.5 * length / observer.pace**2
            total += 0.5 * observer.walk.own_rest * length
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
        swings = share - stands if t == 1 else share
        turning = swings * 2.0 / (swing * swing + step.turned**2) + stands / observer.still[1] ** 2
        _add(step.forward_by, t - 1, stiffness, step.forward, gradient, hessian)
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
