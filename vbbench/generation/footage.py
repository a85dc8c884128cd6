"""Footage: what a real camera saw, as boxes, and whatever else was measured with it."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import user_mistakes
from vbbench.files.dataset_checks import Known
from vbbench.files.dataset_info import Pictures
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze
from vbbench.parsing.numbers import Within, check_ranges
from vbbench.scene import Scene
from vbbench.sequence import NOBODY, Odometry, held_persons
from vbbench.solver import Carrier

FOOTAGE = "footage"
"""The tier of datasets of footage."""


@dataclass(frozen=True, kw_only=True)
class Footage:
    """One recording of one camera.

    Parameters
    ----------
    name : what it is called in messages and files.
    camera : the camera; its pictures are free of distortion.
    dt : seconds per frame.
    tracks : [K] integer ids, ascending.
    boxes : [T, K, 3] (u, v, l) in px, NaN = not seen.
    visible : [T, K] visible fraction of each box in (0, 1], or a detector's score; NaN = not seen.
    poses : [T, 3] (x, y, yaw) of the camera in m and rad; ``None`` if they were not measured.
    scene : the people, as many frames as ``boxes``; without ``poses`` their positions are (right, forward) of the
        camera. ``None`` if they were not measured.
    persons : [T, K] the person of the scene behind each track, `NOBODY` for a false alarm; ``None`` where every track
        is the person of the same id.
    odometry : what the camera's bearer measured of its motion.
    pictures : where the pictures are.
    """

    name: str
    camera: Camera
    dt: float
    tracks: IntArray
    boxes: FloatArray
    visible: FloatArray
    poses: FloatArray | None = None
    scene: Scene | None = None
    persons: IntArray | None = None
    odometry: Odometry | None = None
    pictures: Pictures | None = None

    def __post_init__(self) -> None:
        count = len(self.tracks)
        freeze(self, np.int64, tracks=(count,))
        freeze(self, boxes=(None, count, 3))
        frames = len(self.boxes)
        freeze(self, visible=(frames, count))
        if self.poses is not None:
            freeze(self, poses=(frames, 3))
        if self.persons is not None:
            freeze(self, np.int64, persons=(frames, count))
        if self.scene is not None and self.scene.frames != frames:
            raise ValueError(f"the scene has {self.scene.frames} frames, the boxes {frames}")
        if self.odometry is not None and len(self.odometry.motions) != frames:
            raise ValueError(f"odometry has {len(self.odometry.motions)} frames, the boxes {frames}")

    @property
    def frames(self) -> int:
        """Number of frames T."""
        return len(self.boxes)

    @property
    def observed(self) -> BoolArray:
        """[T, K] whether a track has a box in a frame."""
        return ~np.isnan(self.boxes[..., 2])

    @property
    def known(self) -> Known:
        """What is known of the truth."""
        if self.poses is None:
            return "none" if self.scene is None else "relative"
        return "poses" if self.scene is None else "whole"

    def positions(self) -> tuple[FloatArray, IntArray]:
        """Positions [T, K, 2] of the people behind the tracks, in m, and who they are [T, K]; NaN and `NOBODY` else.

        A track stands for a person from a box to its next one.
        """
        persons = np.broadcast_to(self.tracks, self.visible.shape) if self.persons is None else self.persons
        if self.scene is None or not len(self.scene.people):
            return np.full((*persons.shape, 2), np.nan), np.full(persons.shape, NOBODY)
        placed = ~np.isnan(_places(self.scene, persons)[..., 0])
        held = held_persons(np.where(placed, persons, NOBODY), self.observed)
        return _places(self.scene, held), held

    def thinned(self, every: int) -> "Footage":
        """Every ``every``-th frame from the first; the odometry between them is joined."""
        if every == 1:
            return self
        kept = slice(None, None, every)
        tracks = self.observed[kept].any(axis=0)
        scene = self.scene and replace(self.scene, dt=self.dt * every, positions=self.scene.positions[kept])
        pictures = self.pictures and replace(self.pictures, step=self.pictures.step * every)
        return replace(
            self,
            dt=self.dt * every,
            tracks=self.tracks[tracks],
            boxes=self.boxes[kept, tracks],
            visible=self.visible[kept, tracks],
            poses=None if self.poses is None else self.poses[kept],
            scene=scene,
            persons=None if self.persons is None else self.persons[kept, tracks],
            odometry=self.odometry and joined_odometry(self.odometry, every),
            pictures=pictures,
        )


@dataclass(frozen=True, kw_only=True)
class Recordings:
    """What a reader of footage found.

    Parameters
    ----------
    footage : the recordings, every frame of them.
    definition : what they were made from, as JSON: SHA-256 of the files, and the options that changed what was read.
    calibration : what `DatasetInfo.calibration` says of them; its ``summary`` is printed.
    caution : what users must know of these recordings.
    height_mean, height_std : people's heights in m that solvers are given; ``None`` for those of the split.
    pixel_std : noise in px of a box's column, top and bottom that solvers are given; ``None`` for that of the split.
    carried_by, box_edge : what carries the cameras, and the near edge of the source of boxes in m, as
        `vbbench.solver.Problem` has them.
    """

    footage: tuple[Footage, ...]
    definition: dict[str, Any]
    calibration: dict[str, Any] | None = None
    caution: str | None = None
    height_mean: float | None = None
    height_std: float | None = None
    pixel_std: float | None = None
    carried_by: Carrier = "unknown"
    box_edge: float | None = None


def _places(scene: Scene, persons: IntArray) -> FloatArray:
    """[T, K, 2] where the ``persons`` [T, K] of a scene with people in it are, NaN for whoever is none of them."""
    column = np.searchsorted(scene.people, persons).clip(max=len(scene.people) - 1)
    places = np.take_along_axis(scene.positions, column[..., None], axis=1)
    return np.where((scene.people[column] == persons)[..., None], places, np.nan)


def joined_odometry(odometry: Odometry, every: int) -> Odometry:
    """The motion from every ``every``-th frame to the next, NaN where one between was not measured.

    A motion is added in the axes where the one before ended: m = m₁ + R(turn₁) m₂, with P = J₁ P₁ J₁ᵀ + J₂ P₂ J₂ᵀ.
    """
    kept = range(0, len(odometry.motions), every)
    motions, covariances = np.full((len(kept), 3), np.nan), np.full((len(kept), 3, 3), np.nan)
    for row, last in enumerate(kept):
        if row:
            motions[row], covariances[row] = _chained(odometry, range(last - every + 1, last + 1))
    return Odometry(motions=motions, covariances=covariances)


def _chained(odometry: Odometry, frames: range) -> tuple[FloatArray, FloatArray]:
    total, spread = np.zeros(3), np.zeros((3, 3))
    for frame in frames:
        forward, left, turn = odometry.motions[frame]
        cos, sin = np.cos(total[2]), np.sin(total[2])
        turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        step = turned @ np.array([forward, left, turn])
        before = np.eye(3)
        before[:2, 2] = -step[1], step[0]
        spread = before @ spread @ before.T + turned @ odometry.covariances[frame] @ turned.T
        total = total + step
    return total, spread


@dataclass(frozen=True, kw_only=True)
class FootageOptions:
    """What is asked of footage; ``None`` leaves it to the split.

    Raises VbbenchError if a number lies outside its range.

    Parameters
    ----------
    sequences : names of the recordings; ``None`` for all that are there.
    every : only every so many frames.
    longest : frames, of those that are kept, after which a sequence is cut.
    poses : folder or file of the camera's poses, instead of the source's own.
    boxes : folder or file of a detector's or tracker's boxes, instead of the annotated ones.
    person_class : class of people in ``boxes``, by number or name, where the file does not show it.
    cameras : names of cameras of a recording that has several (splits argoverse2, nuscenes).
    bags : folder of the robot's recordings of its motion (split jrdb).
    cyclists : whether people on bicycles count, too (split kitti).
    interpolated : whether boxes between key frames count, too (split jrdb).
    """

    sequences: tuple[str, ...] | None = None
    every: Annotated[int, Within(1, 1000)] | None = None
    longest: Annotated[int, Within(5, 10**6)] | None = None
    poses: Path | None = None
    boxes: Path | None = None
    person_class: str | None = None
    cameras: tuple[str, ...] | None = None
    bags: Path | None = None
    cyclists: bool = False
    interpolated: bool = True

    def __post_init__(self) -> None:
        with user_mistakes():
            check_ranges(self)

    @property
    def classes(self) -> dict[str, str]:
        """What a dataset's definition says of the class of people; nothing where files decide."""
        return {} if self.person_class is None else {"person_class": self.person_class}
