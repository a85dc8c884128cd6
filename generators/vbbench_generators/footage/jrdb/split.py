"""The split ``jrdb``: recordings of JRDB that users download themselves."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from vbbench.camera import PanoramaCamera
from vbbench.errors import FileError, SourceMissingError, VbbenchError
from vbbench.exchange.box_rows import BoxRows
from vbbench.files.tables import file_sha256
from vbbench.generation.footage import Footage, FootageOptions, Recordings
from vbbench.generation.generator import Options, bundled_card
from vbbench_generators.footage.jrdb import CAMERA, Recording, assemble, direction_errors, nearest_clouds
from vbbench_generators.footage.jrdb.labels import (
    BOXES,
    PLACES,
    PlaceLabels,
    pictures_of,
    read_pictures,
    read_places,
    read_sample,
    read_tracked_boxes,
    read_tracked_places,
)
from vbbench_generators.footage.jrdb.motion import (
    CLOUDS,
    PICTURES,
    Grid,
    Offsets,
    Stamps,
    follow_poses,
    lay_out,
    measure_motion,
    nominal_stamps,
    read_stamps,
)
from vbbench_generators.footage.odometry_filter import RobotMotion
from vbbench_generators.footage.split import READ_BY_ALL, FootageSplit, named
from vbbench_generators.footage.tracks import FoundTracks, file_for

ADDRESS = "https://jrdb.erc.monash.edu"

STANDING = frozenset(
    {
        "bytes-cafe-2019-02-07_0",
        "gates-ai-lab-2019-02-08_0",
        "gates-basement-elevators-2019-01-17_1",
        "hewlett-packard-intersection-2019-01-24_0",
        "huang-lane-2019-02-12_0",
        "jordan-hall-2019-04-22_0",
        "packard-poster-session-2019-03-20_1",
        "packard-poster-session-2019-03-20_2",
        "stlc-111-2019-04-19_0",
        "svl-meeting-gates-2-2019-04-08_0",
        "tressider-2019-03-16_0",
        "tressider-2019-03-16_1",
    }
)
"""Recordings of the training set in which the robot does not move: NO_MOVEMENT of github.com/ericaweng/WHAM, by eye.

One of the list, which hardly turns by its comment (svl-meeting-gates-2-2019-04-08_1), is not in it.
"""

_ROOTS = ("", "train_dataset_with_activity", "train_dataset", "test_dataset")
_PICTURE_LABELS, _PLACE_LABELS = "labels/labels_2d_stitched", "labels/labels_3d"
PICTURE_TIMES, CLOUD_TIMES, TRACKED = "picture times", "cloud times", "tracked boxes"
"""What some files are."""

_BAGS = ("", "rosbags", "train", "rosbags/train")
_PARTS = ("", "/train", "/test", "_train", "_test")
_ODOMETRY = ("", "train", "test", *(f"{place}odometry{part}" for place in ("", "processed/") for part in _PARTS))
"""Folders with NAME.json, the robot's way by its wheels."""
_TRACKERS = "boxes and places are the results of two trackers, and not labels"
_RELATIVE = "the robot's motion is not known: errors of places from the camera alone (dx_rel) are scored"


@dataclass(frozen=True, kw_only=True)
class Found:
    """The files of one recording.

    Parameters
    ----------
    name : name of the recording.
    files : files by kind: ``sample`` alone, the official files, or a tracker's boxes and places.
    pictures : folder of its pictures, if there is one.
    """

    name: str
    files: dict[str, Path]
    pictures: Path | None = None


@dataclass(frozen=True, kw_only=True)
class JrdbSplit(FootageSplit):
    """Reads the official folders, the one-file sample of JRDB-Traj, or results of trackers.

    Parameters
    ----------
    camera : camera of all recordings.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL | {"boxes", "person_class", "bags", "interpolated"}

    camera: PanoramaCamera = CAMERA

    def recordings(self, options: Options) -> Recordings:
        """Read the chosen recordings; if one of them lacks poses, none are given."""
        asked = options.footage or FootageOptions()
        there = {one.name: one for one in find_recordings(options.source)}
        found = [there[name] for name in named("recording of jrdb", asked.sequences, there)]
        bags = _ways(found, options.source, asked.bags)
        known = [one.name in bags or one.name in STANDING for one in found]
        several = len(found) > 1
        boxes = {} if asked.boxes is None else {one.name: file_for(asked.boxes, one.name, several) for one in found}
        made = [self._read(one, bags.get(one.name), boxes.get(one.name), asked, poses=all(known)) for one in found]
        sums = {one.name: {kind: file_sha256(path) for kind, path in sorted(one.files.items())} for one in found}
        for kind, paths in (("bag", bags), ("boxes", boxes)):
            for name, path in paths.items():
                sums[name][kind] = file_sha256(path)
        return Recordings(
            footage=tuple(footage for footage, _ in made),
            definition={"files": sums, "interpolated": asked.interpolated, **asked.classes},
            calibration={
                "summary": "; ".join(_summary(facts) for _, facts in made[:3]) + ("; …" if len(made) > 3 else ""),
                "recordings": [facts for _, facts in made],
            },
            caution=self._caution(found, known),
        )

    def _read(
        self, one: Found, bag: Path | None, boxes: Path | None, asked: FootageOptions, *, poses: bool
    ) -> tuple[Footage, dict[str, Any]]:
        recording = read_recording(one, interpolated=asked.interpolated)
        every, step = asked.every or self.every, recording.step
        if every % step:
            raise VbbenchError(f"{one.name}: boxes are {step} frames of 15 Hz apart; use `every` {step} or a multiple")
        motion, offsets = None, Offsets()
        if bag is not None and poses:
            frames = recording.grid.times, recording.places, every
            if bag.suffix == ".json":
                motion, offsets = follow_poses(bag, _cloud_stamps(one, recording.grid), *frames)
            else:
                motion, offsets = measure_motion(bag, *frames)
        tracks = None if boxes is None else recording.follow(boxes, asked.person_class)
        stands = poses and motion is None
        footage = recording.footage(motion, stands=stands, pictures=one.pictures, found=tracks)
        return footage, _facts(recording, motion, offsets, tracks)

    def _caution(self, found: list[Found], known: list[bool]) -> str:
        base = _TRACKERS if any(TRACKED in one.files for one in found) else str(self.card.caution)
        if all(known):
            return base
        names = [one.name for one, way in zip(found, known, strict=True) if way]
        also = f"; it is known of {', '.join(names)}: name these with --sequences" if names else ""
        return f"{base}; {_RELATIVE}{also}"


def read_recording(one: Found, *, interpolated: bool = True) -> Recording:
    """Labels and times of one recording.

    Parameters
    ----------
    interpolated : whether boxes that were interpolated from others are kept.
    """
    pictures, places = _labels(one, interpolated=interpolated)
    pictures = pictures.select(pictures.visible > 0.0)
    if not len(pictures):
        raise FileError(pictures.path, "holds no box of a visible person" + ("" if interpolated else " by hand"))
    first, last = int(pictures.frame.min()), int(pictures.frame.max())
    if PICTURE_TIMES in one.files:
        stamps = read_stamps(one.files[PICTURE_TIMES].parent, PICTURES).between(first, last)
    else:
        stamps = nominal_stamps(pictures.path, np.unique(pictures.frame))
    grid = lay_out(stamps)
    clouds = nearest_clouds(grid, _cloud_stamps(one, grid))
    return assemble(one.name, pictures, places, grid, clouds, same_ids=TRACKED not in one.files)


def _cloud_stamps(one: Found, grid: Grid) -> Stamps:
    """Times of the point clouds; those of the pictures where the recording has none."""
    if CLOUD_TIMES in one.files:
        return read_stamps(one.files[CLOUD_TIMES].parent, CLOUDS)
    return nominal_stamps(next(iter(one.files.values())), grid.frames)


def _labels(one: Found, *, interpolated: bool) -> tuple[BoxRows, PlaceLabels]:
    if TRACKED in one.files:
        found = read_tracked_boxes(one.files[TRACKED])
        return pictures_of(found), read_tracked_places(one.files["places"])
    if "sample" in one.files:
        return read_sample(one.files["sample"])
    return read_pictures(one.files["pictures"], interpolated=interpolated), read_places(one.files["places"])


def find_recordings(source: Path | None) -> list[Found]:
    """The recordings in a folder or a file, by name.

    Raises SourceMissingError if no folder is named; VbbenchError if it holds none.
    """
    if source is None:
        wanted = (
            f"the folder that holds {_PICTURE_LABELS}, {_PLACE_LABELS} and timestamps, or train_dataset_with_activity"
        )
        raise SourceMissingError(
            f"jrdb: name with --source {wanted}; download it from {ADDRESS} (account, terms of use)"
        )
    tracked = sorted((source / BOXES).glob("*.txt"))
    if tracked:
        return [Found(name=path.stem, files={TRACKED: path, "places": source / PLACES / path.name}) for path in tracked]
    if source.is_file():
        return [Found(name=source.stem, files={"sample": source})]
    if not source.is_dir():
        raise VbbenchError(f"{source}: there is no such file or folder")
    root = next((source / name for name in _ROOTS if (source / name / _PICTURE_LABELS).is_dir()), None)
    if root is None:
        samples = sorted(path for path in source.glob("*.csv") if path.is_file())
        if samples:
            return [Found(name=path.stem, files={"sample": path}) for path in samples]
        raise FileError(source, f"holds no {_PICTURE_LABELS}; name JRDB's folder, such as train_dataset_with_activity")
    found = [_official(root, path.stem) for path in sorted((root / _PICTURE_LABELS).glob("*.json"))]
    if not found:
        raise FileError(root / _PICTURE_LABELS, "holds no NAME.json")
    return found


def _official(root: Path, name: str) -> Found:
    files = {
        "pictures": root / _PICTURE_LABELS / f"{name}.json",
        "places": root / _PLACE_LABELS / f"{name}.json",
        PICTURE_TIMES: root / "timestamps" / name / PICTURES,
        CLOUD_TIMES: root / "timestamps" / name / CLOUDS,
    }
    return Found(name=name, files=files, pictures=root / "images" / "image_stitched" / name)


def _ways(found: list[Found], source: Path | None, asked: Path | None) -> dict[str, Path]:
    """The bag or odometry file of each recording: where the user names it, or next to the labels."""
    if asked is not None:
        return {one.name: find_bag(asked, one.name) for one in found}
    folders = [] if source is None or source.is_file() else [source, source.absolute().parent]
    ways = {one.name: _first_file(folders, _ODOMETRY[3:], f"{one.name}.json") for one in found}
    return {name: path for name, path in ways.items() if path is not None}


def find_bag(folder: Path, name: str) -> Path:
    """The robot's log of the recording ``name``: a bag, or odometry as JSON."""
    if folder.is_file():
        return folder
    path = _first_file([folder], _BAGS, f"{name}.bag") or _first_file([folder], _ODOMETRY, f"{name}.json")
    if path is None:
        problem = f"holds neither {name}.bag nor {name}.json; download JRDB's rosbags or odometry"
        raise FileError(folder, f"{problem}, or name other recordings (`sequences`)")
    return path


def _first_file(folders: list[Path], places: tuple[str, ...], name: str) -> Path | None:
    paths = (folder / place / name for folder in folders for place in places)
    return next((path for path in paths if path.is_file()), None)


def _facts(
    recording: Recording, motion: RobotMotion | None, offsets: Offsets, tracks: FoundTracks | None
) -> dict[str, Any]:
    """Figures of a recording for ``dataset.json``."""
    errors = direction_errors(recording)
    facts: dict[str, Any] = {
        "name": recording.name,
        "columns_beside_places": round(float(np.median(np.abs(errors))), 4),
        "seconds_a_frame": round(recording.grid.seconds, 5),
    }
    if tracks is not None:
        facts |= tracks.agreements
    if motion is not None:
        facts["driven"] = round(motion.distance, 2)
        facts["end_std"] = round(motion.end_std, 3)
        facts["clock_offsets"] = {n: None if value is None else round(value, 3) for n, value in offsets.items()}
    return facts


def _summary(facts: dict[str, Any]) -> str:
    text = f"{facts['name']}: boxes {facts['columns_beside_places']:.3f} rad from the labelled places (median)"
    if "detected" in facts:
        for what in ("detected", "tracked"):
            text += f", boxes {what}: " + "recall {recall:.2f}, precision {precision:.2f}".format(**facts[what])
    if "driven" in facts:
        text += f", {facts['driven']:.1f} m driven, the end known to {facts['end_std']:.2f} m"
    return text


jrdb = JrdbSplit(
    card=bundled_card("vbbench_generators", "jrdb"),
    every=6,
    height_mean=1.75,
    height_std=0.22,
)
