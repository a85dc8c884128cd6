"""The split ``kitti``: sequences of KITTI's tracking benchmark as footage, their poses checked by parked cars."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from vbbench.boxes import observations_of
from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError, SourceMissingError, VbbenchWarning
from vbbench.files.tables import file_sha256
from vbbench.generation.footage import Footage, FootageOptions, Recordings
from vbbench.generation.generator import Card, Options, bundled_card
from vbbench.generation.sources import data_folders
from vbbench.geometry import BoolArray, FloatArray, IntArray, motion_between, wrap_angle
from vbbench.scene import Scene
from vbbench_generators.footage.kitti import (
    CARS,
    CYCLISTS,
    WALKERS,
    Calibration,
    Labels,
    in_the_world,
    on_the_ground,
    read_boxes,
    read_calibration,
    read_labels,
    read_oxts,
    read_poses,
    refuse_boxes_outside,
    refuse_places_elsewhere,
)
from vbbench_generators.footage.split import (
    READ_BY_ALL,
    FootageSplit,
    RunRules,
    laid_out,
    medians,
    named,
    pictures_in,
)
from vbbench_generators.footage.tracks import FOUND_PIXEL_STD, LEAST_OVERLAP, LEAST_SCORE, FoundTracks, file_for, follow

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


def find_training(source: Path | None) -> Path:
    """The folder ``training``: ``source`` or its subfolder, by default that of ``kitti`` in the data folders."""
    places = [folder / "kitti" for folder in data_folders()] if source is None else [source]
    for place in places:
        for root in (place / "training", place):
            if (root / LABELS).is_dir():
                return root
    if source is None:
        raise SourceMissingError(f"kitti is made from files of your own: name with --source the folder with {WANTED}")
    raise FileError(source, f"holds no {LABELS}; kitti is made from a folder with {WANTED}")


DT = 0.1
"""Seconds per frame as documented; by the speedometer frames are about .1035 s apart."""

FARTHEST_APART, MOST_TURNED_APART = 0.5, 0.02
"""In m and rad a second, medians: how differently two sources of poses may move; .16 m and .0004 rad in 0019."""


@dataclass(frozen=True, kw_only=True)
class KittiRecording:
    """One sequence.

    Parameters
    ----------
    footage : people, boxes and poses.
    source : where the poses are from, ``oxts`` or ``poses``.
    parked : apparent motion of parked cars by each available source.
    found : boxes of a detector, if requested.
    sums : kind, sequence and SHA-256 of every file that was read.
    """

    footage: Footage
    source: str
    parked: Mapping[str, ParkedCars]
    found: FoundTracks | None
    sums: list[list[str]]

    def values(self) -> dict[str, Any]:
        """The figures for ``dataset.json``."""
        cars = {name: cars.values() for name, cars in self.parked.items()}
        boxes = {} if self.found is None else {"boxes": {**self.found.agreements, "dropped": self.found.dropped}}
        return {"source": self.source, "parked_cars": cars, **boxes}

    def __str__(self) -> str:
        text, cars = f"{self.footage.name}: poses from {SPOKEN[self.source]}", self.parked[self.source]
        if not len(cars.moved):
            text += ", no parked car to check them by"
        else:
            moved = f"{cars.typical:.2f} m ({_ends(cars.moved, '.2f')}) in {_ends(cars.driven, '.0f')} m of driving"
            others = [f"{one.typical:.2f} m by {SPOKEN[n]}" for n, one in self.parked.items() if n != self.source]
            text = ", ".join([f"{text}: parked cars ({len(cars.moved)}) move {moved}", *others])
        if self.found is None:
            return text
        tracked = f"after tracking {self.found.tracked}, {len(self.found.tracks)} tracks"
        dropped = f"{self.found.dropped} boxes of tracks of nobody removed"
        return f"{text}; boxes found: {self.found.detected}; {tracked}, {dropped}"


def read_recording(
    root: Path, name: str, asked: FootageOptions, classes: tuple[str, ...], *, several: bool
) -> KittiRecording:
    """Read a sequence.

    Parameters
    ----------
    root : the folder ``training``.
    name : name of the sequence, such as ``0019``.
    asked : the user's options of footage.
    classes : classes that count as people.
    several : whether other sequences are read as well, so that a file of the user cannot serve all.
    """
    paths = _paths(root, name, asked, several)
    labels, calibration = read_labels(paths["labels"]), read_calibration(paths["calibration"])
    pictures = pictures_in(root / PICTURES / name, "{:06d}.png", first=0)
    camera = _camera(None if pictures is None else pictures.path(0), labels, calibration)
    persons = labels.of(classes)
    refuse_places_elsewhere(persons, calibration)
    motions, source, parked = _find_motions(paths, labels, calibration)
    rows, people, column = persons.tracked()
    values = rows.rectangles, rows.visible, in_the_world(rows.places, motions[rows.frame])
    labelled, visible, places = (laid_out((len(motions), len(people)), (rows.frame, column), one) for one in values)
    heights = medians(rows.height, column, len(people))
    tracks: dict[str, Any] = {"tracks": people, "boxes": observations_of(labelled, camera), "visible": visible}
    found = None
    if "boxes" in paths:
        size = camera.picture_size
        boxes = read_boxes(paths["boxes"], len(labelled), classes, DT, size, asked.person_class)
        found = follow(boxes, labelled, people, camera, DT, size=size)
        tracks = found.seen
    footage = Footage(
        name=name,
        camera=camera,
        dt=DT,
        poses=on_the_ground(motions, calibration),
        scene=Scene(name=name, dt=DT, people=people, positions=places, heights=heights),
        pictures=pictures,
        **tracks,
    )
    sums = [[f"{kind}/{name}", file_sha256(path)] for kind, path in paths.items()]
    return KittiRecording(footage=footage, source=source, parked=parked, found=found, sums=sums)


def _paths(root: Path, name: str, asked: FootageOptions, several: bool) -> dict[str, Path]:
    """The files of a sequence by kind; GPS/IMU may be missing if the user has poses."""
    labels, calibration, oxts = (root / kind / f"{name}.txt" for kind in (LABELS, CALIBRATION, OXTS))
    paths = {"labels": labels, "calibration": calibration}
    if asked.poses is not None:
        paths["poses"] = file_for(asked.poses, name, several)
    if asked.poses is None or oxts.is_file():
        paths["oxts"] = oxts
    if asked.boxes is not None:
        paths["boxes"] = file_for(asked.boxes, name, several)
    return paths


def _camera(picture: Path | None, labels: Labels, calibration: Calibration) -> PerspectiveCamera:
    """Camera 2; the size of its pictures is the first one's, or KITTI's for this focal length, or holds all boxes."""
    from PIL import Image, UnidentifiedImageError

    size, known_by = labels.smallest_picture, "the smallest that hold all"
    if picture is not None and picture.is_file():
        try:
            with Image.open(picture) as opened:
                size, known_by = opened.size, "as the first of them is"
        except (OSError, UnidentifiedImageError) as error:
            raise FileError(picture, "is no picture that can be read; download it again") from error
    elif calibration.known_size is not None:
        focal = calibration.projection[0, 0]
        size, known_by = calibration.known_size, f"as KITTI's are where the focal length is {focal:g} px"
    refuse_boxes_outside(labels, size, known_by)
    return calibration.camera(size)


def _find_motions(
    paths: dict[str, Path], labels: Labels, calibration: Calibration
) -> tuple[FloatArray, str, dict[str, ParkedCars]]:
    """Camera motions by GPS/IMU or the user's file, whichever move parked cars less; the source, and the cars by each.

    Motions [T, 4, 4] are from coordinates of camera 0 to the world.
    """
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
    return sources[best], best, parked


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


SPOKEN = {"oxts": "oxts", "poses": "your files"}
LONGEST = 900
"""Characters of the text; with more sequences, it says less of each."""


def summarise(recordings: Mapping[str, KittiRecording]) -> dict[str, Any]:
    """The figures of all recordings, with a ``summary`` in words."""
    text = ". ".join(map(str, recordings.values()))
    values = {name: one.values() for name, one in recordings.items()}
    return {"summary": text if len(text) <= LONGEST else _of_all(recordings), "sequences": values}


def _of_all(recordings: Mapping[str, KittiRecording]) -> str:
    checked = [one.parked[one.source].typical for one in recordings.values()]
    known = [value for value in checked if not np.isnan(value)]
    text = f"poses of {len(recordings)} sequences"
    if known:
        text += f"; in {len(known)} parked cars check them, and move {_ends(np.array(known), '.2f')} m"
    shares = [one.found.tracked.values() for one in recordings.values() if one.found is not None]
    for name in ("recall", "precision") if shares else ():
        text += f"; {name} of tracked boxes {_ends(np.array([share[name] for share in shares]), '.2f')}"
    return f"{text}; each in `vbbench info --json`"


def _ends(values: Any, form: str) -> str:
    least, most = format(values.min(), form), format(values.max(), form)
    return least if least == most else f"{least} to {most}"


CARD = bundled_card("vbbench_generators", "kitti")


@dataclass(frozen=True, kw_only=True)
class KittiSplit(FootageSplit):
    """See `FootageSplit`.

    Boxes are projections of labelled cuboids, whose near edge makes them about 3 % higher than a person's axis would
    be. Solvers are given this as heights of N(1.77, .09²) m, which is 1.03 × 1.72.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL | {"poses", "boxes", "person_class", "cyclists"}

    card: Card = CARD
    every: int = 4
    rules: RunRules = field(default_factory=lambda: RunRules(shortest=10))
    height_mean: float = 1.77
    classes: tuple[str, ...] = WALKERS

    def recordings(self, options: Options) -> Recordings:
        """See `FootageSplit.recordings`."""
        asked = options.footage or FootageOptions()
        root = find_training(options.source)
        there = sorted(path.stem for path in (root / LABELS).glob("*.txt"))
        if not there:
            raise FileError(root / LABELS, "holds no labels; they are called 0000.txt and so on")
        names = named(f"sequence of {root}", asked.sequences, there)
        classes = (*self.classes, *(CYCLISTS if asked.cyclists else ()))
        read = {name: read_recording(root, name, asked, classes, several=len(names) > 1) for name in names}
        matching = {"least_score": LEAST_SCORE, "least_overlap": LEAST_OVERLAP} if asked.boxes else {}
        return Recordings(
            footage=tuple(one.footage for one in read.values()),
            definition={
                "files": [file for one in read.values() for file in one.sums],
                "classes": list(classes),
                "poses": {name: one.source for name, one in read.items()},
                **matching,
                **asked.classes,
            },
            calibration=summarise(read),
            pixel_std=None if asked.boxes is None else FOUND_PIXEL_STD,
        )


kitti = KittiSplit()
