"""What JRDB's robot measured of its own motion, from its rosbag: the speeds of its wheels, and its gyro."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchError, needs_extra
from vbbench.geometry import FloatArray, wrap_angle
from vbbench_generators.footage.odometry_filter import Readings

WHEELS = ("segway/feedback/wheel_odometry", "segway/odometry/local_filtered")
"""Topics of nav_msgs/Odometry, the better one first; names may begin with a slash."""

_ODOMETRY, _IMU = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu"
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
        raise FileError(path, f"has no message of {' or '.join(WHEELS)}: nothing tells how the robot moved")
    times = _checked_times(path, wheels)
    table = _finite(path, wheels)
    twist, pose = table[:, :2], table[:, 2:]
    if np.abs(twist).max() < _NOTHING and np.ptp(pose, axis=0).max() > _NOTHING:
        times, twist = speeds_of(times, pose)
    fastest = float(np.abs(twist).max())
    if fastest > _FASTEST:
        raise FileError(path, f"{wheels.name} tells of {fastest:,.0f} m/s or rad/s; no robot is so fast")
    speed = Readings(times=times, values=twist[:, 0])
    return BagReadings(path=path, speed=speed, turn=Readings(times=times, values=twist[:, 1]), gyro=_gyro(path, imu))


@dataclass(frozen=True)
class _Topic:
    """Messages of one topic: times in s by the sensor's and by the recorder's clock, and numbers."""

    name: str
    stamps: list[float]
    recorded: list[float]
    rows: list[list[float]]


def _messages(path: Path) -> tuple[_Topic, _Topic]:
    """The messages of the wheels and of the fullest IMU topic."""
    with needs_extra("robot", "reading a robot's motion (--bags)"):
        from rosbags.rosbag1 import Reader
        from rosbags.typesys import Stores, get_typestore
    types = get_typestore(Stores.ROS1_NOETIC)
    try:
        with Reader(path) as bag:
            if not bag.message_count:
                raise FileError(path, "is an empty bag: it holds no message")
            wheels, imu = _find(bag.connections)
            found = {name: _Topic(name, [], [], []) for name in (wheels, imu) if name is not None}
            read = [one for one in bag.connections if one.topic.strip("/") in found]
            for connection, recorded, raw in bag.messages(connections=read) if read else ():
                message = types.deserialize_ros1(raw, connection.msgtype)
                topic, stamp = found[connection.topic.strip("/")], message.header.stamp
                topic.stamps.append(stamp.sec + 1e-9 * stamp.nanosec)
                topic.recorded.append(1e-9 * recorded)
                topic.rows.append(_odometry(message) if topic.name == wheels else _imu(message))
    except VbbenchError:
        raise
    except Exception as error:  # whatever rosbags raises on damaged bytes
        raise FileError(path, f"is no whole ROS 1 bag: {error}") from error
    nothing = _Topic("", [], [], [])
    return found.get(wheels or "", nothing), found.get(imu or "", nothing)


def _find(connections: Any) -> tuple[str | None, str | None]:
    """The topic of the wheels, and that of the IMU with the most messages; ``None`` where there is none.

    A topic has one connection for each program that wrote it, and two if its driver was started again.
    """
    counts: dict[str, Counter[str]] = {_ODOMETRY: Counter(), _IMU: Counter()}
    for one in connections:
        if one.msgtype in counts:
            counts[one.msgtype][one.topic.strip("/")] += int(one.msgcount)
    wheels = next((name for name in WHEELS if counts[_ODOMETRY][name]), None)
    return wheels, next((name for name, count in counts[_IMU].most_common(1) if count), None)


def _odometry(message: Any) -> list[float]:
    """(speed, turning rate, x, y, yaw)."""
    twist, pose, turned = message.twist.twist, message.pose.pose.position, message.pose.pose.orientation
    yaw = np.arctan2(
        2.0 * (turned.w * turned.z + turned.x * turned.y), 1.0 - 2.0 * (turned.y * turned.y + turned.z * turned.z)
    )
    return [twist.linear.x, twist.angular.z, pose.x, pose.y, float(yaw)]


def _imu(message: Any) -> list[float]:
    """Turning rates and accelerations about and along x, y, z."""
    rates, pull = message.angular_velocity, message.linear_acceleration
    return [rates.x, rates.y, rates.z, pull.x, pull.y, pull.z]


def _checked_times(path: Path, topic: _Topic) -> FloatArray:
    """[N] by the sensor's clock where it has one, else by the recorder's; a clock that jumps is refused."""
    times = np.array(topic.stamps if all(topic.stamps) else topic.recorded)
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
