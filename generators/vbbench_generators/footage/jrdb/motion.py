"""Poses of JRDB's robot at its pictures, and odometry by its wheels.

Truth is filtered from wheels and gyro, odometry from the wheels alone: a robot's odometry is rarely better, and a
solver that repeats it does not repeat the truth. Both share the wheels' error of the distance.

Times of JRDB's pictures and point clouds: ``timestamps/NAME/frames_img.json`` and ``frames_pc.json``.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchWarning, quoted
from vbbench.exchange.bags import IMU, ODOMETRY, Bag, open_bag, yaw_of
from vbbench.geometry import BoolArray, FloatArray, IntArray, moved_as_one, wrap_angle
from vbbench.parsing.json_text import read_object
from vbbench.sequence import Odometry
from vbbench_generators.footage.jrdb.labels import frame_of, read_frames
from vbbench_generators.footage.odometry_filter import Readings, RobotMotion, clock_offset, filter_motion

RATE = 15.0
"""Pictures a second, nominally."""

PICTURES, CLOUDS = "frames_img.json", "frames_pc.json"
_LISTS = {PICTURES: ("cameras", "stitched"), CLOUDS: ("pointclouds", "upper")}


@dataclass(frozen=True, kw_only=True)
class Stamps:
    """Times of numbered frames.

    Parameters
    ----------
    frames : [N] numbers, ascending.
    times : [N] in s, ascending.
    """

    path: Path
    frames: IntArray
    times: FloatArray

    def between(self, first: int, last: int) -> "Stamps":
        """The times of frames ``first`` to ``last``, both included."""
        kept = slice(*np.searchsorted(self.frames, [first, last + 1]))
        return Stamps(path=self.path, frames=self.frames[kept], times=self.times[kept])


@dataclass(frozen=True, kw_only=True)
class Grid:
    """A regular grid of slots, 1/15 s apart, with the frames of a recording; some slots may be empty.

    Parameters
    ----------
    frames : [N] numbers of the recording's frames, ascending.
    slots : [N] slot of each frame.
    times : [T] times of all slots in s.
    """

    frames: IntArray
    slots: IntArray
    times: FloatArray

    @property
    def seconds(self) -> float:
        """Measured seconds from one slot of the grid to the next."""
        return float((self.times[-1] - self.times[0]) / max(len(self.times) - 1, 1))

    def slot_of(self, frames: IntArray) -> IntArray:
        """[M] slots of numbered frames, −1 where there is none."""
        if not len(self.frames):
            return np.full(len(frames), -1)
        nearest = np.searchsorted(self.frames, frames).clip(max=len(self.frames) - 1)
        return np.where(self.frames[nearest] == frames, self.slots[nearest], -1)


def nominal_stamps(path: Path, frames: IntArray) -> Stamps:
    """Times of frames exactly at `RATE`, for a recording without times."""
    return Stamps(path=path, frames=frames, times=frames / RATE)


def lay_out(stamps: Stamps) -> Grid:
    """Put frames on slots by their times."""
    if len(stamps.frames) < 2:
        raise FileError(stamps.path, f"stamps {len(stamps.frames)} of the labelled frames; two at least are wanted")
    passed = np.diff(stamps.times)
    common = float(np.median(passed))
    step = max(1, round(common * RATE))
    if abs(common * RATE / step - 1.0) > _DRIFT:
        raise FileError(stamps.path, f"frames are {common:.4f} s apart, which is no multiple of 1/{RATE:.0f} s")
    slots = np.concatenate([[0], np.cumsum(np.maximum(1, np.rint(passed / (common / step)).astype(np.int64)))])
    times = np.interp(np.arange(slots[-1] + 1), slots, stamps.times)
    return Grid(frames=stamps.frames, slots=slots, times=times)


def read_stamps(folder: Path, name: str) -> Stamps:
    """The times in one of the two files in ``timestamps/NAME``."""
    path = folder / name
    rows = read_object(path, "download JRDB's timestamps next to the labels").get("data")
    if not isinstance(rows, list) or not rows:
        raise FileError(path, "has no list 'data' with an object for each frame")
    found = dict(_stamp(path, number, row, name) for number, row in enumerate(rows, 1))
    if len(found) < len(rows):
        raise FileError(path, f"has {len(rows)} entries of {len(found)} frames: a frame stands there twice")
    frames = np.array(sorted(found), np.int64)
    times = np.array([found[frame] for frame in frames.tolist()])
    passed = np.diff(times)
    bad = (passed <= 0.0) | (passed > _LONGEST_GAP)
    if bad.any():
        row = int(bad.argmax())
        problem = f"the clock jumps by {passed[row]:+.3f} s from frame {frames[row]:06d} to the next"
        raise FileError(path, f"{problem}; stamps are in s; exclude this recording with `sequences`")
    return Stamps(path=path, frames=frames, times=times)


def _stamp(path: Path, number: int, row: Any, name: str) -> tuple[int, float]:
    """Number and time of one frame: of the stitched picture, or of the upper lidar's cloud, if they are there."""
    key, wanted = _LISTS[name]
    sensors = row.get(key) if isinstance(row, dict) else None
    usable = isinstance(sensors, list) and all(isinstance(sensor, dict) for sensor in sensors)
    if not sensors or not usable:
        raise FileError(path, f"entry {number} of 'data': key '{key}' is {quoted(sensors)}, not a list of sensors")
    sensor = next((one for one in sensors if wanted in str(one.get("name"))), sensors[0])
    stem = PurePosixPath(str(sensor.get("url"))).stem
    if not (stem.isascii() and stem.isdigit() and len(stem) <= 9):
        raise FileError(path, f"entry {number} of 'data': url is {quoted(sensor.get('url'))}, not …/000000.jpg or .pcd")
    try:
        time = float(sensor.get("timestamp", row.get("timestamp")))
    except (TypeError, ValueError):
        time = np.nan
    if not np.isfinite(time):
        raise FileError(path, f"entry {number} of 'data': key 'timestamp' is missing or no number of seconds")
    return int(stem), time


WHEELS = ("segway/feedback/wheel_odometry", "segway/odometry/local_filtered")
"""Topics of nav_msgs/Odometry, the better one first; names may begin with a slash."""

_LONGEST_GAP = 1.0
_DRIFT = 0.1
_NOTHING = 1e-9
_FASTEST = 30.0
_MOST = 1e9
_GRAVITY = (8.0, 12.0)


def read_bag(path: Path) -> tuple[Readings, Readings, Readings | None]:
    """The wheels' forward speed and turning rate, and the turning rate by the gyro, if there is one, of a ROS 1 bag.

    Raises MissingExtraError if the package rosbags is not installed; FileError if it is no bag, is empty, has no wheel
    odometry, or its clock jumps.
    """
    with open_bag(path, "reading a robot's motion (bags)") as bag:
        if not any(bag.counts.values()):
            raise FileError(path, "is an empty bag: it holds no message")
        driven, imus = bag.topics_of(ODOMETRY), bag.topics_of(IMU)
        wheels = next((name for name in WHEELS if name in driven), None)
        if wheels is None:
            raise FileError(path, f"has no message of {' or '.join(WHEELS)}: the robot's motion is not recorded")
        times, table = _numbers(bag, wheels, _odometry)
        gyro = _gyro(*_numbers(bag, imus[0], _imu)) if imus else None
    twist, pose = table[:, :2], table[:, 2:]
    if np.abs(twist).max() < _NOTHING and np.ptp(pose, axis=0).max() > _NOTHING:
        times, twist = speeds_of(times, pose)
    fastest = float(np.abs(twist).max())
    if fastest > _FASTEST:
        raise FileError(path, f"{wheels} has {fastest:,.0f} m/s or rad/s; no robot is so fast")
    speed, turn = (Readings(times=times, values=values) for values in twist.T)
    return speed, turn, gyro


def _numbers(bag: Bag, topic: str, numbers: Callable[[Any], list[float]]) -> tuple[FloatArray, FloatArray]:
    """Times [N] in s and ``numbers`` [N, C] of the messages of a topic; refuses a clock that jumps."""
    rows = np.array([[message.time, *numbers(message.fields)] for message in bag.messages(topic)])
    times, table = rows[:, 0], rows[:, 1:]
    passed = np.diff(times)
    jumps = (passed < 0.0) | (passed > _LONGEST_GAP)
    if jumps.any():
        row = int(jumps.argmax())
        raise FileError(bag.path, f"the clock of {topic} jumps by {passed[row]:+.3f} s after message {row + 1}")
    bad = ~(np.abs(table) < _MOST).all(axis=1)
    if bad.any():
        raise FileError(bag.path, f"message {int(bad.argmax()) + 1} of {topic} holds what is no plausible number")
    return times, table


def _odometry(message: Any) -> list[float]:
    """Speed in m/s, turning rate in rad/s, and pose (x, y, yaw) of an odometry message."""
    twist, pose = message.twist.twist, message.pose.pose
    return [twist.linear.x, twist.angular.z, pose.position.x, pose.position.y, yaw_of(pose.orientation)]


def _imu(message: Any) -> list[float]:
    """Turning rates in rad/s about x, y, z and accelerations in m/s² along them, of an IMU message."""
    rates, pull = message.angular_velocity, message.linear_acceleration
    return [rates.x, rates.y, rates.z, pull.x, pull.y, pull.z]


def speeds_of(times: FloatArray, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """[N − 1] times and [N − 1, 2] speeds between poses (x, y, yaw), of a robot that reports no speed."""
    passed = np.maximum(np.diff(times), 1e-6)
    turned = wrap_angle(np.diff(pose[:, 2]))
    heading = pose[:-1, 2] + 0.5 * turned
    moved = np.diff(pose[:, :2], axis=0)
    ahead = np.cos(heading) * moved[:, 0] + np.sin(heading) * moved[:, 1]
    return times[:-1] + 0.5 * passed, np.stack([ahead, turned], axis=-1) / passed[:, None]


def _gyro(times: FloatArray, table: FloatArray) -> Readings:
    """Turning rate about the vertical: however the IMU is mounted, the mean acceleration points upwards."""
    pull = table[:, 3:].mean(axis=0)
    strength = float(np.linalg.norm(pull))
    up = pull / strength if _GRAVITY[0] < strength < _GRAVITY[1] else np.array([0.0, 0.0, 1.0])
    return Readings(times=times, values=table[:, :3] @ up)


_LONGEST, _LEVEL = 1e5, 0.2
"""m that a robot may be from where its odometry began, and rad by which it may be off the level (median)."""


def read_odometry_file(path: Path, clouds: Stamps) -> tuple[FloatArray, FloatArray]:
    """Times [N] in s and poses [N, 3] (x, y, yaw) in m and rad, x forward and y left of the robot at yaw 0.

    Parameters
    ----------
    path : the file: a position x, y, z and an orientation x, y, z, w for each point cloud.
    clouds : when the point clouds were taken.
    """
    entries = read_frames(path, "odometry", "poses")
    rows = {frame_of(path, name, ".pcd", "odometry"): _pose(path, name, one) for name, one in sorted(entries.items())}
    kept = [row for row, frame in enumerate(clouds.frames.tolist()) if frame in rows]
    if len(kept) < 2:
        raise FileError(path, f"has poses of {len(kept)} of the point clouds in {clouds.path.name}; two are wanted")
    table = np.array([rows[int(clouds.frames[row])] for row in kept])
    x, y, z, w = (table[:, 3:] / np.linalg.norm(table[:, 3:], axis=1, keepdims=True)).T
    if float(np.median(1.0 - 2.0 * (x * x + y * y))) < np.cos(_LEVEL):
        raise FileError(path, "the robot is not upright: positions and orientations must have z upwards, w last")
    yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    return clouds.times[kept], np.column_stack([table[:, :2], yaw])


def _pose(path: Path, name: str, entry: Any) -> list[float]:
    """The position x, y, z in m and the orientation x, y, z, w of an entry."""
    try:
        numbers = [float(entry["position"][axis]) for axis in "xyz"]
        numbers += [float(entry["orientation"][axis]) for axis in "xyzw"]
    except (KeyError, TypeError, ValueError, OverflowError):
        wanted = "'position' with numbers x, y, z and 'orientation' with x, y, z, w"
        raise FileError(path, f"{name} is {quoted(entry)}, not an object of {wanted}") from None
    if not np.abs(numbers).max() <= _LONGEST:
        raise FileError(path, f"{name}: {max(numbers, key=abs):g} is no number of m; positions are in m")
    if not 0.9 < (length := float(np.linalg.norm(numbers[3:]))) < 1.1:
        raise FileError(path, f"{name}: the orientation's x, y, z, w have length {length:.3g}, not 1")
    return numbers


OFFSET_STD = 0.02
"""s, by which the clocks of bag and pictures may differ still."""

MOST_LATE, WIDEST = 0.1, 2.0
"""s that people may turn around the robot before or after its poses do, and up to which this is tried."""

_SLACK = 0.5
_FEWEST = 3


Offsets = dict[str, float | None]
"""Seconds by which a clock is ahead of the wheels', by its name; ``None`` = not measurable."""


def measure_motion(path: Path, times: FloatArray, places: FloatArray, every: int = 1) -> tuple[RobotMotion, Offsets]:
    """The robot's motion at the times of frames by its sensors, its odometry by the wheels alone, and clocks' offsets.

    Parameters
    ----------
    path : the bag of their readings.
    times : [T] times of the frames in s.
    places : [T, P, 2] people in m forward and left of the robot, NaN = absent. Their apparent rotation gives the offset
        between the clocks of bag and pictures.
    every : one of so many frames will be kept. Slip is correlated in time: covariances of so many consecutive motions
        are scaled to add up to that of the whole motion.
    """
    (speed, turn, gyro), offsets = read_bag(path), Offsets()
    _check_covers(path, speed, times)
    if gyro is not None:
        offsets["gyro"] = clock_offset(turn, gyro)
        gyro = gyro.earlier(offsets["gyro"] or 0.0)
    seen = turning_by_people(times, places)
    offsets["pictures"] = None if seen is None else clock_offset(gyro or turn, seen)
    times = times - (offsets["pictures"] or 0.0)
    wheels = _by_wheels(times, speed, turn, every)
    truth = wheels if gyro is None else filter_motion(times, speed, turn, gyro)
    covariances = truth.covariances + _late(truth, times)
    return RobotMotion(poses=truth.poses, covariances=covariances, odometry=wheels.odometry), offsets


def follow_poses(
    path: Path, clouds: Stamps, times: FloatArray, places: FloatArray, every: int = 1
) -> tuple[RobotMotion, Offsets]:
    """The robot's motion by poses of its wheel odometry; ``times``, ``places``, ``every`` as in `measure_motion`.

    Parameters
    ----------
    path, clouds : as in `read_odometry_file`.
    """
    taken, way = read_odometry_file(path, clouds)
    when, twist = speeds_of(taken, way)
    if (fastest := float(np.abs(twist).max())) > _FASTEST:
        raise FileError(
            path, f"the robot has {fastest:,.0f} m/s or rad/s; positions are in m, one for each point cloud"
        )
    speed, turn = (Readings(times=when, values=values) for values in twist.T)
    _check_covers(path, speed, times)
    seen = turning_by_people(times, places)
    late = None if seen is None else clock_offset(turn, seen, WIDEST)
    if late is not None and abs(late) > MOST_LATE:
        problem = f"people turn around the robot {late:+.2f} s after its poses do; are poses those of the point clouds?"
        warnings.warn(VbbenchWarning(f"{path}: {problem}"), stacklevel=2)
    turned = None if seen is None else np.interp(seen.times, turn.times, turn.values)
    if seen is not None and turned is not None and turned @ seen.values < -0.5 * turned @ turned:
        problem = "people turn around the robot the other way than its poses do"
        raise FileError(path, f"{problem}: y must point left, z up, and orientations turn the robot into the world")
    poses = np.stack([np.interp(times, taken, column) for column in way.T], axis=-1)
    wheels = _by_wheels(times, speed, turn, every)
    return replace(wheels, poses=moved_as_one(poses, poses[0], np.zeros(3))), {"places": late}


def _by_wheels(times: FloatArray, speed: Readings, turn: Readings, every: int) -> RobotMotion:
    """The motion by the wheels alone; covariances of odometry are shares of those of every ``every``-th frame."""
    whole, kept = (filter_motion(when, speed, turn, None) for when in (times, times[::every]))
    return replace(whole, odometry=shared_out(whole.odometry, kept.odometry, every))


def shared_out(odometry: Odometry, kept: Odometry, every: int) -> Odometry:
    """``odometry`` with the covariances of ``kept``, whose motions span ``every`` frames, divided among these."""
    block = (np.arange(len(odometry.motions)) + every - 1) // every
    shares = kept.covariances[block.clip(max=len(kept.motions) - 1)] / every
    return Odometry(motions=odometry.motions, covariances=shares)


def turning_by_people(times: FloatArray, places: FloatArray) -> Readings | None:
    """The robot's turning rate in rad/s between frames, by the median apparent rotation of people around it.

    ``None`` if too few frames have enough people.
    """
    directions = np.arctan2(places[..., 1], places[..., 0])
    turned = wrap_angle(np.diff(directions, axis=0))
    enough: BoolArray = (~np.isnan(turned)).sum(axis=1) >= _FEWEST
    if enough.sum() < 2:
        return None
    middles = times[:-1] + 0.5 * np.diff(times)
    return Readings(times=middles[enough], values=-np.nanmedian(turned[enough], axis=1) / np.diff(times)[enough])


def _late(motion: RobotMotion, times: FloatArray) -> FloatArray:
    """Covariances [T, 3, 3] of poses by an error of the clock, σ = `OFFSET_STD`, times velocity relative to frame 0."""
    speeds: FloatArray = np.gradient(motion.poses, times, axis=0)
    ahead = OFFSET_STD * (speeds - speeds[0])
    added: FloatArray = ahead[:, :, None] * ahead[:, None, :]
    return added


def _check_covers(path: Path, speed: Readings, times: FloatArray) -> None:
    first, last = speed.times[[0, -1]]
    if times[0] < first - _SLACK or times[-1] > last + _SLACK:
        covered, wanted = f"{first:.3f} to {last:.3f} s", f"{times[0]:.3f} to {times[-1]:.3f} s"
        raise FileError(path, f"covers {covered}, the pictures {wanted}: is it the bag of another recording?")
