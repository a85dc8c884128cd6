"""A recording in JRDB's layout, made up: a robot drives among people, its wheels slip, and its clocks differ."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.lib.ros_messages import Messages
from vbbench.geometry import FloatArray, moved_as_one, wrap_angle
from vbbench_generators.footage.jrdb import CAMERA
from vbbench_generators.footage.odometry_filter import Readings
from vbbench_generators.views.vehicle import STEP, changing, get_robot, sense

START = 1.55e9
RATE = 15.0


@dataclass(frozen=True, kw_only=True)
class Robot:
    """How a robot drives and what its sensors get wrong; offsets: seconds that a clock is ahead of the wheels'."""

    seconds: float = 40.0
    speed_slip: float = 0.01
    turn_slip: float = 0.05
    spins: int = 3
    gyro_bias: float = 0.01
    gyro_offset: float = 0.0
    picture_offset: float = 0.0


@dataclass(frozen=True)
class Drive:
    """The path [N, 3] (x, y, yaw) every `STEP` seconds, and what the sensors say of it."""

    times: FloatArray
    path: FloatArray
    speed: Readings
    turn: Readings
    gyro: Readings

    def poses(self, times: FloatArray) -> FloatArray:
        """[T, 3] at some times, from (0, 0, 0) at the first."""
        x, y, yaw = (np.interp(times, self.times, column) for column in self.path.T)
        cos, sin = np.cos(yaw[0]), np.sin(yaw[0])
        x, y = x - x[0], y - y[0]
        return np.stack([cos * x + sin * y, cos * y - sin * x, yaw - yaw[0]], axis=-1)

    @property
    def distance(self) -> float:
        """Metres driven."""
        return float(np.linalg.norm(np.diff(self.path[:, :2], axis=0), axis=1).sum())


def drive(robot: Robot, seed: int) -> Drive:
    """Drive about: sometimes standing, never faster than 1.3 m/s."""
    rng = np.random.default_rng(seed)
    times = np.arange(0.0, robot.seconds, STEP)
    speed = np.clip(0.6 + changing(rng, len(times), 0.4, 3.0), 0.0, 1.3)
    turn = np.where(speed > 0.0, changing(rng, len(times), 0.3, 2.0), 0.0)
    yaw = np.cumsum(turn) * STEP
    x, y = np.cumsum(speed * np.cos(yaw)) * STEP, np.cumsum(speed * np.sin(yaw)) * STEP
    model = replace(
        get_robot(), speed_slip=robot.speed_slip, turn_slip=robot.turn_slip, spins=60.0 * robot.spins / robot.seconds
    )
    wheels, turning, gyro = sense(times, speed, turn, model, robot.gyro_bias, rng)
    return Drive(times, np.stack([x, y, yaw], axis=-1), wheels, turning, gyro.earlier(-robot.gyro_offset))


KINDS = {
    "labels_2d": "labels/labels_2d_stitched/{}.json",
    "labels_3d": "labels/labels_3d/{}.json",
    "pictures": "timestamps/{}/frames_img.json",
    "clouds": "timestamps/{}/frames_pc.json",
}
"""Where the official files are."""
Change = Callable[[dict[str, Any]], object]


def edit(path: Path, change: Change) -> None:
    """Change the values in a JSON file."""
    values = json.loads(path.read_text())
    change(values)
    path.write_text(json.dumps(values))


def each_label(values: dict[str, Any]) -> list[dict[str, Any]]:
    """All labels in a file of them, to be changed."""
    return [label for labels in values["labels"].values() for label in labels]


@dataclass(frozen=True)
class Files:
    """The recording as the values of its files, to be changed before they are written."""

    name: str
    drive: Drive
    frames: FloatArray
    heights: FloatArray
    positions: FloatArray
    labels_2d: dict[str, Any]
    labels_3d: dict[str, Any]
    pictures: dict[str, Any]
    clouds: dict[str, Any]
    bag: dict[str, Any] = field(default_factory=dict)

    def write(self, root: Path) -> Path:
        """Write labels and times; return ``root``."""
        for kind in KINDS:
            path = self.path(root, kind)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(getattr(self, kind)))
        return root

    def path(self, root: Path, kind: str) -> Path:
        """The file of one of the `KINDS` below ``root``."""
        return root / KINDS[kind].format(self.name)

    def edit(self, root: Path, kind: str, change: Change) -> None:
        """Change the values in one of the files that were written."""
        edit(self.path(root, kind), change)

    def write_odometry(self, folder: Path, start: tuple[float, float, float] = (5.0, -3.0, 2.0)) -> Path:
        """Write the true way as odometry in JSON, from a pose ``start`` (x, y, yaw) on; return ``folder``."""
        poses = moved_as_one(self.drive.poses(self.frames), np.zeros(3), np.array(start))
        entries = {
            f"{n:06d}.pcd": {
                "position": {"x": x, "y": y, "z": 0.1},
                "orientation": {"x": 0.0, "y": 0.0, "z": float(np.sin(0.5 * yaw)), "w": float(np.cos(0.5 * yaw))},
            }
            for n, (x, y, yaw) in enumerate(poses.tolist())
        }
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{self.name}.json").write_text(json.dumps({"odometry": entries}))
        return folder

    def write_results(self, root: Path, seed: int = 0) -> Path:
        """Write boxes and places as results of two trackers, whose ids differ; return ``root``."""
        other = np.random.default_rng(seed).permutation(1000)
        rows: dict[str, list[str]] = {"tracks_2d": [], "tracks_3d": []}
        for frame, (flat, solid) in enumerate(
            zip(self.labels_2d["labels"].values(), self.labels_3d["labels"].values(), strict=True)
        ):
            for one in flat:
                box = " ".join(f"{value:.6f}" for value in one["box"])
                number = int(one["label_id"].split(":")[1])
                rows["tracks_2d"].append(f"{frame} {number} Pedestrian 0 0 -1 {box} -1 -1 -1 -1 -1 -1 -1 0.75")
            for one in solid:
                box, number = one["box"], other[int(one["label_id"].split(":")[1])]
                place = f"{-box['cy']:.6f} 0.7 {box['cx']:.6f} {box['l']} {box['h']:.6f} {box['w']} 0"
                rows["tracks_3d"].append(f"{frame} {number} Pedestrian 0 0 -1 -1 -1 -1 -1 {place} 1")
        for folder, lines in rows.items():
            (root / folder).mkdir(parents=True, exist_ok=True)
            (root / folder / f"{self.name}.txt").write_text("\n".join(lines) + "\n")
        return root

    def write_bag(self, folder: Path, **changes: Any) -> Path:
        """Write the robot's bag; return ``folder``."""
        folder.mkdir(parents=True, exist_ok=True)
        write_bag(folder / f"{self.name}.bag", self.drive, **{**self.bag, **changes})
        return folder


def recording(name: str = "made-up-2026-01-01_0", people: int = 12, seed: int = 0, robot: Robot | None = None) -> Files:
    """A recording of people who walk around the robot's path."""
    robot = robot or Robot()
    driven = drive(robot, seed)
    rng = np.random.default_rng(seed + 1000)
    times = np.arange(1.0, robot.seconds - 1.0, 1.0 / RATE)
    times = times + rng.uniform(-0.002, 0.002, len(times))
    poses = driven.poses(times)
    start = poses[rng.integers(0, len(poses), people), :2] + rng.normal(0.0, 5.0, (people, 2))
    pace = np.where(rng.random((people, 1)) < 0.5, 0.0, rng.normal(0.0, 0.7, (people, 2)))
    positions = start + (times - times[0])[:, None, None] * pace
    heights = rng.normal(1.75, 0.07, people)
    labels_2d, labels_3d = _labels(positions, poses, heights)
    stamps = START + times + robot.picture_offset
    return Files(
        name,
        driven,
        times,
        heights,
        positions,
        {"labels": labels_2d},
        {"labels": labels_3d},
        {"data": [_stamp("cameras", "stitched_image0", f"{n:06d}.jpg", t) for n, t in enumerate(stamps)]},
        {"data": [_stamp("pointclouds", "upper_velodyne", f"{n:06d}.pcd", t + 0.004) for n, t in enumerate(stamps)]},
    )


def _labels(positions: FloatArray, poses: FloatArray, heights: FloatArray) -> tuple[dict[str, Any], dict[str, Any]]:
    """Both kinds, by the laws of the picture and not by the code under test: columns run clockwise from behind."""
    flat: dict[str, Any] = {}
    solid: dict[str, Any] = {}
    for frame, (people, (x, y, yaw)) in enumerate(zip(positions, poses, strict=True)):
        dx, dy = people[:, 0] - x, people[:, 1] - y
        ahead, left = np.cos(yaw) * dx + np.sin(yaw) * dy, np.cos(yaw) * dy - np.sin(yaw) * dx
        reach = np.hypot(ahead, left)
        column = (np.pi - np.arctan2(left, ahead)) * 3760.0 / (2.0 * np.pi)
        top = 209.4 + 482.9 * (CAMERA.mount_height - heights) / reach
        tall = 482.9 * heights / reach
        flat[f"{frame:06d}.jpg"], solid[f"{frame:06d}.pcd"] = [], []
        for person in np.flatnonzero((reach > 1.0) & (reach < 25.0)).tolist():
            name = f"pedestrian:{person + 1}"
            box = [column[person] - 0.2 * tall[person], top[person], 0.4 * tall[person], tall[person]]
            hidden = {
                "occlusion": "Mostly_visible" if person % 3 == 0 else "Fully_visible",
                "interpolated": frame % 2 == 1,
            }
            flat[f"{frame:06d}.jpg"].append({"label_id": name, "box": box, "attributes": hidden})
            place = {"cx": ahead[person], "cy": left[person], "cz": heights[person] / 2 - 0.76}
            size = {"l": 0.6, "w": 0.5, "h": heights[person], "rot_z": float(wrap_angle(0.3 - yaw))}
            solid[f"{frame:06d}.pcd"].append(
                {"label_id": name, "box": {**place, **size}, "attributes": {"num_points": 9}}
            )
    return flat, solid


def _stamp(sensors: str, name: str, file: str, time: float) -> dict[str, Any]:
    return {"timestamp": time, sensors: [{"name": name, "url": f"x/{file}", "timestamp": time}]}


def write_bag(
    path: Path,
    driven: Drive,
    *,
    wheels: str = "segway/feedback/wheel_odometry",
    imu: str | None = "imu/data",
    jump: float = 0.0,
    poses_only: bool = False,
    upside_down: bool = False,
    messages: bool = True,
    restarted: bool = False,
) -> None:
    """Write a ROS 1 bag with wheel odometry and IMU as rosbags writes them.

    Parameters
    ----------
    jump : seconds by which the wheels' clock leaps in the middle.
    poses_only : wheels tell where they are, and no speed.
    restarted : drivers are started again in the middle, and write on connections of their own from then on.
    """
    from rosbags.rosbag1 import Writer

    said = Messages(1, START)
    rows: list[tuple[float, str, Any]] = []
    if messages:
        rows += [(t, wheels, m) for t, m in _wheel_messages(said, driven, jump, poses_only)]
        up = -1.0 if upside_down else 1.0
        turns = zip(driven.gyro.times, driven.gyro.values, strict=True)
        rows += [(t, imu, said.imu(t, turn, up)) for t, turn in turns] if imu else []
    path.unlink(missing_ok=True)
    with Writer(path) as bag:
        kinds = {wheels: "nav_msgs/msg/Odometry", **({imu: "sensor_msgs/msg/Imu"} if imu else {})}
        open_ = {
            (topic, caller): bag.add_connection(topic, kind, typestore=said.store, callerid=caller)
            for topic, kind in kinds.items()
            for caller in ("/first", "/again")[: 1 + restarted]
        }
        for n, (time, topic, message) in enumerate(sorted(rows, key=lambda row: row[0])):
            raw = said.store.serialize_ros1(message, kinds[topic])
            caller = "/again" if restarted and n >= len(rows) // 2 else "/first"
            bag.write(open_[topic, caller], said.nanoseconds(time), raw)


def _wheel_messages(said: Messages, driven: Drive, jump: float, poses_only: bool) -> list[tuple[float, Any]]:
    passed = np.diff(driven.speed.times, prepend=driven.speed.times[0])
    yaws = np.cumsum(driven.turn.values * passed)
    xs, ys = (np.cumsum(driven.speed.values * one(yaws) * passed) for one in (np.cos, np.sin))
    found = []
    for n, time in enumerate(driven.speed.times):
        late = time + (jump if n >= len(xs) // 2 else 0.0)
        speeds = (0.0, 0.0) if poses_only else (driven.speed.values[n], driven.turn.values[n])
        found.append((time, said.odometry(late, (xs[n], ys[n], yaws[n]), *speeds)))
    return found
