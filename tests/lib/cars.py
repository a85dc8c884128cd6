"""A drive among walkers as a log of Argoverse 2, as tables of nuScenes, and as a recording of split ``own``.

Places and boxes are computed point by point with SciPy's rotations, on their own.
"""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import feather
from scipy.spatial.transform import Rotation

from vbbench.geometry import FloatArray

LOG = "00000000-1111-2222-3333-444444444444"
START_NS, START_US = 315_970_000_000_000_000, 1_530_000_000_000_000
FOCAL, WIDTH, HEIGHT = 700.0, 1600, 900
EYES = {"front": (1.6, 0.0, 0.0), "left": (1.3, 0.3, 1.6), "rear": (1.0, -0.2, 3.1)}
"""Cameras: forward and left of the car's origin in m, and yaw in rad."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A car drives along x with a slight tilt among people who walk; at 10 frames a second.

    Parameters
    ----------
    eye_height, ground : of the cameras over the car's origin, and of that over the road, in m.
    reach : least and greatest distance in m at which people begin.
    """

    frames: int = 101
    people: int = 6
    eye_height: float = 1.4
    ground: float = 0.31
    speed: float = 1.5
    reach: tuple[float, float] = (8.0, 20.0)
    seed: int = 0
    sizes: FloatArray = field(init=False)
    start: FloatArray = field(init=False)
    velocity: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        rng = np.random.default_rng(self.seed)
        angle = 2.0 * np.pi * np.arange(self.people) / self.people
        reach = rng.uniform(*self.reach, self.people)
        object.__setattr__(self, "sizes", np.array([0.7, 0.6, 1.7]) + rng.normal(0.0, 0.05, (self.people, 3)))
        object.__setattr__(self, "start", np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=-1))
        object.__setattr__(self, "velocity", np.array([self.speed, 0.0]) + rng.normal(0.0, 0.3, (self.people, 2)))

    @property
    def times(self) -> FloatArray:
        return 0.1 * np.arange(self.frames)

    def car(self, time: float) -> tuple[Rotation, FloatArray]:
        """Rotation and origin in the world, whose own origin is far away."""
        turn = Rotation.from_euler("ZYX", [0.4 + 0.03 * time, 0.01, -0.008])
        return turn, np.array([500.0 + self.speed * time, -200.0 + 0.1 * time, 20.0 + self.ground])

    def person(self, number: int, time: float) -> tuple[Rotation, FloatArray]:
        """Rotation and centre of the cuboid in the world."""
        x, y = self.start[number] + time * self.velocity[number]
        heading = np.arctan2(*self.velocity[number][::-1])
        return Rotation.from_euler("z", heading), np.array([500.0 + x, -200.0 + y, 20.0 + 0.5 * self.sizes[number, 2]])

    def points(self, number: int) -> int:
        """Lidar points on a person: the last one is hidden."""
        return 0 if number == self.people - 1 else 40


def eye(name: str, height: float) -> tuple[Rotation, FloatArray]:
    """Rotation from a camera's axes to the car's, and its place on the car."""
    forward, left, yaw = EYES[name]
    axes = Rotation.from_matrix([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    return Rotation.from_euler("z", yaw) * axes, np.array([forward, left, height])


def quaternion(rotation: Rotation) -> list[float]:
    x, y, z, w = rotation.as_quat().tolist()
    return [w, x, y, z]


def write_log(folder: Path, drive: Drive, missing: int | None = None) -> Path:
    """A log in the official layout; without the sweep ``missing``."""
    rows: list[dict[str, Any]] = []
    poses: list[dict[str, Any]] = []
    for frame, time in enumerate(drive.times.tolist()):
        late = 0.002 * np.sin(frame) if frame else 0.0
        stamp = START_NS + round((time + late) * 1e9)
        for part in (0.0, 0.03):
            turn, origin = drive.car(time + late + part)
            pose = dict(zip(("qw", "qx", "qy", "qz"), quaternion(turn), strict=True))
            place = dict(zip(("tx_m", "ty_m", "tz_m"), origin.tolist(), strict=True))
            poses.append({"timestamp_ns": stamp + round(part * 1e9), **pose, **place})
        if frame == missing:
            continue
        turn, origin = drive.car(time + late)
        for number in range(drive.people):
            rotation, centre = drive.person(number, time + late)
            values = dict(zip(("length_m", "width_m", "height_m"), drive.sizes[number].tolist(), strict=True))
            values |= dict(zip(("qw", "qx", "qy", "qz"), quaternion(turn.inv() * rotation), strict=True))
            values |= dict(zip(("tx_m", "ty_m", "tz_m"), turn.inv().apply(centre - origin).tolist(), strict=True))
            kind = {"track_uuid": f"person-{9 - number}", "category": "PEDESTRIAN"}
            rows.append({"timestamp_ns": stamp, **kind, **values, "num_interior_pts": drive.points(number)})
        rows.append({**rows[-1], "track_uuid": "a car", "category": "REGULAR_VEHICLE", "length_m": 4.5})
    write_feather(folder / "annotations.feather", rows)
    write_feather(folder / "city_SE3_egovehicle.feather", poses)
    mounted, lenses = [], []
    for name in EYES:
        rotation, place = eye(name, drive.eye_height)
        pose = dict(zip(("qw", "qx", "qy", "qz"), quaternion(rotation), strict=True))
        at = dict(zip(("tx_m", "ty_m", "tz_m"), place.tolist(), strict=True))
        mounted.append({"sensor_name": f"ring_{name}", **pose, **at})
        focal = {"fx_px": FOCAL, "fy_px": FOCAL, "cx_px": WIDTH / 2, "cy_px": HEIGHT / 2}
        lenses.append({"sensor_name": f"ring_{name}", **focal, "k1": 0.0, "k2": 0.0, "k3": 0.0})
        lenses[-1] |= {"height_px": HEIGHT, "width_px": WIDTH}
    write_feather(folder / "calibration" / "egovehicle_SE3_sensor.feather", mounted)
    write_feather(folder / "calibration" / "intrinsics.feather", lenses)
    return folder


def write_feather(path: Path, rows: list[dict[str, Any]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    feather.write_feather(pa.Table.from_pylist(rows), path, compression="uncompressed")


def write_tables(folder: Path, drives: dict[str, Drive]) -> Path:
    """Scenes in the tables of nuScenes' official schema; every fifth frame is a key frame."""
    tables: dict[str, list[dict[str, Any]]] = {
        "category": [{"token": "walks", "name": "human.pedestrian.adult", "description": "Adults."}],
        "attribute": [{"token": "a0", "name": "pedestrian.moving", "description": ""}],
        "visibility": [{"token": "1", "level": "v0-40"}, {"token": "4", "level": "v80-100"}],
        "sensor": [{"token": f"s-{name}", "channel": f"CAM_{name.upper()}", "modality": "camera"} for name in EYES]
        + [{"token": "s-lidar", "channel": "LIDAR_TOP", "modality": "lidar"}],
    }
    names = ("scene", "sample", "sample_data", "sample_annotation", "ego_pose", "calibrated_sensor", "instance")
    tables |= {name: [] for name in names}
    for scene, drive in drives.items():
        _add_scene(tables, scene, drive)
    folder.mkdir(parents=True, exist_ok=True)
    for name, rows in tables.items():
        (folder / f"{name}.json").write_text(json.dumps(rows, indent=0))
    return folder


def _add_scene(tables: dict[str, list[dict[str, Any]]], scene: str, drive: Drive) -> None:
    tables["scene"].append({"token": scene, "log_token": "", "nbr_samples": 1, "name": scene, "description": "A, b."})
    for name in EYES:
        rotation, place = eye(name, drive.eye_height)
        matrix = [[FOCAL, 0.0, WIDTH / 2], [0.0, FOCAL, HEIGHT / 2], [0, 0, 1]]
        row = {"token": f"{scene}-{name}", "sensor_token": f"s-{name}", "translation": place.tolist()}
        tables["calibrated_sensor"].append({**row, "rotation": quaternion(rotation), "camera_intrinsic": matrix})
    lidar = {"token": f"{scene}-lidar", "sensor_token": "s-lidar", "translation": [0.9, 0.0, 1.8]}
    tables["calibrated_sensor"].append({**lidar, "rotation": [1, 0, 0, 0], "camera_intrinsic": []})
    tables["instance"] += [{"token": f"{scene}-p{n}", "category_token": "walks"} for n in range(drive.people)]
    for frame, time in enumerate(drive.times.tolist()):
        stamp, key = START_US + round(time * 1e6), f"{scene}-{5 * round(frame / 5)}"
        if frame % 5 == 0:
            tables["sample"].append({"token": key, "timestamp": stamp, "prev": "", "scene_token": scene})
        for name in (*EYES, "lidar"):
            token = f"{scene}-{name}-{frame}"
            turn, origin = drive.car(time)
            pose = {"token": token, "timestamp": stamp, "rotation": quaternion(turn), "translation": origin.tolist()}
            tables["ego_pose"].append(pose)
            size = {"width": 0, "height": 0} if name == "lidar" else {"width": WIDTH, "height": HEIGHT}
            row = {"token": token, "sample_token": key, "ego_pose_token": token, "is_key_frame": frame % 5 == 0, **size}
            tables["sample_data"].append({**row, "calibrated_sensor_token": f"{scene}-{name}", "timestamp": stamp})
        if frame % 5:
            continue
        for number in range(drive.people):
            rotation, centre = drive.person(number, time)
            length, width, height = drive.sizes[number].tolist()
            row = {"token": f"{key}-{number}", "sample_token": key, "instance_token": f"{scene}-p{number}"}
            row |= {"visibility_token": "4", "attribute_tokens": ["a0"], "num_lidar_pts": drive.points(number)}
            row |= {"translation": centre.tolist(), "size": [width, length, height], "rotation": quaternion(rotation)}
            tables["sample_annotation"].append({**row, "num_radar_pts": 0, "prev": "", "next": ""})


def write_own(folder: Path, drive: Drive, ids: list[int], prior: tuple[float, float], jitter: bool) -> Path:
    """The same drive as a recording of split ``own``: the ring as a level panorama in the middle of its cameras."""
    middle = np.array([np.mean([place[axis] for place in EYES.values()]) for axis in (0, 1)] + [drive.eye_height])
    level = eye("front", 0.0)[0]
    boxes, people, poses = ["frame,id,left,top,width,height,visible"], ["frame,id,x,y,height"], []
    first = drive.car(0.0)[1]
    for frame, time in enumerate(drive.times.tolist()):
        late = 0.002 * np.sin(frame) if frame and jitter else 0.0
        turn, origin = drive.car(time + late)
        where, yaw = origin + turn.apply(middle) - first, turn.apply([1.0, 0.0, 0.0])
        yaw = Rotation.from_euler("z", np.arctan2(yaw[1], yaw[0])).as_quat().tolist()
        poses.append(" ".join(str(value) for value in (time, *where.tolist(), *yaw)))
        for number in range(drive.people - 1):
            rotation, centre = drive.person(number, time + late)
            pixels = []
            for corner in np.ndindex(2, 2, 2):
                point = centre + rotation.apply((np.array(corner) - 0.5) * drive.sizes[number])
                right, down, ahead = level.inv().apply(turn.inv().apply(point - origin) - middle)
                pixels.append((np.arctan2(right, ahead), 480.0 + 3760 / (2 * np.pi) * down / np.hypot(right, ahead)))
            column = np.unwrap([u for u, _ in pixels])
            column = (column + np.pi) * 3760 / (2 * np.pi)
            rows = [v for _, v in pixels]
            box = (column.min(), min(rows), np.ptp(column), max(rows) - min(rows))
            boxes.append(",".join(map(str, (frame, ids[number], *box, 1))))
            foot = centre - rotation.apply([0.0, 0.0, 0.5 * drive.sizes[number, 2]]) - first
            people.append(",".join(map(str, (frame, ids[number], foot[0], foot[1], drive.sizes[number, 2]))))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "boxes.csv").write_text("\n".join(boxes) + "\n")
    (folder / "people.csv").write_text("\n".join(people) + "\n")
    (folder / "poses.txt").write_text("\n".join(poses) + "\n")
    mean, std = prior
    (folder / "camera.toml").write_text(
        f"model = 'panorama'\nwidth = 3760\nfocal = {3760 / (2 * np.pi)}\ncy = 480.0\n"
        f"mount_height = {drive.eye_height + drive.ground}\ndt = 0.1\nheight_mean = {mean}\nheight_std = {std}\n"
        "pixel_std = 1.0\nbox_edge = 0.45\ncarried_by = 'vehicle'\n"
    )
    return folder
