"""A recording of JRDB, a robot with a 360° camera among people: its labels, times and motion put together."""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import observations_of, rectangles
from vbbench.camera import PanoramaCamera
from vbbench.errors import FileError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, nearest
from vbbench.exchange.matching import frame_offset, in_columns, match_tracks
from vbbench.files.dataset_info import Pictures
from vbbench.generation.footage import Footage
from vbbench.geometry import BoolArray, FloatArray, IntArray, relative_to_world, wrap_angle
from vbbench.scene import Scene
from vbbench_generators.footage.jrdb.labels import PlaceLabels, are_results, read_tracked_boxes
from vbbench_generators.footage.jrdb.motion import RATE, Grid, Stamps
from vbbench_generators.footage.odometry_filter import RobotMotion
from vbbench_generators.footage.split import laid_out, medians, pictures_in
from vbbench_generators.footage.tracks import LEAST_OVERLAP, MOST_STRAY, FoundTracks, follow, read_found

CAMERA = PanoramaCamera(width=3760, focal=482.9, cy=209.4, mount_height=1.03)
"""The stitched panorama, 3760 × 480: columns run clockwise from behind, rows v = 209.4 + 482.9·y/√(x² + z²).

Rows are those of the medians over its cameras, as JRDB's toolkit projects; the height is the sample's: the median over
boxes that are not cut and as high as their person (±7 %), 1.03 m, with ±.05 m within it.
"""

SIZE = (CAMERA.width, 480)
"""Of its pictures."""

LARGEST_DIRECTION_ERROR = 0.2
"""rad between boxes and labelled places, at the median: .02 rad in the sample."""

MOST_FARTHER = 2.0
"""Places may be so many times as far away, or as near, as boxes are high, at the median: .96 times in the sample."""

_LEAST_FIT = 0.3
"""Overlap in columns that boxes and places must have in other frames, for these to be named."""

_FEWEST, _FEW = 20, 0.5
"""Boxes with a labelled place that a recording needs, and the share below which a person should look."""


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Labels of one recording, on the slots of a grid of frames.

    Parameters
    ----------
    name : JRDB's name of the recording.
    tracks, people : [K] ids of boxes, and [P] ids of places.
    boxes : [T, K, 3] (u, v, l) in px, NaN = not seen.
    visible, rectangles : [T, K] visible fractions and [T, K, 4] (left, top, width, height) in px of the boxes.
    places : [T, P, 2] in m forward and left of the robot, NaN = not labelled.
    heights : [P] in m.
    persons : [T, K] ids of the people in boxes, `NOBODY` = unknown; ``None`` where tracks are people.
    """

    name: str
    grid: Grid
    tracks: IntArray
    people: IntArray
    boxes: FloatArray
    visible: FloatArray
    rectangles: FloatArray
    places: FloatArray
    heights: FloatArray
    persons: IntArray | None = None

    @property
    def relative(self) -> FloatArray:
        """[T, P, 2] the places in m right and forward of the robot."""
        return np.stack([-self.places[..., 1], self.places[..., 0]], axis=-1)

    @property
    def expected(self) -> FloatArray:
        """[T, P, 4] boxes (left, top, width, height) in px that the labelled places predict."""
        return rectangles(CAMERA.project_unbounded(self.relative, np.broadcast_to(self.heights, self.places.shape[:2])))

    @property
    def columns(self) -> IntArray:
        """[T, K] index of each track's person among ``people``, −1 = none."""
        persons = np.broadcast_to(self.tracks, self.visible.shape) if self.persons is None else self.persons
        if not len(self.people):
            return np.full(persons.shape, -1)
        column = np.searchsorted(self.people, persons).clip(max=len(self.people) - 1)
        return np.where(self.people[column] == persons, column, -1)

    @property
    def step(self) -> int:
        """The commonest number of slots from a frame with boxes to the next."""
        filled = np.flatnonzero((~np.isnan(self.visible)).any(axis=1))
        return int(np.median(np.diff(filled))) if len(filled) > 1 else 1

    def follow(self, path: Path, person_class: str | None = None) -> FoundTracks:
        """Boxes of a detector or tracker, matched to those labelled.

        The file holds results of a tracker on JRDB, or any format of `birdify`; frame 1 of MOTChallenge text is picture
        000000.
        """
        frames = int(self.grid.frames[-1]) + 1
        if are_results(path):
            found = read_tracked_boxes(path).within(frames)
        else:
            found = read_found(path, frames, 1.0 / RATE, SIZE, person_class)
        slots = self.grid.slot_of(found.frame)
        found = replace(found, frame=slots).select(slots >= 0)
        return follow(found, self.rectangles, self.tracks, CAMERA, 1.0 / RATE, size=SIZE)

    def footage(
        self, motion: RobotMotion | None, *, stands: bool, pictures: Path | None, found: FoundTracks | None = None
    ) -> Footage:
        """The footage, with poses and odometry where the robot's ``motion`` was measured, or where it ``stands``.

        Parameters
        ----------
        pictures : folder of the stitched pictures.
        found : tracks in place of the labelled ones.
        """
        seen: dict[str, Any] = {name: getattr(self, name) for name in ("tracks", "boxes", "visible", "persons")}
        if found is not None:
            seen = found.seen
        poses = np.zeros((len(self.boxes), 3)) if stands else None
        poses = poses if motion is None else motion.poses
        positions = self.relative if poses is None else relative_to_world(self.relative, poses)
        scene = Scene(name=self.name, dt=1.0 / RATE, people=self.people, positions=positions, heights=self.heights)
        return Footage(
            name=self.name,
            camera=CAMERA,
            dt=1.0 / RATE,
            **seen,
            poses=poses,
            scene=scene,
            odometry=None if motion is None else motion.odometry,
            pictures=self._pictures(pictures),
        )

    def _pictures(self, folder: Path | None) -> Pictures | None:
        """The pictures; ``None`` if frames are missing, so that their numbers are not proportional to time."""
        first = int(self.grid.frames[0])
        if folder is None or np.any(self.grid.slots != self.grid.frames - first):
            return None
        return pictures_in(folder, "{:06d}.jpg", first)


def assemble(
    name: str, pictures: BoxRows, places: PlaceLabels, grid: Grid, clouds: IntArray, *, same_ids: bool = True
) -> Recording:
    """Put labels on the slots of their frames.

    Parameters
    ----------
    clouds : [T] number of the point cloud taken with the picture of each slot, −1 = none.
    same_ids : whether ids of boxes are those of places; otherwise they are paired by their directions.
    """
    pictures = _inside_pictures(pictures)
    slots = grid.slot_of(pictures.frame)
    if np.any(slots < 0):
        frame = int(pictures.frame[(slots < 0).argmax()])
        raise FileError(pictures.path, f"picture {frame:06d}.jpg is labelled, but has no time stamp")
    tracks, column = np.unique(pictures.track, return_inverse=True)
    shape, at = (len(grid.times), len(tracks)), (slots, column)
    visible, whole = laid_out(shape, at, pictures.visible), laid_out(shape, at, pictures.boxes)
    people, points, heights = _on_slots(places, clouds)
    found = Recording(
        name=name,
        grid=grid,
        tracks=tracks,
        people=people,
        boxes=observations_of(whole, CAMERA),
        visible=visible,
        rectangles=whole,
        places=points,
        heights=heights,
    )
    if not same_ids:
        found = replace(found, persons=_in_the_same_direction(found))
    _check_places(found, places.path)
    return found


def _in_the_same_direction(recording: Recording) -> IntArray:
    """[T, K] the person nearest in direction to each box; heights are not compared, since furniture hides legs."""
    seen, expected = in_columns(recording.rectangles), in_columns(recording.expected)
    return match_tracks(seen, expected, recording.people, CAMERA, least=LEAST_OVERLAP, staying=True)


def nearest_clouds(grid: Grid, clouds: Stamps) -> IntArray:
    """[T] number of the point cloud taken nearest to each slot, −1 where none is within half a slot."""
    if not len(clouds.frames):
        return np.full(len(grid.times), -1)
    row = nearest(clouds.times, grid.times)
    close = np.abs(clouds.times[row] - grid.times) <= 0.5 * grid.seconds
    return np.where(close, clouds.frames[row], -1)


def direction_errors(recording: Recording) -> FloatArray:
    """[N] angle in rad, clockwise, from the direction of each labelled place to that of its box."""
    boxes, places = _pairs(recording)
    seen = CAMERA.unproject(boxes, np.ones(len(boxes)))
    return wrap_angle(np.arctan2(seen[:, 0], seen[:, 1]) + np.arctan2(places[:, 1], places[:, 0]))


def _on_slots(places: PlaceLabels, clouds: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """People [P], their places [T, P, 2] and median heights [P]."""
    people, column = np.unique(places.track, return_inverse=True)
    order = np.argsort(clouds, kind="stable")
    first = np.searchsorted(clouds[order], places.frame)
    last = np.searchsorted(clouds[order], places.frame, side="right")
    used = first < last  # where two slots have the same cloud, the first one takes it
    points = laid_out((len(clouds), len(people)), (order[first[used]], column[used]), places.places[used])
    return people, points, medians(places.heights, column, len(people))


def _inside_pictures(pictures: BoxRows) -> BoxRows:
    """Boxes with their centre in the picture; refuses the file if many are outside."""
    middle = pictures.boxes[:, 1] + 0.5 * pictures.boxes[:, 3]
    outside = (middle < 0.0) | (middle > SIZE[1])
    if not outside.any():
        return pictures
    row, count = int(outside.argmax()), int(outside.sum())
    problem = (
        f"picture {pictures.frame[row]:06d}.jpg: the middle of the box of person {pictures.track[row]} is in row "
        f"{middle[row]:.0f} of {SIZE[1]}, as are {count} of {len(outside)} outside"
    )
    if count > MOST_STRAY * len(outside):
        raise FileError(pictures.path, f"{problem}; boxes must be in px of the stitched pictures")
    warnings.warn(VbbenchWarning(f"{pictures.path}: {problem}; these are removed"), stacklevel=2)
    return pictures.select(~outside)


def _check_places(recording: Recording, path: Path) -> None:
    """Refuse places that disagree with the boxes, and warn if few match."""
    boxes, places = _pairs(recording)
    labelled = int((~np.isnan(recording.visible)).sum())
    if len(boxes) < _FEWEST:
        raise FileError(path, f"only {len(boxes)} boxes of {recording.name} have a labelled place; are ids the same?")
    off = float(np.median(np.abs(direction_errors(recording))))
    seen, expected = in_columns(recording.rectangles), in_columns(recording.expected)
    own = recording.columns if recording.persons is None else None
    offset = frame_offset(seen, lambda frames, later: expected[frames + later], CAMERA.period, own, least=_LEAST_FIT)
    if off > LARGEST_DIRECTION_ERROR:
        problem = f"places lie {off:.2f} rad off their boxes (median; {LARGEST_DIRECTION_ERROR} at most)"
        cause = str(offset) if offset else "they must be in the robot's frame, x forward, y left"
        raise FileError(path, f"{problem}: {cause}")
    if offset is not None:
        warnings.warn(VbbenchWarning(f"{path}: {offset}"), stacklevel=2)
    farther = float(np.median(np.hypot(*places.T) * boxes[:, 2])) / (CAMERA.focal * float(np.median(recording.heights)))
    if not 1.0 / MOST_FARTHER <= farther <= MOST_FARTHER:
        problem = f"places are {farther:.3g} times as far away as boxes so high say (median)"
        raise FileError(path, f"{problem}: they and people's heights must be in m")
    if len(boxes) < _FEW * labelled:
        problem = f"only {len(boxes)} of {labelled} boxes of {recording.name} have a labelled place"
        warnings.warn(VbbenchWarning(f"{path}: {problem}; the others are not scored"), stacklevel=2)


def _pairs(recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Boxes [N, 3] and places [N, 2] of the same person in the same frame."""
    columns = recording.columns
    if not len(recording.people):
        return np.empty((0, 3)), np.empty((0, 2))
    places = np.take_along_axis(recording.places, columns.clip(min=0)[..., None], axis=1)
    paired: BoolArray = (columns >= 0) & ~np.isnan(recording.visible) & ~np.isnan(places[..., 0])
    return recording.boxes[paired], places[paired]
