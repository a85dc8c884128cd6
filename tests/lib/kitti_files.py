"""A made recording in KITTI's layout: a camera that drives and sways, people who walk, a parked car."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

FRAMES, PEOPLE, HEIGHT, DT = 120, 5, 1.7, 0.1
SIZE = (1242, 375)
FOCAL = 721.5377
K = np.array([[FOCAL, 0.0, 609.5593], [0.0, FOCAL, 172.854], [0.0, 0.0, 1.0]])
OFFSET = np.array([0.06, -0.001, 0.003])
"""Of camera 2, in coordinates of camera 0."""
RECT = Rotation.from_euler("xyz", [0.004, -0.009, 0.01]).as_matrix()
VELO_TO_CAMERA = np.array([[0.0, -1.0, 0.0, -0.01], [0.0, 0.0, -1.0, -0.06], [1.0, 0.0, 0.0, -0.3]])
IMU_TO_VELO = np.hstack([Rotation.from_euler("xyz", [0.01, 0.0, -0.002]).as_matrix(), [[-0.81], [0.32], [-0.8]]])
MOUNT = 1.65


def whole(matrix: Any) -> Any:
    made = np.eye(4)
    made[:3, : np.shape(matrix)[1]] = matrix
    return made


IMU_TO_CAMERA = whole(RECT) @ whole(VELO_TO_CAMERA) @ whole(IMU_TO_VELO)


@dataclass
class Drive:
    """What is true of the recording.

    ``motions`` [T, 4, 4] are of camera 0, in a world with z up and the road at 0; ``people`` [T, P, 2] stand on it.
    """

    yaw: float = 2.3
    sway: float = 0.02
    speed: float = 4.0
    motions: Any = field(init=False)
    people: Any = field(init=False)
    car: Any = field(init=False)

    def __post_init__(self) -> None:
        rng, time = np.random.default_rng(3), DT * np.arange(FRAMES)
        ahead = np.array([np.cos(self.yaw), np.sin(self.yaw)])
        left = np.array([-ahead[1], ahead[0]])
        camera = np.column_stack([self.speed * time[:, None] * ahead, np.full(FRAMES, MOUNT)])
        turns = [[self.yaw + 0.1 * np.sin(t), self.sway * np.sin(3 * t), 0.5 * self.sway * np.cos(2 * t)] for t in time]
        body = Rotation.from_euler("ZYX", turns).as_matrix()
        axes = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
        self.motions = np.tile(np.eye(4), (FRAMES, 1, 1))
        self.motions[:, :3, :3] = body @ axes
        self.motions[:, :3, 3] = camera
        start = rng.uniform([14.0, -4.0], [18.0, 4.0], (PEOPLE, 2))
        pace = np.array([self.speed, 0.0]) + rng.normal(0.0, 0.4, (PEOPLE, 2))
        frame = np.stack([ahead, left])
        self.people = (start + time[:, None, None] * pace) @ frame
        self.car = (np.array([self.speed * time[-1] + 8.0, 5.0]) @ frame)[None, None].repeat(FRAMES, axis=0)

    def poses(self) -> Any:
        """[T, 3] of camera 2."""
        centre = (self.motions @ np.append(-OFFSET, 1.0))[:, :2]
        ahead = self.motions[:, :2, 2]
        return np.column_stack([centre, np.arctan2(ahead[:, 1], ahead[:, 0])])

    def in_camera(self, places: Any) -> Any:
        """[T, K, 3] feet at places [T, K, 2], in coordinates of camera 0."""
        world = np.concatenate([places, np.zeros((*places.shape[:2], 1)), np.ones((*places.shape[:2], 1))], axis=-1)
        return np.einsum("tij,tkj->tki", np.linalg.inv(self.motions), world)[..., :3]

    def labels(self) -> list[str]:
        """The lines of the label file: people are tracks 10, 11, …, the car is track 2."""
        lines = []
        everybody = np.concatenate([self.people, self.car], axis=1)
        places = self.in_camera(everybody)
        for frame in range(FRAMES):
            for person in range(everybody.shape[1]):
                kind, track = ("Car", 2) if person == PEOPLE else ("Pedestrian", 10 + person)
                line = label(frame, track, kind, places[frame, person])
                if line is not None:
                    lines.append(line)
            lines.append(f"{frame} -1 DontCare -1 -1 -10 1.0 2.0 30.0 40.0 -1000 -1000 -1000 -10 -1 -1 -1")
        return lines

    def oxts(self) -> list[str]:
        """The lines of GPS/IMU."""
        imu = self.motions @ IMU_TO_CAMERA
        scale = np.cos(np.radians(49.0)) * 6378137.0
        origin = scale * np.log(np.tan(np.pi / 4 + np.radians(49.0) / 2))
        latitude = np.degrees(2 * np.arctan(np.exp((imu[:, 1, 3] + origin) / scale)) - np.pi / 2)
        longitude = 8.4 + np.degrees(imu[:, 0, 3] / scale)
        turns = Rotation.from_matrix(imu[:, :3, :3]).as_euler("ZYX")
        rest = " ".join(["0.5"] * 24)
        return [
            f"{lat!r} {lon!r} {alt!r} {roll!r} {pitch!r} {yaw!r} {rest} "
            for lat, lon, alt, (yaw, pitch, roll) in zip(
                latitude.tolist(), longitude.tolist(), (imu[:, 2, 3] + 110.0).tolist(), turns.tolist(), strict=True
            )
        ]

    def pose_lines(self) -> list[str]:
        """The lines of somebody's poses of camera 0."""
        relative = np.linalg.inv(self.motions[0]) @ self.motions
        return [" ".join(map(repr, motion[:3].ravel().tolist())) for motion in relative]


def label(frame: int, track: int, kind: str, place: Any, height: float = HEIGHT) -> str | None:
    """One line; ``None`` for what is not in the picture."""
    corners = (place + OFFSET + np.array([[0.0, -height, 0.0], [0.0, 0.0, 0.0]])) @ K.T
    if place[2] < 1.0:
        return None
    (u, top), (_, bottom) = corners[:, :2] / corners[:, 2:]
    half = 0.18 * (bottom - top)
    left, right = np.clip([u - half, u + half], 0.0, SIZE[0])
    top, bottom = np.clip([top, bottom], 0.0, SIZE[1])
    if right - left < 4.0:
        return None
    x, y, z = place
    return (
        f"{frame} {track} {kind} 0 0 0.1 {left:.4f} {top:.4f} {right:.4f} {bottom:.4f} "
        f"{height} 0.5 0.6 {x:.6f} {y:.6f} {z:.6f} -1.5"
    )


CALIBRATION = {
    "P2:": np.column_stack([K, K @ OFFSET]),
    "R_rect": RECT,
    "Tr_velo_cam": VELO_TO_CAMERA,
    "Tr_imu_velo": IMU_TO_VELO,
}


def write_kitti(training: Path, name: str = "0003", drive: Drive | None = None, **changed: list[str]) -> Path:
    """Write ``label_02``, ``calib``, ``oxts`` below ``training``, and ``poses`` beside it; returns ``training``."""
    drive = drive or Drive()
    calibration = [" ".join([key, *map(repr, np.ravel(values).tolist())]) for key, values in CALIBRATION.items()]
    texts = {"label_02": drive.labels(), "calib": calibration, "oxts": drive.oxts(), "poses": drive.pose_lines()}
    for folder, lines in (texts | changed).items():
        path = (training.parent if folder == "poses" else training) / folder / f"{name}.txt"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(lines) + "\n")
    return training


def boxes_of(lines: list[str]) -> list[tuple[int, int, float, float, float, float]]:
    """Frame, track and corners of the people among label lines."""
    rows = [line.split() for line in lines if " Pedestrian " in line]
    return [(int(row[0]), int(row[1]), *map(float, row[6:10])) for row in rows]


def detections(boxes: list[Any], score: float = 5.0) -> str:
    """Boxes with KITTI's frames and corners, as lidar detectors write them."""
    rows = (
        f"{f},1,{left},{top},{right},{bottom},{score},1.7,0.5,0.6,1,2,3,0,0" for f, _, left, top, right, bottom in boxes
    )
    return "\n".join(rows) + "\n"


def mot(boxes: list[Any], *, linked: bool = True, end: str = "") -> str:
    """MOTChallenge's frames and corners, from 1."""
    rows = (
        f"{f + 1},{track if linked else -1},{left + 1},{top + 1},{right - left},{bottom - top},0.9{end}"
        for f, track, left, top, right, bottom in boxes
    )
    return "\n".join(rows) + "\n"


def results(boxes: list[Any], *, linked: bool = True) -> str:
    """What trackers write for KITTI's evaluation."""
    rows = (
        f"{f} {track if linked else -1} Pedestrian -1 -1 -10 {left} {top} {right} {bottom} "
        "-1 -1 -1 -1000 -1000 -1000 -10 0.9"
        for f, track, left, top, right, bottom in boxes
    )
    return "\n".join(rows) + "\n"
