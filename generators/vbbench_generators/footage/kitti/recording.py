"""One sequence of KITTI, read and checked: labels, calibration, camera poses, and boxes of a detector."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import observations_of
from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError, SourceMissingError, VbbenchWarning
from vbbench.files.dataset_info import Pictures
from vbbench.files.tables import file_sha256
from vbbench.generation.footage import Footage, FootageOptions
from vbbench.generation.sources import data_folders
from vbbench.geometry import FloatArray, IntArray, motion_between, wrap_angle
from vbbench.scene import Scene
from vbbench_generators.footage.kitti.calibration import Calibration, read_calibration
from vbbench_generators.footage.kitti.labels import (
    Labels,
    read_boxes,
    read_labels,
    refuse_boxes_outside,
    refuse_places_elsewhere,
    size_of_pictures,
)
from vbbench_generators.footage.kitti.poses import (
    ParkedCars,
    in_the_world,
    on_the_ground,
    read_oxts,
    read_poses,
    refuse_too_few,
    watch_parked_cars,
)
from vbbench_generators.footage.sequences import named, pictures_in
from vbbench_generators.footage.tracks import FoundTracks, file_for, follow

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


@dataclass(frozen=True, kw_only=True)
class _People:
    """Labelled people: ids [P], boxes [T, P, 4] (left, top, width, height) in px, visible fractions [T, P], places."""

    ids: IntArray
    boxes: FloatArray
    visible: FloatArray
    scene: Scene


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
    people = _find_people(name, persons, way.motions)
    tracks: dict[str, Any] = {"tracks": people.ids, "boxes": observations_of(people.boxes, camera)}
    tracks["visible"] = people.visible
    found = None
    if "boxes" in paths:
        shown: dict[str, Any] = {"dt": DT, "picture": camera.picture_size, "person_class": asked.person_class}
        boxes = read_boxes(paths["boxes"], len(people.boxes), classes, **shown)
        found = follow(boxes, people.boxes, people.ids, camera, DT, size=camera.picture_size)
        tracks = found.seen
    footage = Footage(
        name=name,
        camera=camera,
        dt=DT,
        poses=on_the_ground(way.motions, calibration),
        scene=people.scene,
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
        refuse_too_few(paths[source], len(motions), labels.last_frame + 1)
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


def _find_people(name: str, labels: Labels, motions: FloatArray) -> _People:
    rows, ids, column = labels.tracked()
    shape, at = (len(motions), len(ids)), (rows.frame, column)
    boxes, visible, places = np.full((*shape, 4), np.nan), np.full(shape, np.nan), np.full((*shape, 2), np.nan)
    boxes[at] = np.concatenate([rows.boxes[:, :2], rows.boxes[:, 2:] - rows.boxes[:, :2]], axis=-1)
    visible[at] = rows.visible
    places[at] = in_the_world(rows.places, motions[rows.frame])
    heights = np.array([_median_of_known(rows.height[column == track]) for track in range(len(ids))], np.float64)
    scene = Scene(name=name, dt=DT, people=ids, positions=places, heights=heights)
    return _People(ids=ids, boxes=boxes, visible=visible, scene=scene)


def _median_of_known(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) else np.nan
