"""What all steps of the camera tell of the laws by which it moves, and of when its vehicle stands.

One law m holds all the time, so that all steps together tell which: with E_m the sum of −ln of the densities of the
steps under it, and o_m what earlier frames added, π_m ∝ p_m exp(o_m − E_m), and each law counts by its share π_m: a
step of expectation and maximisation.
A vehicle goes on as it does, moving or standing, for some seconds, and the highest density of either is the same: where
nothing is seen, a vehicle that moves is not taken to stop because that would be more certain. Both states are weighed
in each frame by all frames.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.real_camera.observer import (
    LAWS,
    VEHICLE,
    Observer,
    add_pedestrian_deviances,
    least_deviance,
    moving_deviance,
    standing_deviance,
)

RULED_OUT = 1e3
"""A deviance of what cannot be."""

MOST = 700.0
"""The largest number of which eˣ is taken."""


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
            add_pedestrian_deviances(frames, t, observer, told)
    for law in range(LAWS):
        least = min(least, told[law])
    for law in range(LAWS):
        shares[law] = np.exp(least - told[law])
        total += shares[law]
    for law in range(LAWS):
        shares[law] /= total
    return Shares(shares, standing, least - np.log(total))


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
