"""A robot that drives among people where one of them walked, carries the camera, and measures its own motion.

It follows that person as a vehicle on two driven wheels does: it turns towards where the person is a moment later, and
is slow where it has to turn far. Its wheels slip and its gyro has a bias; `filter_motion` makes odometry of both, which
solvers get, while truth is where the robot really was.
"""

from dataclasses import dataclass
from functools import cache
from typing import Annotated

import numpy as np

from vbbench.geometry import FloatArray, wrap_angle
from vbbench.parsing.numbers import Share, Within, check_ranges
from vbbench.parsing.toml_text import read_bundled
from vbbench.sequence import Odometry
from vbbench_generators import _core
from vbbench_generators.footage.odometry_filter import Readings, filter_motion

STEP = 0.005
"""Seconds of a step of the drive."""
WHEELS_EVERY, GYRO_EVERY = 4, 10
"""Steps from a reading of the wheels, and of the gyro, to the next."""
SPIN_STEPS = 60
"""Steps for which a wheel spins."""

Positive = Annotated[float, Within(1e-3, 1e3)]


@dataclass(frozen=True, kw_only=True)
class RobotModel:
    """The file ``robot.toml``, which says what each value is."""

    top_speed: Positive
    acceleration: Positive
    turn_rate: Positive
    turn_time: Positive
    lead: Positive
    speed_slip: Share
    turn_slip: Share
    slip_time: Positive
    spins: Annotated[float, Within(0.0, 1e3)]
    gyro_bias: Share
    wheel_std: Share
    gyro_std: Share

    def __post_init__(self) -> None:
        check_ranges(self)


@cache
def get_robot() -> RobotModel:
    """The model that comes with this package."""
    return read_bundled("vbbench_generators", "views/robot.toml", RobotModel, "top level")


@dataclass(frozen=True)
class Drive:
    """A robot's way.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) in m and rad.
    odometry : the motion from frame to frame by wheels and gyro.
    """

    poses: FloatArray
    odometry: Odometry


def follow(walk: FloatArray, dt: float, rng: np.random.Generator) -> Drive:
    """The drive of a robot that follows a person.

    Parameters
    ----------
    walk : [T, 2] in m where the person is, ``dt`` seconds apart.
    """
    model = get_robot()
    times = np.asarray(STEP * np.arange(round((len(walk) - 1) * dt / STEP) + 1), np.float64)
    frames = np.asarray(dt * np.arange(len(walk)), np.float64)
    ahead = times + model.lead
    goals = np.stack([np.interp(ahead, frames, axis) for axis in walk.T], axis=-1)
    names = ("top_speed", "acceleration", "turn_rate", "turn_time", "lead")
    way = _core.steer(goals, walk[0], **{name: getattr(model, name) for name in names}, step=STEP)
    speed, turn, gyro = sense(times, way[:, 3], way[:, 4], model, rng.normal(0.0, model.gyro_bias), rng)
    measured = filter_motion(frames, speed, turn, gyro)
    poses = way[np.rint(frames / STEP).astype(int), :3]
    poses[:, 2] = wrap_angle(poses[:, 2])
    return Drive(poses=poses, odometry=measured.odometry)


def sense(
    times: FloatArray, speed: FloatArray, turn: FloatArray, model: RobotModel, bias: float, rng: np.random.Generator
) -> tuple[Readings, Readings, Readings]:
    """What wheels say of speed and turning rate, and what the gyro says of the latter.

    Parameters
    ----------
    times : [N] s, `STEP` apart.
    speed, turn : [N] what is true, in m/s and rad/s.
    bias : of the gyro in rad/s.
    """
    wheels = speed * (1.0 + changing(rng, len(times), model.speed_slip, model.slip_time))
    spins = round(model.spins * len(times) * STEP / 60.0)
    for first in rng.integers(0, len(times), spins):
        wheels[first : first + SPIN_STEPS] *= rng.uniform(1.1, 1.4)
    turning = turn * (1.0 + changing(rng, len(times), model.turn_slip, model.slip_time))
    gyro = turn + bias + rng.normal(0.0, model.gyro_std, len(times))
    often, seldom = slice(None, None, WHEELS_EVERY), slice(None, None, GYRO_EVERY)
    said = [(one + rng.normal(0.0, model.wheel_std, len(times)))[often] for one in (wheels, turning)]
    return (
        Readings(times=times[often], values=said[0]),
        Readings(times=times[often], values=said[1]),
        Readings(times=times[seldom], values=gyro[seldom]),
    )


def changing(rng: np.random.Generator, count: int, spread: float, seconds: float) -> FloatArray:
    """[N] numbers of this spread about 0, `STEP` apart, that change smoothly within ``seconds``."""
    knots = rng.normal(0.0, 1.0, len(np.arange(-2.0, count * STEP / seconds + 3.0)))
    at = np.arange(count) * STEP / seconds
    first, part = np.floor(at).astype(int) + 2, at - np.floor(at)
    weight = part * part * (3.0 - 2.0 * part)
    mixed = (1.0 - weight) * knots[first] + weight * knots[first + 1]
    numbers: FloatArray = spread * mixed / np.sqrt(np.mean((1.0 - weight) ** 2 + weight**2))
    return numbers
