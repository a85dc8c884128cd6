"""A recording of the user's own: its files as `Footage`, with notes on whatever does not look right."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vbbench.boxes import observations_of, rectangles
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.axes import Axes
from vbbench.exchange.box_tables import scores_as_shares
from vbbench.exchange.detection import TrackerFactory, link
from vbbench.exchange.matching import FrameOffset, frame_offset, in_columns, match_tracks
from vbbench.exchange.own.box_files import OwnBoxes, read_boxes
from vbbench.exchange.own.camera_file import OwnCamera, read_camera
from vbbench.exchange.own.distortion import straighten_boxes
from vbbench.exchange.own.motion_files import compare_turns, read_odometry, read_poses
from vbbench.exchange.own.people_file import read_people
from vbbench.exchange.own.plausibility import box_noise, fitting, frame_seconds, gaps
from vbbench.exchange.own.timing import Timeline
from vbbench.files.dataset_info import Pictures
from vbbench.files.tables import content_sha256
from vbbench.generation.footage import Footage, Recordings
from vbbench.geometry import FloatArray, IntArray, shorter_way, world_to_relative
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.sequence import NOBODY

CAMERA, BOXES = "camera.toml", ("boxes.csv", "gt.txt", "det.txt", "gt/gt.txt", "det/det.txt")
POSES, ODOMETRY, PEOPLE = "poses.txt", "odometry.txt", "people.csv"
"""Names of the files in a folder; the first of `BOXES` that is there counts."""
FEWEST_FRAMES = 5
MOST_CELLS = 50_000_000
"""Frames times tracks that fit into memory."""
LEAST_NOISE, ASSUMED_NOISE = 1.0, 2.0
"""Noise in px of a box that is never fallen below, and that is assumed where it cannot be measured."""
LEAST_FIT, GOOD_FIT = 0.1, 0.9
"""Shares of boxes that must, and should, be about where the box of their person is expected."""
FITTING = 0.5
"""Overlap in columns that boxes and people must have in other frames, for these to be named."""
_ELSEWHERE = "are axes, units and clock those of docs/own.md?"


@dataclass(frozen=True, kw_only=True)
class RecordingFiles:
    """Where a recording is, and in which axes its odometry; ``None`` = there is none, or its motion shows them."""

    name: str
    camera: Path
    boxes: Path
    poses: Path | None = None
    odometry: Path | None = None
    people: Path | None = None
    odometry_axes: Axes | None = None

    @property
    def digests(self) -> dict[str, str]:
        """SHA-256 of every file, by what it is."""
        parts = ("camera", "boxes", "poses", "odometry", "people")
        return {part: content_sha256(path) for part in parts if (path := getattr(self, part)) is not None}


@dataclass(frozen=True, kw_only=True)
class OwnRecording:
    """What was read of a recording.

    Parameters
    ----------
    footage : the recording.
    timeline : when its frames were taken.
    files : where it was read.
    own : its camera file.
    pixel_std : noise in px of boxes, stated or measured.
    notes : what the user should know, a line each.
    rows : the boxes of people as they are in the file.
    """

    footage: Footage
    timeline: Timeline
    files: RecordingFiles
    own: OwnCamera
    pixel_std: float
    notes: tuple[str, ...]
    rows: OwnBoxes


def boxes_in(folder: Path) -> Path | None:
    """The file of boxes in a folder, such as one of MOTChallenge; ``None`` if there is none."""
    return next((path for name in BOXES if (path := folder / name).is_file()), None)


def files_in(folder: Path, *, boxes: Path | None = None, poses: Path | None = None) -> RecordingFiles:
    """The files of a recording in a folder; ``boxes`` and ``poses`` are taken in place of its own.

    Raises
    ------
    FileError
        If camera or boxes are missing.
    """
    found = boxes or boxes_in(folder)
    if not (folder / CAMERA).is_file():
        raise FileError(folder / CAMERA, "the file is missing; docs/own.md says what to write")
    if found is None:
        raise FileError(folder, f"holds no boxes; write {', '.join(BOXES[:-1])} or {BOXES[-1]}")
    beside = {name: path if (path := folder / name).is_file() else None for name in (POSES, ODOMETRY, PEOPLE)}
    return RecordingFiles(
        name=folder.resolve().name,
        camera=folder / CAMERA,
        boxes=found,
        poses=poses or beside[POSES],
        odometry=beside[ODOMETRY],
        people=beside[PEOPLE],
    )


def read_recording(
    files: RecordingFiles,
    *,
    dt: float | None = None,
    pictures: Pictures | None = None,
    mount: Mapping[str, float | str] | None = None,
    person_class: int | str | None = None,
) -> OwnRecording:
    """Read a recording.

    Parameters
    ----------
    files : where it is.
    dt : seconds per frame where the camera file does not say it, such as those of a film.
    pictures : where the pictures are.
    mount : keys that the camera file leaves out, such as ``mount_height`` and ``carried_by``.
    person_class : class of people in the boxes, where the file does not show it.

    Raises
    ------
    FileError
        If a file cannot be used: it is named, with the line and what to do.
    """
    own = read_camera(files.camera, mount)
    seconds = frame_seconds(files.boxes, own, dt)
    read = read_boxes(files.boxes, seconds, picture=own.facts.picture, person_class=person_class)
    rows, misfits = fitting(read, own)
    timeline, notes = rows.timeline, [*own.notes, *rows.timeline.notes, *rows.notes, *misfits]
    linked_here = not rows.linked
    if linked_here:
        rows, linking = _linked(rows, own)
        notes.append(linking)
    rows, straightening = _straight(rows, own)
    notes += straightening
    tracks, boxes, visible = _dense(rows, own)
    notes += gaps(~np.isnan(boxes[..., 2]), timeline.dt)
    scene, odometry = None, None
    poses = None
    if files.poses is not None:
        poses, remarks = read_poses(files.poses, timeline)
        notes += remarks
    if files.people is not None:
        scene, lost = read_people(files.people, files.name, timeline, posed=poses is not None, ids=rows.ids)
        notes += lost
    if files.odometry is not None:
        facts = own.facts.odometry
        facts = facts if files.odometry_axes is None else replace(facts, axes=files.odometry_axes)
        odometry, remarks = read_odometry(files.odometry, timeline, facts)
        notes += (*remarks, *compare_turns(files.odometry, odometry.motions, boxes, own.camera))
    footage = Footage(
        name=files.name,
        camera=own.camera,
        dt=timeline.dt,
        tracks=tracks,
        boxes=boxes,
        visible=visible,
        poses=poses,
        scene=scene,
        odometry=odometry,
        pictures=pictures,
    )
    if scene is not None and files.people is not None:
        footage, fit = _with_persons(footage, scene, own.facts.height_mean, files.people, linked_here)
        notes += fit
    noise = _noise(boxes, own)
    return OwnRecording(
        footage=footage, timeline=timeline, files=files, own=own, pixel_std=noise, notes=tuple(notes), rows=read
    )


def as_recordings(read: Sequence[OwnRecording]) -> Recordings:
    """One or several of them as a split of footage wants them.

    Raises
    ------
    VbbenchError
        If their camera files differ in what solvers are given of people, of boxes or of what carries the camera.
    """
    shared = ("height_mean", "height_std", "carried_by", "box_edge")
    for name in shared:
        if len({getattr(one.own.facts, name) for one in read}) > 1:
            raise VbbenchError(f"camera files differ in {name}; make a dataset of each recording")
    facts = {name: getattr(read[0].own.facts, name) for name in shared}
    worst = max(one.pixel_std for one in read)
    count = "1 recording" if len(read) == 1 else f"{len(read)} recordings"
    return Recordings(
        footage=tuple(one.footage for one in read),
        definition={"recordings": {one.footage.name: one.files.digests for one in read}},
        calibration={
            "summary": f"{count} of the user's own, boxes taken to be off by {worst:g} px",
            "notes": {one.footage.name: list(one.notes) for one in read},
        },
        caution="a recording of somebody's own; nobody has checked its camera file",
        pixel_std=worst,
        **facts,
    )


def _linked(rows: OwnBoxes, own: OwnCamera) -> tuple[OwnBoxes, str]:
    """The tracks that the bundled tracker makes of detections."""
    factory: TrackerFactory = load("tracker", "byte")
    tracker = factory(dt=rows.timeline.dt, period=own.camera.period)
    shares = replace(rows, scores=scores_as_shares(rows.scores))
    linked = link(shares, tracker, np.arange(rows.timeline.frames))
    if not len(linked):
        problem = "has no ids, and the tracker links none of its boxes"
        raise FileError(rows.path, f"{problem}; are frames close in time, and scores from 0 to 1?")
    people = len(np.unique(linked.track))
    return linked, f"boxes without ids: the tracker links {len(linked)} of {len(rows)} of them to {people} tracks"


def _straight(rows: OwnBoxes, own: OwnCamera) -> tuple[OwnBoxes, list[str]]:
    """The boxes without the lens's distortion."""
    if own.facts.distortion is None or own.camera.intrinsics is None:
        return rows, []
    boxes = straighten_boxes(rows.boxes, own.facts.distortion, own.camera.intrinsics)
    kept = np.asarray(np.isfinite(boxes).all(axis=1) & (boxes[:, 2:] > 0.0).all(axis=1))
    lost, count = int((~kept).sum()), len(kept)
    if lost > 0.5 * count:
        problem = (
            f"[distortion] leaves {lost} of {count} boxes without a place in the picture; are these its coefficients?"
        )
        raise FileError(own.path, problem)
    notes = [f"{lost} of {count} boxes are left out: the lens shows them too far from its axis"] if lost else []
    return replace(rows, boxes=boxes).select(kept), notes


def _dense(rows: OwnBoxes, own: OwnCamera) -> tuple[IntArray, FloatArray, FloatArray]:
    """Track ids [K], boxes [T, K, 3] and visible fractions [T, K]."""
    frames, tracks = rows.timeline.frames, len(np.unique(rows.track))
    if frames < FEWEST_FRAMES:
        raise FileError(rows.path, f"has {frames} frames; a map needs {FEWEST_FRAMES} or more")
    if frames * tracks > MOST_CELLS:
        raise FileError(rows.path, f"has {frames:,} frames of {tracks:,} tracks; split the recording")
    certain = np.where(np.isnan(rows.visible), scores_as_shares(rows.scores), rows.visible)
    ids, dense = rows.dense(frames, observations_of(rows.boxes, own.camera), np.clip(certain, 0.01, 1.0))
    return ids, dense[..., :3], dense[..., 3]


def _with_persons(
    footage: Footage, scene: Scene, height_mean: float, path: Path, linked_here: bool
) -> tuple[Footage, list[str]]:
    """The footage with the person behind each track, and a note if their boxes do not fit well where they are.

    Ids of the boxes are those of the people, unless the tracker gave them: then people are matched by overlap.
    """
    heights = np.where(np.isnan(scene.heights), height_mean, scene.heights)
    relative = scene.positions if footage.poses is None else world_to_relative(scene.positions, footage.poses)
    expected = footage.camera.project_unbounded(relative, np.broadcast_to(heights, relative.shape[:2]))
    if linked_here:
        found = rectangles(footage.boxes)
        footage = replace(footage, persons=match_tracks(found, rectangles(expected), scene.people, footage.camera))
    offset = _offset(footage, scene, heights, linked_here)
    _, persons = footage.positions()
    frame, track = np.nonzero((persons != NOBODY) & footage.observed)
    boxes = int(footage.observed.sum())
    if not len(frame):
        how = "overlaps the box that anybody would have" if linked_here else "has the id of a person in its frame"
        raise FileError(path, f"none of {boxes} boxes {how}; {offset or _ELSEWHERE}")
    seen, real = footage.boxes[frame, track], expected[frame, np.searchsorted(scene.people, persons[frame, track])]
    aside = shorter_way(seen[:, 0] - real[:, 0], footage.camera.period)
    near = (np.abs(aside) < 0.5 * seen[:, 2]) & (np.abs(np.log(seen[:, 2] / real[:, 2])) < np.log(1.5))
    share, known = float(near.mean()), len(frame) / boxes
    fit = f"{known:.0%} of {boxes} boxes have a person; {share:.0%} of these are where that person's box would be"
    problem = f"{fit}: are these places in m, x and y of the world of the poses, or (right, forward) without poses?"
    if share < LEAST_FIT:
        raise FileError(path, f"{fit}: {offset}" if offset else problem)
    notes = [fit if offset or share >= FITTING else problem] if min(share, known) < GOOD_FIT else []
    return footage, [*notes, f"{path.name}: {offset}"] if offset else notes


def _offset(footage: Footage, scene: Scene, heights: FloatArray, linked_here: bool) -> FrameOffset | None:
    """By how many frames people are earlier or later than boxes, by the columns that both are in."""

    def expected(frames: IntArray, later: int) -> FloatArray:
        places = scene.positions[frames + later]
        places = places if footage.poses is None else world_to_relative(places, footage.poses[frames])
        return in_columns(
            rectangles(footage.camera.project_unbounded(places, np.broadcast_to(heights, places.shape[:2])))
        )

    columns = None
    if not linked_here:
        place = np.searchsorted(scene.people, footage.tracks).clip(max=len(scene.people) - 1)
        own = np.where(scene.people[place] == footage.tracks, place, -1)
        columns = np.broadcast_to(own, footage.visible.shape)
    return frame_offset(in_columns(rectangles(footage.boxes)), expected, footage.camera.period, columns, least=FITTING)


def _noise(boxes: FloatArray, own: OwnCamera) -> float:
    if own.facts.pixel_std is not None:
        return own.facts.pixel_std
    measured = box_noise(boxes, own.camera.picture_size[0], own.camera.period)
    return ASSUMED_NOISE if measured is None else max(LEAST_NOISE, round(measured, 2))
