"""What JRDB's robot measured of its motion, from its rosbag: the speeds of its wheels, and its gyro."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.bags import IMU, ODOMETRY, open_bag, yaw_of
from vbbench.geometry import FloatArray, wrap_angle
from vbbench_generators.footage.odometry_filter import Readings

WHEELS = ("segway/feedback/wheel_odometry", "segway/odometry/local_filtered")
"""Topics of nav_msgs/Odometry, the better one first; names may begin with a slash."""

_LONGEST_GAP = 1.0
_NOTHING = 1e-9
_FASTEST = 30.0
_MOST = 1e9
_GRAVITY = (8.0, 12.0)


@dataclass(frozen=True, kw_only=True)
class BagReadings:
    """What a bag holds.

    Parameters
    ----------
    path : the file.
    speed, turn : the wheels' forward speed in m/s and turning rate in rad/s.
    gyro : turning rate about the vertical axis in rad/s; ``None`` where there is no gyro.
    """

    path: Path
    speed: Readings
    turn: Readings
    gyro: Readings | None


def read_bag(path: Path) -> BagReadings:
    """Read wheels and gyro of one ROS 1 bag.

    Raises
    ------
    MissingExtraError
        If the package rosbags is not installed.
    FileError
        If it is no bag, is empty, has no wheel odometry, or its clock jumps.
    """
    wheels, imu = _messages(path)
    if not wheels.rows:
        raise FileError(path, f"has no message of {' or '.join(WHEELS)}: the robot's motion is not recorded")
    times = _checked_times(path, wheels)
    table = _finite(path, wheels)
    twist, pose = table[:, :2], table[:, 2:]
    if np.abs(twist).max() < _NOTHING and np.ptp(pose, axis=0).max() > _NOTHING:
        times, twist = speeds_of(times, pose)
    fastest = float(np.abs(twist).max())
    if fastest > _FASTEST:
        raise FileError(path, f"{wheels.name} has {fastest:,.0f} m/s or rad/s; no robot is so fast")
    speed = Readings(times=times, values=twist[:, 0])
    return BagReadings(path=path, speed=speed, turn=Readings(times=times, values=twist[:, 1]), gyro=_gyro(path, imu))


@dataclass(frozen=True)
class _Topic:
    """Messages of one topic: times in s, and numbers."""

    name: str
    times: list[float]
    rows: list[list[float]]


def _messages(path: Path) -> tuple[_Topic, _Topic]:
    """The messages of the wheels and of the fullest IMU topic; a topic without a name where there is none."""
    with open_bag(path, "reading a robot's motion (--bags)") as bag:
        if not any(bag.counts.values()):
            raise FileError(path, "is an empty bag: it holds no message")
        driven = bag.topics_of(ODOMETRY)
        wheels = _Topic(next((name for name in WHEELS if name in driven), ""), [], [])
        imu = _Topic(next(iter(bag.topics_of(IMU)), ""), [], [])
        for message in bag.messages(wheels.name, imu.name):
            topic = wheels if message.topic == wheels.name else imu
            topic.times.append(message.time)
            topic.rows.append(_odometry(message.fields) if topic is wheels else _imu(message.fields))
    return wheels, imu


def _odometry(message: Any) -> list[float]:
    """(speed, turning rate, x, y, yaw)."""
    twist, pose = message.twist.twist, message.pose.pose
    return [twist.linear.x, twist.angular.z, pose.position.x, pose.position.y, yaw_of(pose.orientation)]


def _imu(message: Any) -> list[float]:
    """Turning rates and accelerations about and along x, y, z."""
    rates, pull = message.angular_velocity, message.linear_acceleration
    return [rates.x, rates.y, rates.z, pull.x, pull.y, pull.z]


def _checked_times(path: Path, topic: _Topic) -> FloatArray:
    """[N] in s; a clock that jumps is refused."""
    times = np.array(topic.times)
    passed = np.diff(times)
    bad = (passed < 0.0) | (passed > _LONGEST_GAP)
    if bad.any():
        row = int(bad.argmax())
        raise FileError(path, f"the clock of {topic.name} jumps by {passed[row]:+.3f} s after message {row + 1}")
    return times


def _finite(path: Path, topic: _Topic) -> FloatArray:
    table = np.array(topic.rows)
    bad = ~(np.abs(table) < _MOST).all(axis=1)
    if bad.any():
        raise FileError(path, f"message {int(bad.argmax()) + 1} of {topic.name} holds what is no plausible number")
    return table


def speeds_of(times: FloatArray, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """[N − 1] times and [N − 1, 2] speeds between poses (x, y, yaw), of a robot that reports no speed."""
    passed = np.maximum(np.diff(times), 1e-6)
    turned = wrap_angle(np.diff(pose[:, 2]))
    heading = pose[:-1, 2] + 0.5 * turned
    moved = np.diff(pose[:, :2], axis=0)
    ahead = np.cos(heading) * moved[:, 0] + np.sin(heading) * moved[:, 1]
    return times[:-1] + 0.5 * passed, np.stack([ahead, turned], axis=-1) / passed[:, None]


def _gyro(path: Path, imu: _Topic) -> Readings | None:
    """Turning rate about the vertical: however the IMU is mounted, the mean acceleration points upwards."""
    if not imu.rows:
        return None
    times, table = _checked_times(path, imu), _finite(path, imu)
    pull = table[:, 3:].mean(axis=0)
    strength = float(np.linalg.norm(pull))
    up = pull / strength if _GRAVITY[0] < strength < _GRAVITY[1] else np.array([0.0, 0.0, 1.0])
    return Readings(times=times, values=table[:, :3] @ up)
