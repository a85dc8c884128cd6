"""An extended Kalman filter of a robot's planar pose and velocities, from its wheels and gyro.

The state is the pose (x, y, yaw) since frame 0, the motion (forward, left, turn) since the frame before, the speeds
(v, ω), the gyro's bias b, and the wheels' slip, as shares s of the speed and k of the turning rate:

    x' = x + v Δt cos(yaw + ωΔt/2),  y' = y + v Δt sin(yaw + ωΔt/2),  yaw' = yaw + ωΔt   (the motion likewise)
    v, ω, b: random walks;   s, k: stationary Ornstein–Uhlenbeck processes of the correlation time τ
    wheels: (1 + s) v and (1 + k) ω;   gyro: ω + b

Correlated slip is thereby part of the covariance, although no sensor measures it. Outliers (a wheel that spins) have
less weight, by a Student-t likelihood. (Thrun, Burgard, Fox, *Probabilistic Robotics*, 2005, ch. 3, 5.) The model's
standard deviations stand in ``cpp/odometry.hpp``.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, freeze
from vbbench.sequence import Odometry
from vbbench_generators import _core

SPEED, TURN, GYRO, FRAME = 0, 1, 2, 3
"""Kinds of readings; a frame is the moment at which pose and motion are wanted."""


@dataclass(frozen=True, kw_only=True)
class Readings:
    """Readings of a sensor.

    Parameters
    ----------
    times : [N] in s, ascending.
    values : [N] in m/s or rad/s.
    """

    times: FloatArray
    values: FloatArray

    def __post_init__(self) -> None:
        freeze(self, times=(None,))
        freeze(self, values=(len(self.times),))

    def earlier(self, seconds: float) -> "Readings":
        """The readings with times ``seconds`` earlier."""
        return Readings(times=self.times - seconds, values=self.values)


@dataclass(frozen=True, kw_only=True)
class RobotMotion:
    """The filtered motion of a robot.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) in m and rad, from (0, 0, 0) at frame 0.
    covariances : [T, 3, 3] covariances of the poses.
    odometry : the motion from each frame to the next.
    """

    poses: FloatArray
    covariances: FloatArray
    odometry: Odometry

    @property
    def distance(self) -> float:
        """Distance driven, in m."""
        return float(np.linalg.norm(np.diff(self.poses[:, :2], axis=0), axis=1).sum())

    @property
    def end_std(self) -> float:
        """Standard deviation in m of the last place, on the less certain axis."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariances[-1, :2, :2])[-1]))


def filter_motion(frames: FloatArray, speed: Readings, turn: Readings, gyro: Readings | None) -> RobotMotion:
    """Filter the robot's poses at the times ``frames`` [T], each by the readings up to it.

    Parameters
    ----------
    frames : [T] in s, ascending, of the same clock as the readings.
    speed, turn : the wheels' forward speed and turning rate.
    gyro : turning rate about the vertical axis; ``None`` where there is no gyro.
    """
    sources = [speed, turn, gyro or Readings(times=np.empty(0), values=np.empty(0))]
    times = np.concatenate([*(one.times for one in sources), frames])
    values = np.concatenate([*(one.values for one in sources), np.zeros(len(frames))])
    kinds = np.repeat([SPEED, TURN, GYRO, FRAME], [*(len(one.times) for one in sources), len(frames)])
    order = np.lexsort((kinds, times))
    poses, covariances, motions, spreads = _core.filter_readings(times[order], values[order], kinds[order])
    motions[0], spreads[0] = np.nan, np.nan
    return RobotMotion(poses=poses, covariances=covariances, odometry=Odometry(motions=motions, covariances=spreads))


STEP, WIDEST, LEAST_TURN, LEAST_LIKENESS = 0.01, 0.5, 0.03, 0.6
"""Seconds between compared times and of the largest offset; rad/s that must be turned; the least correlation."""


def clock_offset(reference: Readings, other: Readings, widest: float = WIDEST) -> float | None:
    """Offset in s by which the clock of ``other`` is ahead, from turning rates that both measured.

    It maximises the correlation of the two, up to ``widest`` seconds. ``None`` if the robot hardly turned, or the
    correlation is low.
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
