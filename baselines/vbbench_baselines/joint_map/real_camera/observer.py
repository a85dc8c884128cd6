"""How the camera moves: on a vehicle, or on a pedestrian whose head follows the path by one of two laws, or wanders.

In the axes of the middle of two headings a step has the parts F forward and S to the right, and a turn ω. A vehicle
that moves changes all three slowly (Student-t), seldom slips sideways, seldom turns, and is seldom fast (Cauchy: S, ω,
‖step‖). The last keeps apart what people cannot tell: whether all walk one way or the vehicle goes the other. It is
told anew in every frame that shows anybody, and so must not be sharp. A turn lasts for seconds, whatever the frame
rate: told anew in every frame, its law counts by how long a frame lasts, or no camera of 10 Hz would ever turn where
few people are seen. Or the vehicle stands, and F, S and ω are nearly 0 (normal).
A pedestrian is one more walker (`joint_map.motion.walks`) with a head (`joint_map.motion.heads`).
"""

from math import lgamma, log, pi
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, strays
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, innovation

LAWS = FOLLOWERS + 2
"""Vehicle, heads that follow, and the head that wanders."""

VEHICLE = 0


class Observer(NamedTuple):
    """The laws' numbers.

    Attributes
    ----------
    change, nu : [3] scales in m, m and rad of changes of F, S and ω from frame to frame, and degrees of freedom.
    normalisers : [3] −ln of their densities at 0, for scales of 1.
    level, swing, drag : [3] scales of S, ω and ‖step‖, in m, rad and m; and the weights of the last two.
    pace : standard deviation in m of a component of the first step.
    walk : of a pedestrian, with the head.
    odds : [4] ln of how probable each law is at first.
    still : [2] standard deviations in m and rad of a step and of a turn of a vehicle that stands.
    leaving : how probable it is that a vehicle that stands moves in the next frame, or the other way.
    backing : in 1/m², how much half the square of a step backwards counts; 0 unless the start is cold.
    going : of so many newest frames it is taken for granted that a vehicle moves; 0 unless `Tracking` tries this.
    """

    change: FloatArray
    nu: FloatArray
    normalisers: FloatArray
    level: FloatArray
    swing: float
    drag: float
    pace: float
    walk: Walk
    odds: FloatArray
    still: FloatArray
    leaving: float
    backing: float
    going: int


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
    add_pedestrian_deviances(frames, t, observer, told)


@kernel
def surprises(frames: FloatArray, free: BoolArray, until: int, observer: Observer) -> FloatArray:
    """`surprise` [4] of the steps into all ``free`` frames before the frame ``until``."""
    told = np.zeros(LAWS)
    for t in range(2, until):
        if free[t]:
            surprise(frames, t, observer, told)
    return told


@kernel
def moving_deviance(frames: FloatArray, t: int, observer: Observer) -> float:
    """−ln of the density of the step into frame ``t`` ≥ 1 of a vehicle that moves, given the one before."""
    now, total = step_of(frames[t - 1], frames[t]), least_deviance(t, observer)
    if t == 1:
        total += 0.5 * (now.forward**2 + now.right**2) / observer.pace**2
        return float(total + observer.swing * np.log(1.0 + (now.turned / observer.level[1]) ** 2))
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
def add_pedestrian_deviances(frames: FloatArray, t: int, observer: Observer, told: FloatArray) -> None:
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
