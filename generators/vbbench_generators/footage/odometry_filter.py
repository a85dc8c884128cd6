"""How a robot moved, by its wheels and its gyro: an extended Kalman filter of planar pose and velocities.

The state is the pose (x, y, yaw) since frame 0, the motion (forward, left, turn) since the frame before, the speeds
(v, ω), the gyro's bias b, and how much the wheels slip, as shares s of the speed and k of the turning rate:

    x' = x + v Δt cos(yaw + ωΔt/2),  y' = y + v Δt sin(yaw + ωΔt/2),  yaw' = yaw + ωΔt   (the motion likewise)
    v, ω, b: random walks;   s, k: fade with e^(−Δt/τ) and are renewed at the rate that keeps their spread
    wheels: (1 + s) v and (1 + k) ω;   gyro: ω + b

Slip that lasts is thereby part of the covariance, although nothing here measures it; a reading that jumps (a wheel that
spins) counts less, by the weight of a Student-t error. (Thrun, Burgard, Fox, *Probabilistic Robotics*, 2005, ch. 3, 5.)
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray, freeze
from vbbench.kernels import kernel
from vbbench.sequence import Odometry

SPEED, TURN, GYRO, FRAME = 0, 1, 2, 3
"""Kinds of readings; a frame is the moment at which pose and motion are wanted."""


@dataclass(frozen=True, kw_only=True)
class Readings:
    """What a sensor said and when.

    Parameters
    ----------
    times : [N] s, ascending.
    values : [N] m/s or rad/s.
    """

    times: FloatArray
    values: FloatArray

    def __post_init__(self) -> None:
        freeze(self, times=(None,))
        freeze(self, values=(len(self.times),))

    def earlier(self, seconds: float) -> "Readings":
        """The same, had the sensor's clock been set back."""
        return Readings(times=self.times - seconds, values=self.values)


class RobotNoise(NamedTuple):
    """Standard deviations of what the filter expects, of a robot on two driven wheels.

    Attributes
    ----------
    readings : of `SPEED`, `TURN` and `GYRO`, in m/s, rad/s, rad/s.
    acceleration, turn_acceleration : random walks of v and ω, in m/s and rad/s after a second.
    sideways : how far the robot is pushed aside in a metre of driving, in m.
    bias, bias_drift : of the gyro at first and after a second, in rad/s.
    slips : shares of speed and turning rate that the wheels get wrong.
    slip_seconds : τ, how long they stay so.
    freedom : degrees of freedom ν of the Student-t error of a reading.
    """

    readings: tuple[float, float, float] = (0.02, 0.03, 0.01)
    acceleration: float = 0.4
    turn_acceleration: float = 1.0
    sideways: float = 0.01
    bias: float = 0.02
    bias_drift: float = 2e-4
    slips: tuple[float, float] = (0.018, 0.1)
    slip_seconds: float = 10.0
    freedom: float = 4.0


@dataclass(frozen=True, kw_only=True)
class RobotMotion:
    """Where the robot was.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) in m and rad, from (0, 0, 0) at frame 0.
    covariances : [T, 3, 3] of these.
    odometry : the motion from each frame to the next.
    """

    poses: FloatArray
    covariances: FloatArray
    odometry: Odometry


def filter_motion(frames: FloatArray, speed: Readings, turn: Readings, gyro: Readings | None) -> RobotMotion:
    """Where the robot was at the times ``frames`` [T], each from readings up to then.

    Parameters
    ----------
    frames : in s, ascending, of the same clock as the readings.
    speed, turn : the wheels' forward speed and turning rate.
    gyro : turning rate about the vertical axis; ``None`` where there is no gyro.
    """
    sources = [speed, turn, gyro or Readings(times=np.empty(0), values=np.empty(0))]
    times = np.concatenate([*(one.times for one in sources), frames])
    values = np.concatenate([*(one.values for one in sources), np.zeros(len(frames))])
    kinds = np.repeat([SPEED, TURN, GYRO, FRAME], [*(len(one.times) for one in sources), len(frames)])
    order = np.lexsort((kinds, times))
    ordered = times[order], values[order], kinds[order]
    poses, covariances, motions, spreads = _filter(*ordered, len(frames), RobotNoise())
    motions[0], spreads[0] = np.nan, np.nan
    return RobotMotion(poses=poses, covariances=covariances, odometry=Odometry(motions=motions, covariances=spreads))


_SIZE = 11
_YAW, _MOVED, _V, _W, _BIAS, _SLIP, _TURN_SLIP = 2, 3, 6, 7, 8, 9, 10
"""Places in the state: x, y, yaw; forward, left, turn; v, ω, b, s, k."""


@kernel
def _filter(
    times: FloatArray, values: FloatArray, kinds: IntArray, frames: int, noise: RobotNoise
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Pose [T, 3], its covariance, and motion since the frame before with its covariance, at the readings `FRAME`."""
    poses, covariances = np.empty((frames, 3)), np.empty((frames, 3, 3))
    motions, spreads = np.empty((frames, 3)), np.empty((frames, 3, 3))
    state, spread = np.zeros(_SIZE), np.zeros((_SIZE, _SIZE))
    spread[_V, _V], spread[_W, _W], spread[_BIAS, _BIAS] = 1.0, 1.0, noise.bias**2  # up to 1 m/s and 1 rad/s or so
    spread[_SLIP, _SLIP], spread[_TURN_SLIP, _TURN_SLIP] = noise.slips[0] ** 2, noise.slips[1] ** 2
    frame = 0
    for i in range(len(times)):
        if i > 0 and times[i] > times[i - 1]:
            spread = _predict(state, spread, times[i] - times[i - 1], noise)
        if kinds[i] != FRAME:
            _update(state, spread, kinds[i], values[i], noise)
            continue
        if frame == 0:
            _begin_here(state, spread, 0)
        for a in range(_MOVED):
            poses[frame, a], motions[frame, a] = state[a], state[_MOVED + a]
            for b in range(_MOVED):
                covariances[frame, a, b], spreads[frame, a, b] = spread[a, b], spread[_MOVED + a, _MOVED + b]
        _begin_here(state, spread, _MOVED)
        frame += 1
    return poses, covariances, motions, spreads


@kernel
def _predict(state: FloatArray, spread: FloatArray, dt: float, noise: RobotNoise) -> FloatArray:
    """Move the state ``dt`` seconds on; its covariance then: F P Fᵀ + Q with F = ``change``."""
    change = np.zeros((_SIZE, _SIZE))
    for a in range(_SIZE):
        change[a, a] = 1.0
    v, w, stays = state[_V], state[_W], np.exp(-dt / noise.slip_seconds)
    for first in range(0, _V, _MOVED):
        yaw = state[first + 2] + 0.5 * w * dt
        ahead, aside = dt * np.cos(yaw), dt * np.sin(yaw)
        state[first] += v * ahead
        state[first + 1] += v * aside
        state[first + 2] += w * dt
        change[first, first + 2], change[first + 1, first + 2] = -v * aside, v * ahead
        change[first, _V], change[first + 1, _V] = ahead, aside
        change[first, _W], change[first + 1, _W] = -0.5 * v * dt * aside, 0.5 * v * dt * ahead
        change[first + 2, _W] = dt
    for slip in range(_SLIP, _SIZE):
        state[slip] *= stays
        change[slip, slip] = stays
    carried = _product(_product(change, spread), change.T)
    _add_noise(state, carried, dt, stays, noise)
    return carried


@kernel
def _product(first: FloatArray, second: FloatArray) -> FloatArray:
    """The product of two matrices, with sums in one order on every machine."""
    product = np.zeros((_SIZE, _SIZE))
    for a in range(_SIZE):
        for b in range(_SIZE):
            for c in range(_SIZE):
                product[a, b] += first[a, c] * second[c, b]
    return product


@kernel
def _add_noise(state: FloatArray, spread: FloatArray, dt: float, stays: float, noise: RobotNoise) -> None:
    """Q: random walks of v, ω and b, the renewal of the slips, and motion sideways, equal in pose and motion."""
    spread[_V, _V] += noise.acceleration**2 * dt
    spread[_W, _W] += noise.turn_acceleration**2 * dt
    spread[_BIAS, _BIAS] += noise.bias_drift**2 * dt
    for slip in range(2):
        spread[_SLIP + slip, _SLIP + slip] += noise.slips[slip] ** 2 * (1.0 - stays * stays)
    aside = np.zeros(_SIZE)
    for first in range(0, _V, _MOVED):
        aside[first], aside[first + 1] = np.sin(state[first + 2]), -np.cos(state[first + 2])
    push = noise.sideways**2 * abs(state[_V]) * dt
    for a in range(_SIZE):
        for b in range(_SIZE):
            spread[a, b] += push * aside[a] * aside[b]


@kernel
def _update(state: FloatArray, spread: FloatArray, kind: int, value: float, noise: RobotNoise) -> None:
    """Take one reading in; one that lies far off counts as less certain."""
    rate = _V if kind == SPEED else _W
    if kind == GYRO:
        other, by_rate, by_other = _BIAS, 1.0, 1.0
        expected = state[_W] + state[_BIAS]
    else:
        other = _SLIP if kind == SPEED else _TURN_SLIP
        by_rate, by_other = 1.0 + state[other], state[rate]
        expected = by_rate * state[rate]
    gain = np.empty(_SIZE)
    for a in range(_SIZE):
        gain[a] = spread[a, rate] * by_rate + spread[a, other] * by_other
    certain = gain[rate] * by_rate + gain[other] * by_other
    off, variance = value - expected, noise.readings[kind] ** 2
    variance *= max(1.0, (noise.freedom + off * off / (certain + variance)) / (noise.freedom + 1.0))
    for a in range(_SIZE):
        state[a] += gain[a] / (certain + variance) * off
        for b in range(_SIZE):
            spread[a, b] -= gain[a] * gain[b] / (certain + variance)


@kernel
def _begin_here(state: FloatArray, spread: FloatArray, first: int) -> None:
    """Set pose or motion to exactly 0."""
    for a in range(first, first + 3):
        state[a] = 0.0
        for b in range(_SIZE):
            spread[a, b], spread[b, a] = 0.0, 0.0


STEP, WIDEST, LEAST_TURN, LEAST_LIKENESS = 0.01, 0.5, 0.03, 0.6
"""Seconds between compared times and of the largest offset; rad/s that must be turned; the least correlation."""


def clock_offset(reference: Readings, other: Readings, widest: float = WIDEST) -> float | None:
    """By how many seconds the clock of ``other`` is ahead, from turning rates that both measured.

    Found where the two are most alike, up to ``widest`` seconds. ``None`` if the robot hardly turned, or they are never
    alike.
    """
    first = max(reference.times[0], other.times[0]) + widest
    grid = np.arange(first, min(reference.times[-1], other.times[-1]) - widest, STEP)
    if len(grid) * STEP < 2 * widest:
        return None
    known = np.interp(grid, reference.times, reference.values)
    if known.std() < LEAST_TURN:
        return None
    lags = np.arange(-round(widest / STEP), round(widest / STEP) + 1) * STEP
    likeness = np.array([_correlation(known, np.interp(grid + lag, other.times, other.values)) for lag in lags])
    best = int(likeness.argmax())
    if likeness[best] < LEAST_LIKENESS or best in (0, len(lags) - 1):
        return None
    before, top, after = likeness[best - 1 : best + 2]
    return float(lags[best] + 0.5 * STEP * (before - after) / (before - 2.0 * top + after))


def _correlation(first: FloatArray, second: FloatArray) -> float:
    first, second = first - first.mean(), second - second.mean()
    lengths = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(first @ second) / max(lengths, 1e-12)
