"""One sequence of KITTI, read and checked: labels, calibration, camera poses, and boxes of a detector.

Poses of the camera, from GPS/IMU (``oxts/NNNN.txt``) or from other poses of camera 0.

Both become motions [T, 4, 4] from rectified coordinates of camera 0 to a world with z up. GPS/IMU gives the world of
its Mercator map, x to the east, as in KITTI's devkit: s = cos(latitude of the first line), R the earth's radius,

    x = s R λ,   y = s R ln tan(π/4 + φ/2),   rotation = Rz(yaw) Ry(pitch) Rx(roll);

poses of other programs have the world of their first line, x forward and y left.
"""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import observations_of
from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError, SourceMissingError, VbbenchWarning
from vbbench.exchange.text_tables import Rows, read_fixed
from vbbench.exchange.trajectory import MATRIX, read_trajectory
from vbbench.files.dataset_info import Pictures
from vbbench.files.tables import file_sha256
from vbbench.generation.footage import Footage, FootageOptions
from vbbench.generation.sources import data_folders
from vbbench.geometry import BoolArray, FloatArray, IntArray, motion_between, wrap_angle
from vbbench.scene import Scene
from vbbench_generators.footage.kitti.calibration import Calibration, read_calibration
from vbbench_generators.footage.kitti.labels import (
    CARS,
    Labels,
    read_boxes,
    read_labels,
    refuse_boxes_outside,
    refuse_places_elsewhere,
    size_of_pictures,
)
from vbbench_generators.footage.sequences import laid_out, medians, named, pictures_in
from vbbench_generators.footage.tracks import FoundTracks, file_for, follow

EARTH_RADIUS = 6378137.0

PLACE = "lat lon alt roll pitch yaw"
_REST = (
    "vn ve vf vl vu ax ay az af al au wx wy wz wf wl wu pos_accuracy vel_accuracy navstat numsats posmode velmode "
    "orimode"
)
OXTS_ROW = " ".join([PLACE, *(f"({name})" for name in _REST.split())])
"""The 30 columns of the devkit."""

LONGEST_STEP = 15.0
"""In m from a line to the next, a tenth of a second: no car is as fast as that."""

_Z_UP = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""From right, down, forward to forward, left, up."""


def read_oxts(path: Path, calibration: Calibration) -> FloatArray:
    """Motions [T, 4, 4] of camera 0, from the first camera's place on the map."""
    from scipy.spatial.transform import Rotation  # slow to import

    rows = read_fixed(path, OXTS_ROW, "GPS/IMU, a line a frame")
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
    motions[:, :3, :3] = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1)).as_matrix()
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


LABELS, CALIBRATION, OXTS, PICTURES = "label_02", "calib", "oxts", "image_02"
SITE = "https://www.cvlibs.net/datasets/kitti/eval_tracking.php"
WANTED = f"training/{LABELS}, training/{CALIBRATION} and training/{OXTS} of the tracking benchmark, from {SITE}"


@dataclass(frozen=True)
class KittiFolder:
    """The folder ``training`` at ``root``."""

    root: Path

    @property
    def names(self) -> list[str]:
        """Names of the sequences that have labels, sorted."""
        return sorted(path.stem for path in (self.root / LABELS).glob("*.txt"))

    def chosen(self, names: tuple[str, ...] | None) -> list[str]:
        """The sequences called ``names``, or all of them."""
        if not self.names:
            raise FileError(self.root / LABELS, "holds no labels; they are called 0000.txt and so on")
        return named(f"sequence of {self.root}", names, self.names)

    def file(self, kind: str, name: str) -> Path:
        """The file of a sequence in one of the folders."""
        return self.root / kind / f"{name}.txt"

    def pictures(self, name: str) -> Pictures | None:
        """The pictures of a sequence; ``None`` if they are missing."""
        return pictures_in(self.root / PICTURES / name, "{:06d}.png", first=0)

    def size_of_pictures(self, name: str) -> tuple[int, int] | None:
        """Width and height of the first picture of a sequence in px; ``None`` if it is missing."""
        from PIL import Image, UnidentifiedImageError

        pictures = self.pictures(name)
        if pictures is None or not pictures.path(0).is_file():
            return None
        try:
            with Image.open(pictures.path(0)) as picture:
                return picture.size
        except (OSError, UnidentifiedImageError) as error:
            raise FileError(pictures.path(0), "is no picture that can be read; download it again") from error


def find_folder(source: Path | None) -> KittiFolder:
    """The folder ``training``: ``source`` or its subfolder, by default that of ``kitti`` in the data folders."""
    places = [folder / "kitti" for folder in data_folders()] if source is None else [source]
    for place in places:
        for root in (place / "training", place):
            if (root / LABELS).is_dir():
                return KittiFolder(root)
    if source is None:
        raise SourceMissingError(f"kitti is made from files of your own: name with --source the folder with {WANTED}")
    raise FileError(source, f"holds no {LABELS}; kitti is made from a folder with {WANTED}")


DT = 0.1
"""Seconds per frame as documented; by the speedometer frames are about .1035 s apart."""

FARTHEST_APART, MOST_TURNED_APART = 0.5, 0.02
"""In m and rad a second, medians: how differently two sources of poses may move; .16 m and .0004 rad in 0019."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """Poses of the camera.

    Parameters
    ----------
    motions : [T, 4, 4] from coordinates of camera 0 to the world.
    source : ``oxts`` or ``poses``.
    parked : apparent motion of parked cars by each available source.
    """

    motions: FloatArray
    source: str
    parked: dict[str, ParkedCars]

    def values(self) -> dict[str, Any]:
        """As JSON has it."""
        return {"source": self.source, "parked_cars": {name: cars.values() for name, cars in self.parked.items()}}


@dataclass(frozen=True, kw_only=True)
class KittiRecording:
    """One sequence.

    Parameters
    ----------
    footage : people, boxes and poses.
    way : poses of the camera.
    found : boxes of a detector, if requested.
    sums : kind, sequence and SHA-256 of every file that was read.
    """

    footage: Footage
    way: Way
    found: FoundTracks | None
    sums: list[list[str]]


def read_recording(
    folder: KittiFolder, name: str, asked: FootageOptions, classes: tuple[str, ...], *, several: bool
) -> KittiRecording:
    """Read the sequence ``name``.

    Parameters
    ----------
    folder : the folder of its files.
    name : name of the sequence, such as ``0019``.
    asked : the user's options of footage.
    classes : classes that count as people.
    several : whether other sequences are read as well, so that a file of the user cannot serve all.
    """
    paths = _paths(folder, name, asked, several)
    labels, calibration = read_labels(paths["labels"]), read_calibration(paths["calibration"])
    camera = _camera(folder, name, labels, calibration)
    persons = labels.of(classes)
    refuse_places_elsewhere(persons, calibration)
    way = _find_way(paths, labels, calibration)
    rows, people, column = persons.tracked()
    values = rows.rectangles, rows.visible, in_the_world(rows.places, way.motions[rows.frame])
    labelled, visible, places = (laid_out((len(way.motions), len(people)), (rows.frame, column), one) for one in values)
    heights = medians(rows.height, column, len(people))
    tracks: dict[str, Any] = {"tracks": people, "boxes": observations_of(labelled, camera), "visible": visible}
    found = None
    if "boxes" in paths:
        shown: dict[str, Any] = {"dt": DT, "picture": camera.picture_size, "person_class": asked.person_class}
        boxes = read_boxes(paths["boxes"], len(labelled), classes, **shown)
        found = follow(boxes, labelled, people, camera, DT, size=camera.picture_size)
        tracks = found.seen
    footage = Footage(
        name=name,
        camera=camera,
        dt=DT,
        poses=on_the_ground(way.motions, calibration),
        scene=Scene(name=name, dt=DT, people=people, positions=places, heights=heights),
        pictures=folder.pictures(name),
        **tracks,
    )
    sums = [[f"{kind}/{name}", file_sha256(path)] for kind, path in paths.items()]
    return KittiRecording(footage=footage, way=way, found=found, sums=sums)


def _paths(folder: KittiFolder, name: str, asked: FootageOptions, several: bool) -> dict[str, Path]:
    """The files of a sequence by kind; GPS/IMU may be missing if the user has poses."""
    oxts = folder.file(OXTS, name)
    paths = {"labels": folder.file(LABELS, name), "calibration": folder.file(CALIBRATION, name)}
    if asked.poses is not None:
        paths["poses"] = file_for(asked.poses, name, several)
    if asked.poses is None or oxts.is_file():
        paths["oxts"] = oxts
    if asked.boxes is not None:
        paths["boxes"] = file_for(asked.boxes, name, several)
    return paths


def _camera(folder: KittiFolder, name: str, labels: Labels, calibration: Calibration) -> PerspectiveCamera:
    """Camera 2; the size of its pictures is the first one's, or KITTI's for this focal length, or holds all boxes."""
    shown, known = folder.size_of_pictures(name), calibration.known_size
    size, known_by = size_of_pictures(labels), "the smallest that hold all"
    if shown is not None:
        size, known_by = shown, "as the first of them is"
    elif known is not None:
        size, known_by = known, f"as KITTI's are where the focal length is {calibration.projection[0, 0]:g} px"
    refuse_boxes_outside(labels, size, known_by)
    return calibration.camera(size)


def _find_way(paths: dict[str, Path], labels: Labels, calibration: Calibration) -> Way:
    """The poses by GPS/IMU or by the user's file, whichever give parked cars less apparent motion."""
    sources = {}
    if "poses" in paths:
        sources["poses"] = read_poses(paths["poses"])
    if "oxts" in paths:
        sources["oxts"] = read_oxts(paths["oxts"], calibration)
    for source, motions in sources.items():
        if len(motions) <= labels.last_frame:
            problem = f"has {len(motions)} lines, but labels go on to frame {labels.last_frame}, counted from 0"
            advice = "every frame needs a line; download it again, or exclude the sequence"
            raise FileError(paths[source], f"{problem}: {advice}", len(motions))
    if len({len(motions) for motions in sources.values()}) > 1:
        lines = f"has {len(sources['poses'])} lines, and {paths['oxts'].name} of oxts {len(sources['oxts'])}"
        raise FileError(paths["poses"], f"{lines}: every frame needs a line in both; is a frame missing in the middle?")
    parked = dict(zip(sources, watch_parked_cars(labels, list(sources.values()), DT), strict=True))
    best = min(sources, key=lambda source: np.nan_to_num(parked[source].typical))  # the user's, where no car is parked
    if len(sources) > 1:
        poses, oxts = (on_the_ground(sources[source], calibration) for source in ("poses", "oxts"))
        _warn_if_apart(paths["poses"], poses, oxts, best)
    return Way(motions=sources[best], source=best, parked=parked)


def _warn_if_apart(path: Path, poses: FloatArray, oxts: FloatArray, best: str) -> None:
    """Warn if the poses [T, 3] of two sources do not move and turn equally from second to second."""
    second = round(1.0 / DT)
    if len(poses) <= second:
        return
    apart = motion_between(poses[:-second], poses[second:]) - motion_between(oxts[:-second], oxts[second:])
    moved, turned = np.median(np.hypot(apart[:, 0], apart[:, 1])), np.median(np.abs(wrap_angle(apart[:, 2])))
    if moved > FARTHEST_APART or turned > MOST_TURNED_APART:
        facts = f"in a second these poses and those of oxts move {moved:.2f} m and turn {turned:.3f} rad differently"
        advice = "one of them is wrong, or of another sequence"
        warnings.warn(VbbenchWarning(f"{path}: {facts} (medians); those of {best} are used: {advice}"), stacklevel=3)
