"""Poses of the camera, from GPS/IMU (``oxts/NNNN.txt``) or from other poses of camera 0.

Both become motions [T, 4, 4] from rectified coordinates of camera 0 to a world with z up. GPS/IMU gives the world of
its Mercator map, x to the east, as in KITTI's devkit: s = cos(latitude of the first line), R the earth's radius,

    x = s R λ,   y = s R ln tan(π/4 + φ/2),   rotation = Rz(yaw) Ry(pitch) Rx(roll);

poses of other programs have the world of their first line, x forward and y left.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.text_tables import Rows, read_fixed
from vbbench.exchange.trajectory import MATRIX, read_trajectory
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators.footage.kitti.calibration import Calibration
from vbbench_generators.footage.kitti.labels import CARS, Labels

EARTH_RADIUS = 6378137.0

PLACE = "lat lon alt roll pitch yaw"
_REST = (
    "vn ve vf vl vu ax ay az af al au wx wy wz wf wl wu pos_accuracy vel_accuracy navstat numsats posmode velmode "
    "orimode"
)
OXTS = " ".join([PLACE, *(f"({name})" for name in _REST.split())])
"""The 30 columns of the devkit."""

LONGEST_STEP = 15.0
"""In m from a line to the next, a tenth of a second: no car is as fast as that."""

_Z_UP = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""From right, down, forward to forward, left, up."""


def read_oxts(path: Path, calibration: Calibration) -> FloatArray:
    """Motions [T, 4, 4] of camera 0, from the first camera's place on the map."""
    rows = read_fixed(path, OXTS, "GPS/IMU, a line a frame")
    latitude, longitude, altitude, roll, pitch, yaw = (rows[name] for name in PLACE.split())
    rows.refuse(np.abs(latitude) > 85.0, "lat is {0:g}°; the map ends at 85°", latitude)
    rows.refuse(np.abs(longitude) > 180.0, "lon is {0:g}°; it is -180° to 180°", longitude)
    for name, angle in (("roll", roll), ("pitch", pitch), ("yaw", yaw)):
        rows.refuse(
            np.abs(angle) > 2.0 * np.pi, f"{name} is {{0:g}} rad, more than a full turn; is it in degrees?", angle
        )
    scale = np.cos(np.radians(latitude[0])) * EARTH_RADIUS
    east = scale * np.radians(longitude)
    north = scale * np.log(np.tan(np.pi / 4.0 + np.radians(latitude) / 2.0))
    motions = np.tile(np.eye(4), (len(rows), 1, 1))
    motions[:, :3, :3] = _rotations(roll, pitch, yaw)
    motions[:, :3, 3] = np.stack([east - east[0], north - north[0], altitude - altitude[0]], axis=-1)
    _refuse_leaps(rows, motions[:, :3, 3])
    cameras = motions @ np.linalg.inv(calibration.imu_to_camera)
    cameras[:, :3, 3] -= cameras[0, :3, 3].copy()
    return cameras


def read_poses(path: Path) -> FloatArray:
    """Motions [T, 4, 4] of camera 0 in the axes of the first picture; a line is a matrix [3, 4]."""
    rows = read_trajectory(path)
    if MATRIX not in rows.rotations:
        raise FileError(path, "needs 12 numbers in each line: a matrix [3, 4], row after row")
    motions = np.tile(np.eye(4), (len(rows), 1, 1))
    motions[:, :3, :3], motions[:, :3, 3] = rows.rotations[MATRIX], rows.places
    _refuse_leaps(rows, rows.places)
    return _Z_UP @ np.linalg.inv(motions[0]) @ motions


def _refuse_leaps(rows: Rows, places: FloatArray) -> None:
    """Raise FileError at the first of the ``places`` [T, 3] in m that is too far from the one before."""
    moved = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=1)
    rows.refuse(
        moved > LONGEST_STEP, "the camera is {0:,.0f} m from where the line before has it; are places in m?", moved
    )


def on_the_ground(motions: FloatArray, calibration: Calibration) -> FloatArray:
    """Poses [T, 3] (x, y, yaw) of camera 2 on the ground plane, from motions [T, 4, 4] of camera 0."""
    centre = np.append(-calibration.offset, 1.0)
    x, y = (motions @ centre)[:, :2].T
    ahead_x, ahead_y = motions[:, :2, 2].T
    return np.stack([x, y, np.arctan2(ahead_y, ahead_x)], axis=-1)


def in_the_world(places: FloatArray, motions: FloatArray) -> FloatArray:
    """World positions [N, 2] of places [N, 3] in coordinates of camera 0, with its motion [N, 4, 4] in each frame."""
    world: FloatArray = np.einsum("nij,nj->ni", motions[:, :2, :3], places) + motions[:, :2, 3]
    return world


def refuse_too_few(path: Path, lines: int, frames: int) -> None:
    """Raise FileError if a file with a line a frame ends before the labels."""
    if lines < frames:
        problem = f"has {lines} lines, but labels go on to frame {frames - 1}, counted from 0"
        raise FileError(path, f"{problem}: every frame needs a line; download it again, or exclude the sequence", lines)


def _rotations(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> FloatArray:
    """[T, 3, 3] Rz(yaw) Ry(pitch) Rx(roll)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1)).as_matrix())


LEAST_DRIVEN = 20.0
"""m that the camera must drive while a car is seen: over less, poses are good, and places are labelled no better."""
FASTEST = 0.8
"""m/s: no parked car seems to move faster, by the poses that suit it best, from one spell of frames to the next."""
SPELL = 20
"""Frames of a spell; the median over it is where the car was."""


@dataclass(frozen=True, kw_only=True)
class ParkedCars:
    """Apparent motion of parked cars between the first and the last fifth of the frames in which they are seen.

    Parameters
    ----------
    moved : [C] apparent motion of each car, in m.
    driven : [C] distance that the camera drove meanwhile, in m.
    """

    moved: FloatArray
    driven: FloatArray

    @property
    def typical(self) -> float:
        """The median over cars in m, NaN without any."""
        return float(np.median(self.moved)) if len(self.moved) else float("nan")

    def values(self) -> dict[str, object]:
        """The figures for ``dataset.json``."""
        return {
            "cars": len(self.moved),
            "moved": [round(value, 3) for value in self.moved.tolist()],
            "driven": [round(value, 1) for value in self.driven.tolist()],
        }


def watch_parked_cars(labels: Labels, sources: list[FloatArray], dt: float) -> list[ParkedCars]:
    """Apparent motions of the same parked cars, by each source of camera poses [T, 4, 4].

    A car counts if the camera drives `LEAST_DRIVEN` m while it is seen, and if it is slow by one of the sources.
    """
    rows, tracks, column = labels.of(CARS).tracked()
    driven = [_driven(motions) for motions in sources]
    parked, moved = [], []
    for number in range(len(tracks)):
        mine = np.flatnonzero(column == number)
        mine = mine[np.argsort(rows.frame[mine])]
        frame = rows.frame[mine]
        way = np.median([one[frame[-1]] - one[frame[0]] for one in driven])
        places = [in_the_world(rows.places[mine], motions[frame]) for motions in sources]
        if way >= LEAST_DRIVEN and min(_fastest(place, frame, dt) for place in places) < FASTEST:
            parked.append(way)
            moved.append([_moved(place) for place in places])
    found = np.array(moved).reshape(-1, len(sources)).T
    return [ParkedCars(moved=one, driven=np.array(parked)) for one in found]


def _driven(motions: FloatArray) -> FloatArray:
    """Distance [T] in m driven up to each frame."""
    steps = np.linalg.norm(np.diff(motions[:, :2, 3], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _moved(places: FloatArray) -> float:
    part = max(len(places) // 5, 1)
    return float(np.linalg.norm(np.median(places[-part:], axis=0) - np.median(places[:part], axis=0)))


def _fastest(places: FloatArray, frame: IntArray, dt: float) -> float:
    """The greatest speed in m/s between median places of consecutive intervals."""
    spell = (frame - frame[0]) // SPELL
    spells: list[BoolArray] = [spell == one for one in np.unique(spell)]
    if len(spells) < 2:
        return float("inf")
    middle = np.array([np.median(places[one], axis=0) for one in spells])
    when = np.array([frame[one].mean() * dt for one in spells])
    speeds = np.linalg.norm(np.diff(middle, axis=0), axis=1) / np.diff(when)
    return float(speeds.max())
