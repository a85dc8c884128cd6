"""People labelled as cuboids around a car, seen by its cameras: what `argoverse2` and `nuscenes` have in common.

Axes of the car are forward, left and up, those of a camera right, down and forward. Boxes are projections of cuboids:
their top and bottom lie on the near edge of a cuboid, not on the person's axis.
"""

import hashlib
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from vbbench.boxes import cut_to_picture, observations_of
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import FileError, SourceMissingError, VbbenchError
from vbbench.exchange.own.calibration_files import Distortion, straight_rows
from vbbench.files.tables import file_sha256, first_repetition
from vbbench.generation.footage import Footage, FootageOptions, Recordings
from vbbench.generation.generator import Options
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.toml_text import bundled_table
from vbbench.scene import Scene
from vbbench_generators import _core
from vbbench_generators.footage.split import (
    READ_BY_ALL,
    FootageSequences,
    FootageSplit,
    RunRules,
    laid_out,
    medians,
    named,
)
from vbbench_generators.footage.tracks import FOUND_PIXEL_STD, FoundTracks, file_for, follow, read_found

DT = 0.1
"""Seconds per frame of every recording."""
PANORAMA = "panorama"
"""What the 360-degree ring of all cameras is called."""
FARTHEST = 60.0
"""In m from the car: people beyond have no box."""
NEAR, LASTING = 40.0, 8.0
"""The selection rule: enough people within so many m of the camera, for so many s."""
LONGEST = 20.0
"""Seconds after which a sequence is cut."""
NEAR_EDGE = 0.45
"""In m, of projected cuboids: see `vbbench.solver.Problem`."""
BEHIND = 0.1
"""A corner less than so many m in front of a camera has no place in its picture."""
TALLEST = 3.0
"""In m, of a person."""
STANDS = 1.0
"""A camera that is driven less than so many m in a recording stands."""
PANORAMA_WIDTH = 3760
PARTS = ("train", "tune", "test")

Part = Literal["train", "tune", "test"]


class ArrowTable:
    """A table of a data set, checked; an error names the file, the row, counted from 0, and what to do ``again``."""

    path: Path
    again: ClassVar[str]

    def fault(self, problem: str) -> FileError:
        """The error of the file."""
        return FileError(self.path, f"{problem}; {self.again}")

    def refuse(self, wrong: BoolArray, problem: str, rows: IntArray | None = None) -> None:
        """Raise FileError at the first row that is ``wrong`` [N], of all rows or of ``rows`` [N]."""
        if wrong.any():
            row = int(wrong.argmax()) if rows is None else int(rows[wrong.argmax()])
            raise self.fault(f"row {row}: {problem}")

    def refuse_twice(self, problem: str, rows: IntArray, *keys: IntArray) -> None:
        """Raise FileError at the first of ``rows`` [N] whose ``keys`` [N] an earlier one has, too."""
        found = first_repetition(*keys)
        if found is not None:
            raise self.fault(f"row {rows[found[1]]}: {problem}")

    def refuse_rotations(self, quaternions: FloatArray, name: str, rows: IntArray | None = None) -> None:
        """Raise FileError where the length of quaternions [N, 4] is not 1 up to rounding."""
        wrong = np.abs(np.linalg.norm(quaternions, axis=-1) - 1.0) > 0.01
        self.refuse(wrong, f"{name} no rotation: its length is not 1", rows)

    def refuse_sizes(self, sizes: FloatArray, rows: IntArray) -> None:
        """Raise FileError where sizes [N, 3] in m are not those of a person."""
        wrong = np.asarray(((sizes <= 0.0) | (sizes > TALLEST)).any(axis=-1))
        self.refuse(wrong, f"no person is so large or small (0 to {TALLEST:g} m)", rows)

    @contextmanager
    def of_row(self, row: int) -> Iterator[None]:
        """A context in which a ValueError becomes the FileError of a row."""
        try:
            yield
        except ValueError as error:
            raise self.fault(f"row {row}: {error}") from error


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A camera on a car.

    Parameters
    ----------
    rotation : [3, 3] from the camera's axes to the car's.
    origin : [3] its position in the car's axes, in m.
    camera : its model, with the pitch, roll and mount height that follow from these.
    distortion : of its raw pictures; ``None`` where they have none.
    """

    rotation: FloatArray
    origin: FloatArray
    camera: Camera
    distortion: Distortion | None = None


@dataclass(frozen=True, kw_only=True)
class Cuboids:
    """Labelled people of a recording, a row for each in each frame.

    Parameters
    ----------
    frame, person : [N] frame, and the person's number from 0.
    centres, rotations, sizes : [N, 3] m, [N, 3, 3] and [N, 3] m (length, width, height) in the world, x y z with z up.
    visible : [N] visible fraction in (0, 1]; 0 where the person is hidden.
    """

    frame: IntArray
    person: IntArray
    centres: FloatArray
    rotations: FloatArray
    sizes: FloatArray
    visible: FloatArray


@dataclass(frozen=True, kw_only=True)
class CarMotion:
    """Poses of a car: ``rotations`` [T, 3, 3] from its axes to the world's, and ``origins`` [T, 3] in m."""

    rotations: FloatArray
    origins: FloatArray


@dataclass(frozen=True, kw_only=True)
class CarRecording:
    """One recording of a car.

    Parameters
    ----------
    name : name of the recording.
    sensors : the chosen cameras, by name.
    motions : the car's poses at the exposures of each camera.
    cuboids : the labelled people.
    digests : SHA-256 of the recording's files, by kind of file; empty where recordings share files.
    """

    name: str
    sensors: Mapping[str, Sensor]
    motions: Mapping[str, CarMotion]
    cuboids: Cuboids
    digests: Mapping[str, str]


def rotation_matrices(quaternions: FloatArray) -> FloatArray:
    """[N, 3, 3] rotations of quaternions [N, 4] (w, x, y, z), which need not be of length 1."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix())


def between(quaternions: FloatArray, later: FloatArray, share: FloatArray) -> FloatArray:
    """Quaternions [N, 4] interpolated linearly, for small turns, at a ``share`` [N] of the way to ``later`` ones."""
    sign = np.where((quaternions * later).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return quaternions + share[:, None] * (sign * later - quaternions)


def rows_by_group(groups: IntArray, count: int) -> list[IntArray]:
    """The rows of each of the first ``count`` groups, ascending."""
    order = np.argsort(groups, kind="stable")
    return np.split(order, np.searchsorted(groups[order], np.arange(1, count + 1)))[:count]


def motion_at(times: FloatArray, known: FloatArray, quaternions: FloatArray, origins: FloatArray) -> CarMotion:
    """The car's motion at ``times`` [T], interpolated between poses at ``known`` times [M], ascending."""
    last = np.searchsorted(known, times, side="left").clip(1, max(len(known) - 1, 1))
    after = np.minimum(last, len(known) - 1)
    gap = known[after] - known[last - 1]
    share = np.where(gap > 0.0, (times - known[last - 1]) / np.where(gap > 0.0, gap, 1.0), 0.0).clip(0.0, 1.0)
    placed = origins[last - 1] + share[:, None] * (origins[after] - origins[last - 1])
    turned = rotation_matrices(between(quaternions[last - 1], quaternions[after], share))
    return CarMotion(rotations=turned, origins=placed)


def pinhole(rotation: FloatArray, origin: FloatArray, ground: float, intrinsics: Mapping[str, float]) -> Sensor:
    """A camera of a car whose origin is ``ground`` m above the road.

    Parameters
    ----------
    intrinsics : ``width``, ``height``, ``fx``, ``fy``, ``cx``, ``cy`` in px, and coefficients ``k1``, ``k2``, ``k3``.
    """
    square = intrinsics["fx"] == intrinsics["fy"]
    camera = PerspectiveCamera(
        width=int(intrinsics["width"]),
        height=int(intrinsics["height"]),
        focal=intrinsics["fx"],
        vertical_focal=None if square else intrinsics["fy"],
        cx=intrinsics["cx"],
        cy=intrinsics["cy"],
        mount_height=float(origin[2] + ground),
        pitch=float(np.arcsin(np.clip(rotation[2, 2], -1.0, 1.0))),
        roll=float(np.arctan2(-rotation[2, 0], -rotation[2, 1])),
    )
    bends = {name: intrinsics.get(name, 0.0) for name in ("k1", "k2", "k3")}
    distortion = Distortion(model="opencv", **bends) if any(bends.values()) else None
    return Sensor(rotation=rotation, origin=origin, camera=camera, distortion=distortion)


def panorama(origins: FloatArray, ground: float) -> Sensor:
    """The ring of cameras at ``origins`` [C, 3] as one level panorama in their middle."""
    origin = origins.mean(axis=0)
    camera = PanoramaCamera(
        width=PANORAMA_WIDTH,
        focal=PANORAMA_WIDTH / (2.0 * np.pi),
        cy=480.0,
        mount_height=float(origin[2] + ground),
    )
    level = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    return Sensor(rotation=level, origin=origin, camera=camera)


def project(cuboids: Cuboids, motion: CarMotion, sensor: Sensor) -> FloatArray:
    """Boxes [N, 4] (left, top, width, height) in px around the corners of cuboids, cut at the picture's borders.

    NaN for hidden people, those farther than `FARTHEST`, those not wholly in front of the camera, and boxes with their
    middle outside the picture.
    """
    camera, turns = sensor.camera, sensor.rotation.T @ motion.rotations.transpose(0, 2, 1)
    shifts = -(turns @ motion.origins[..., None])[..., 0] - sensor.rotation.T @ sensor.origin
    around = cuboids.frame, cuboids.centres, cuboids.rotations, cuboids.sizes
    found = _core.project_cuboids(*around, turns, shifts, *_projection(camera), BEHIND)
    left, top, right, bottom = found.T
    away = cuboids.centres - motion.origins[cuboids.frame]
    ahead, aside = (np.einsum("ni,ni->n", motion.rotations[cuboids.frame, :, axis], away) for axis in (0, 1))
    shown = (cuboids.visible > 0.0) & (ahead**2 + aside**2 < FARTHEST**2)
    if camera.period is None:
        width, height = camera.picture_size
        shown &= (left + right >= 0.0) & (left + right < 2.0 * width)
        shown &= (top + bottom >= 0.0) & (top + bottom < 2.0 * height)
    found = cut_to_picture(np.stack([left, top, right - left, bottom - top], axis=-1), camera)
    return np.where(shown[:, None], found, np.nan)


def _projection(camera: Camera) -> tuple[tuple[float, float, float, float], bool]:
    """The intrinsics fx, fy, cx, cy of a camera in px, and whether it is a cylinder."""
    if camera.intrinsics is not None:
        (fx, _, cx), (_, fy, cy) = camera.intrinsics[:2].tolist()
        return (fx, fy, cx, cy), False
    width, (focal, row) = camera.picture_size[0], np.asarray(camera.cylinder, np.float64).tolist()
    return (width / (2.0 * np.pi), focal, 0.5 * width, row), True


def footage_of(one: CarRecording, name: str, sensor_name: str) -> tuple[Footage, FloatArray]:
    """The footage of one camera, and the boxes [T, P, 4] (left, top, width, height) in px of all labelled people."""
    sensor, motion, cuboids = one.sensors[sensor_name], one.motions[sensor_name], one.cuboids
    frames, count = len(motion.origins), int(cuboids.person.max(initial=-1)) + 1
    at = cuboids.frame, cuboids.person
    feet = cuboids.centres[:, :2] - 0.5 * cuboids.sizes[:, 2:] * cuboids.rotations[:, :2, 2]
    values = project(cuboids, motion, sensor), cuboids.visible, feet
    boxes, visible, places = (laid_out((frames, count), at, one) for one in values)
    visible[np.isnan(boxes[..., 0])] = np.nan
    heights = medians(cuboids.sizes[:, 2], cuboids.person, count)
    eyes = motion.origins + motion.rotations @ sensor.origin
    ahead = motion.rotations @ sensor.rotation[:, 2]
    seen = ~np.isnan(boxes[..., 0]).all(axis=0)
    footage = Footage(
        name=name,
        camera=sensor.camera,
        dt=DT,
        tracks=np.flatnonzero(seen),
        boxes=observations_of(boxes[:, seen], sensor.camera),
        visible=visible[:, seen],
        poses=np.column_stack([eyes[:, :2], np.arctan2(ahead[:, 1], ahead[:, 0])]),
        scene=Scene(name=name, dt=DT, people=np.arange(count), positions=places, heights=heights),
    )
    return footage, boxes


@dataclass(frozen=True, kw_only=True)
class CuboidSplit(FootageSplit):
    """Base of the splits whose people are cuboids around a car; see `FootageSplit`.

    A sequence has at least three people with boxes near the camera in each frame.

    Parameters
    ----------
    near, lasting : greatest distance in m of these people, and least duration of a sequence in s.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL | {"boxes", "person_class", "cameras"}

    rules: RunRules = field(default_factory=RunRules)
    pixel_std: float = 1.0
    near: float = NEAR
    lasting: float = LASTING

    @abstractmethod
    def read(self, source: Path | None, names: tuple[str, ...] | None, cameras: tuple[str, ...]) -> list[CarRecording]:
        """The recordings of these names, or those of the parts of these names; all without any."""

    def plan(self, options: Options) -> FootageSequences:
        """See `FootageSplit.plan`."""
        asked = options.footage or FootageOptions()
        seconds = DT * (asked.every or self.every)
        longest = asked.longest or round(LONGEST / seconds)
        shortest = min(max(round(self.lasting / seconds), 5), longest)
        rules = replace(self.rules, shortest=shortest, longest=longest)
        return FootageSplit.plan(replace(self, rules=rules), options)

    @property
    def counted_where(self) -> str:
        """See `FootageSplit.counted_where`."""
        return f" within {self.near:g} m"

    def counted(self, one: Footage) -> BoolArray:
        """See `FootageSplit.counted`: boxes of people near the camera."""
        positions, _ = one.positions()
        away = np.full(positions.shape, np.nan) if one.poses is None else positions - one.poses[:, None, :2]
        return one.observed & (np.hypot(away[..., 0], away[..., 1]) < self.near)

    def recordings(self, options: Options) -> Recordings:
        """See `FootageSplit.recordings`."""
        asked = options.footage or FootageOptions()
        cameras = asked.cameras or (PANORAMA,)
        read = self.read(options.source, asked.sequences, cameras)
        several = len(read) * len(cameras) > 1
        footage: list[Footage] = []
        found: dict[str, FoundTracks] = {}
        sums: dict[str, dict[str, str]] = {}
        for one in read:
            sums |= {one.name: dict(one.digests)} if one.digests else {}
            for camera in cameras:
                name = one.name if len(cameras) == 1 else f"{one.name}.{camera}"
                seen, boxes = footage_of(one, name, camera)
                if asked.boxes is not None:
                    path = file_for(asked.boxes, name, several)
                    tracks = _found(path, boxes, one.sensors[camera], asked.person_class)
                    seen = replace(seen, **tracks.seen)
                    found[name] = tracks
                    sums.setdefault(name, {})["boxes"] = file_sha256(path)
                footage.append(seen)
        facts = {one.name: _facts(one) for one in footage}
        for name, tracks in found.items():
            facts[name] |= tracks.agreements
        return Recordings(
            footage=tuple(footage),
            definition={
                "files": sums,
                "cameras": list(cameras),
                "near": self.near,
                "farthest": FARTHEST,
                **asked.classes,
            },
            calibration={"summary": _summary(facts), "recordings": facts},
            pixel_std=None if asked.boxes is None else FOUND_PIXEL_STD,
            carried_by="vehicle",
            box_edge=NEAR_EDGE if asked.boxes is None else None,
        )


def _found(path: Path, boxes: FloatArray, sensor: Sensor, person_class: str | None) -> FoundTracks:
    """Tracks of the boxes in a file, without the lens's distortion."""
    size = sensor.camera.picture_size
    rows = read_found(path, len(boxes), DT, size, person_class)
    straight, _ = straight_rows(rows, sensor.distortion, sensor.camera.intrinsics)
    return follow(straight, boxes, np.arange(boxes.shape[1]), sensor.camera, DT, size=size)


def _facts(one: Footage) -> dict[str, Any]:
    """A row of the dataset's table of recordings: camera motion, crowd density and speeds."""
    poses, places = np.asarray(one.poses), one.positions()[0]
    driven = float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum())
    second = round(1.0 / DT)
    speeds = np.hypot(*np.moveaxis(places[second:] - places[:-second], -1, 0))
    return {
        "camera": "stands" if driven < STANDS else "moves",
        "driven": round(driven, 1),
        "people": round(float(one.observed.sum(axis=1).mean()), 1),
        "speed": round(float(np.nanmedian(speeds)), 2) if np.isfinite(speeds).any() else None,
    }


def _summary(facts: Mapping[str, Mapping[str, Any]]) -> str:
    moving = [row for row in facts.values() if row["camera"] == "moves"]
    people = [row["people"] for row in facts.values()]
    text = f"recordings: {len(facts)}, the camera moves in {len(moving)}"
    if moving:
        text += f" ({np.mean([row['driven'] for row in moving]):.0f} m on average)"
    return f"{text}; {np.mean(people):.1f} people a frame; boxes are projections of cuboids" if people else text


@cache
def _rules() -> dict[str, dict[str, Any]]:
    return bundled_table("vbbench_generators.footage", "parts.toml")


def part_of(split: str, name: str, folder: str = "") -> Part:
    """The part of the official lists that a recording belongs to, by the rule in ``parts.toml``.

    Parameters
    ----------
    folder : of the recording, for data sets that are parted by folders.
    """
    rule = _rules()[split]
    if name in rule["seen"]:
        return "tune"
    number = int(digits) if (digits := name.rpartition("-")[2]).isdigit() else -1
    if folder in rule.get("test_folders", ()) or any(a <= number <= b for a, b in rule.get("test_numbers", ())):
        return "test"
    if folder not in rule.get("train_folders", (folder,)):
        folders = ", ".join((*rule["train_folders"], *rule["test_folders"]))
        raise VbbenchError(f"{split}: '{name}' is in no part: its folder is '{folder}', not one of {folders}")
    digest = hashlib.sha256(f"{split}/{name}".encode()).hexdigest()
    return "tune" if digest[0] in rule["tune_digits"] else "train"


def chosen(split: str, names: Iterable[str] | None, known: Mapping[str, str]) -> list[str]:
    """The recordings called ``names``, by recording or by part (`PARTS`); all if that is ``None``.

    Parameters
    ----------
    known : recording → its folder.
    """
    found: list[str] = []
    for name in names or ():
        part = [one for one in known if part_of(split, one, known[one]) == name] if name in PARTS else [name]
        if not part:
            raise SourceMissingError(f"{split}: none of the {len(known)} recordings here is of the part '{name}'")
        found += part
    return named(f"recording of {split}", found, known)
