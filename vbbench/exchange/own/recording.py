"""A recording of the user's own: its files as `Footage`, with notes on implausible values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from vbbench.boxes import find_misfit, observations_of, outside_picture, rectangles
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.box_rows import AS_THEY_ARE, Ids, OwnBoxes, Timeline, named_frames, read_boxes
from vbbench.exchange.box_tables import scores_as_shares
from vbbench.exchange.detection import TrackerFactory, link
from vbbench.exchange.matching import frame_offset, in_columns, match_tracks
from vbbench.exchange.own.calibration_files import straight_rows
from vbbench.exchange.own.camera_file import OwnCamera, read_camera
from vbbench.exchange.own.motion_files import compare_turns, read_odometry, read_poses
from vbbench.exchange.sequence_files import picture_facts
from vbbench.exchange.text_tables import read_content, read_table, refuse_missing
from vbbench.exchange.trajectory import Axes
from vbbench.files.dataset_info import Pictures
from vbbench.files.tables import LARGEST_ID, content_sha256
from vbbench.generation.footage import Footage, Recordings
from vbbench.geometry import BoolArray, FloatArray, IntArray, runs_of_true, shorter_way, world_to_relative
from vbbench.parsing.numbers import notes_on_dt
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.sequence import NOBODY

LONGEST_GAP, MOST_EMPTY = 1.0, 0.1
"""Seconds without a box, and the share of frames without one, from which a note says so."""

LEAST_DEGREES = 0.1
"""A pitch that is larger, in rad, may be one in degrees."""


def fitting(rows: OwnBoxes, own: OwnCamera) -> tuple[OwnBoxes, tuple[str, ...]]:
    """The boxes whose middle lies in the picture, and notes."""
    picture, tall = own.facts.picture, own.facts.height_mean
    misfit = find_misfit(rows.boxes, own.camera, picture, tall)
    if misfit is not None and misfit.certain:
        raise FileError(rows.path, misfit.text)
    if misfit is not None and abs(own.facts.pitch) > LEAST_DEGREES and "pitch" in vars(own.camera):
        pitch = float(np.radians(own.facts.pitch))
        if find_misfit(rows.boxes, replace(cast(Any, own.camera), pitch=pitch), picture, tall) is None:
            text = f"pitch = {own.facts.pitch:g} is in rad, and boxes fit so many degrees: write pitch = {pitch:.4g}"
            misfit = misfit._replace(text=text)
    outside = outside_picture(rows.boxes, own.camera, picture)
    lost, shown = int(outside.sum()), f"{picture[0]:g} x {picture[1]:g} px"
    note = f"{lost} of {len(outside)} boxes are dropped: their middle is outside the picture of {shown}"
    return rows.select(~outside), (*([note] if lost else []), *([misfit.text] if misfit else []))


def frame_seconds(boxes: Path, own: OwnCamera, dt: float | None) -> float | None:
    """Seconds per frame by the camera file, by ``dt``, or by MOTChallenge's ``seqinfo.ini`` of a file of boxes."""
    stated, facts = picture_facts(boxes.parent, boxes.parent.parent), own.facts
    seconds = facts.seconds or dt
    stated.refuse_other("the given camera's", (facts.width, facts.height or stated.size[1]), seconds)
    return seconds or (1.0 / stated.rate if stated.rate else None)


def gaps(observed: BoolArray, dt: float) -> tuple[str, ...]:
    """A note on frames in which nobody is seen, [T, K], if there are many of them or many in a row."""
    empty = np.asarray(~observed.any(axis=1))
    runs = runs_of_true(empty)
    longest = runs[np.diff(runs, axis=1)[:, 0].argmax()] if len(runs) else np.zeros(2, np.int64)
    seconds = float(longest[1] - longest[0]) * dt
    if seconds < LONGEST_GAP and empty.mean() < MOST_EMPTY:
        return ()
    most = f"{int(empty.sum())} of {len(empty)} frames have no box (the longest gap is {seconds:.3g} s, from frame"
    return (f"{most} {longest[0]}): nothing but motion priors carries over it",)


def box_noise(boxes: FloatArray, width: float, period: float | None) -> float:
    """Standard deviation in px of the columns, tops and bottoms of boxes [T, K, 3], by their third differences.

    White noise has third differences of variance 20 σ², and walking hardly any. Slow changes, such as a limb that
    sticks out for a second, do not contribute. It is `ASSUMED_NOISE` if there are too few boxes, and no less than
    `LEAST_NOISE`.
    """
    u, v, length = np.moveaxis(boxes, -1, 0)
    edges = np.stack([u, v - 0.5 * length, v + 0.5 * length])
    thirds = np.diff(edges, n=3, axis=1)
    if period is not None:
        thirds[0][np.abs(thirds[0]) > 0.5 * width] = np.nan
    thirds = thirds[np.isfinite(thirds)]
    measured = float(1.4826 * np.median(np.abs(thirds)) / np.sqrt(20.0)) if len(thirds) >= 100 else ASSUMED_NOISE
    return max(LEAST_NOISE, round(measured, 2))


COLUMNS = ("frame", "time", "id", "x", "y", "height")
FASTEST, LEAP = 12.0, 2.0
"""In m/s and m: nobody runs faster, but for the noise of a place."""


def read_people(
    path: Path, name: str, timeline: Timeline, *, posed: bool, ids: Ids = AS_THEY_ARE
) -> tuple[Scene, tuple[str, ...]]:
    """The people of ``people.csv`` (frame or time, id, x, y, height), and notes.

    Positions are in the world of the poses, in m; without poses (right, forward) of the camera. A height that is not
    stated is NaN. Speeds of people are checked only if the camera is ``posed``. ``ids`` are those of the boxes.
    """
    table = read_table(path, read_content(path, "places of people"), COLUMNS, required=("id", "x", "y"))
    refuse_missing(table, [("frame", "time"), ("id",), ("x",), ("y",)])
    if not len(table):
        raise FileError(path, "holds no row")
    found = table["id"]
    if ids.originals is None or ids.originals.dtype.kind != "U":
        numbers = table.numbers("id")
        wrong = (numbers != np.round(numbers)) | (numbers < 0) | ((numbers > LARGEST_ID) & (ids.originals is None))
        table.refuse(wrong, f"id {{0:.19g}} is not a whole number from 0 to {LARGEST_ID}", found)
    frame = named_frames(table, timeline)
    kept = frame >= 0
    if not kept.any():
        times = timeline.times
        raise FileError(path, f"no row is of a frame of the boxes, which are of {times[0]:.10g} to {times[-1]:.10g} s")
    people, column = np.unique(ids.tracks(found)[kept], return_inverse=True)
    whole, table, frame = len(frame), table.select(kept), frame[kept]
    table.refuse_twice("this id already has a place in this frame, in {at}", frame, column)
    places, notes = np.stack([table.scaled("x"), table.scaled("y")], axis=-1), list[str]()
    leaps, moved = _leaps(people[column], timeline.times[frame], places)
    if posed and len(leaps):
        row, far = int(leaps[0]), f"is {moved[0]:.4g} m from its place before, as are {len(leaps)} places"
        which = f"{path.name}, line {table.lines[row]}: id {table['id'][row]} {far}"
        notes.append(f"{which}: are they in m, and are ids not used again?")
    positions, heights = np.full((timeline.frames, len(people), 2), np.nan), np.full(len(people), np.nan)
    positions[frame, column] = places
    stated = table.scaled("height")
    table.refuse((stated < 0.3) | (stated > 3.0), "height is {0:g}; heights of people are in m", stated)
    heights[column[~np.isnan(stated)]] = stated[~np.isnan(stated)]
    if len(table) < whole:
        notes.append(f"{whole - len(table)} of {whole} rows of {path.name} are of no frame of the boxes")
    return Scene(name=name, dt=timeline.dt, people=people, positions=positions, heights=heights), tuple(notes)


def _leaps(track: IntArray, times: FloatArray, places: FloatArray) -> tuple[IntArray, FloatArray]:
    """Rows of places [M, 2] in m, at ``times`` [M] in s, that need a speed above `FASTEST` from the row before of their
    track, in order of tracks and times; and the steps to them in m.
    """
    order = np.lexsort((times, track))
    moved = np.hypot(*np.diff(places[order], axis=0).T)
    leaps = (np.diff(track[order]) == 0) & (moved > LEAP + FASTEST * np.diff(times[order]))
    return order[1:][leaps], moved[leaps]


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
    """Files of a recording, and axes of its odometry; ``None``: no such file, or axes inferred from the motion."""

    name: str
    camera: Path
    boxes: Path
    poses: Path | None = None
    odometry: Path | None = None
    people: Path | None = None
    odometry_axes: Axes | None = None

    @property
    def digests(self) -> dict[str, str]:
        """SHA-256 of every file, by its kind."""
        parts = ("camera", "boxes", "poses", "odometry", "people")
        return {part: content_sha256(path) for part in parts if (path := getattr(self, part)) is not None}


@dataclass(frozen=True, kw_only=True)
class OwnRecording:
    """A recording that was read.

    Parameters
    ----------
    pixel_std : noise in px of boxes, stated or measured.
    notes : notes for the user, a line each.
    rows : the boxes of people in the file, with the times of its frames.
    """

    footage: Footage
    files: RecordingFiles
    own: OwnCamera
    pixel_std: float
    notes: tuple[str, ...]
    rows: OwnBoxes


def boxes_in(folder: Path) -> Path | None:
    """The file of boxes in a folder, such as one of MOTChallenge; ``None`` if there is none."""
    return next((path for name in BOXES if (path := folder / name).is_file()), None)


def files_in(folder: Path, *, boxes: Path | None = None, poses: Path | None = None) -> RecordingFiles:
    """The files of a recording in a folder; ``boxes`` and ``poses`` replace those in it."""
    found = boxes or boxes_in(folder)
    if not (folder / CAMERA).is_file():
        raise FileError(folder / CAMERA, "the file is missing; docs/own.md says what to write")
    if found is None:
        raise FileError(folder, f"holds no boxes; write {', '.join(BOXES[:-1])} or {BOXES[-1]}")
    there = [path if (path := folder / name).is_file() else None for name in (POSES, ODOMETRY, PEOPLE)]
    poses, odometry, people = poses or there[0], *there[1:]
    return RecordingFiles(
        name=folder.resolve().name, camera=folder / CAMERA, boxes=found, poses=poses, odometry=odometry, people=people
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
    dt : seconds per frame, if the camera file does not state them, such as those of a film.
    pictures : its pictures.
    mount : keys that the camera file lacks, such as ``mount_height`` and ``carried_by``.
    person_class : class of people in the boxes, where the file does not show it.
    """
    own = read_camera(files.camera, mount)
    seconds = frame_seconds(files.boxes, own, dt)
    read = read_boxes(files.boxes, seconds, picture=own.facts.picture, person_class=person_class)
    rows, misfits = fitting(read, own)
    timeline, notes = rows.timeline, [*own.notes, *rows.timeline.notes, *rows.notes, *misfits]
    notes += notes_on_dt(seconds or 0.0)
    linked_here = not rows.linked
    if linked_here:
        rows, linking = _linked(rows, own)
        notes.append(linking)
    whole, (rows, unseen) = len(rows), straight_rows(rows, own.facts.distortion, own.camera.intrinsics)
    if unseen > 0.5 * whole:
        problem = f"[distortion] leaves {unseen} of {whole} boxes without a place in the picture"
        raise FileError(own.path, f"{problem}; are these its coefficients?")
    if unseen:
        notes.append(f"{unseen} of {whole} boxes are dropped: the lens shows them too far from its axis")
    tracks, boxes, visible = _dense(rows, own)
    notes += gaps(~np.isnan(boxes[..., 2]), timeline.dt)
    scene = odometry = poses = None
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
    noise = own.facts.pixel_std
    return OwnRecording(
        footage=footage,
        files=files,
        own=own,
        pixel_std=box_noise(boxes, own.camera.picture_size[0], own.camera.period) if noise is None else noise,
        notes=tuple(notes),
        rows=read,
    )


def as_recordings(read: Sequence[OwnRecording]) -> Recordings:
    """One or several recordings as the input of a split of footage."""
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
        caution="a user's recording; nobody has checked its camera file",
        pixel_std=worst,
        **facts,
    )


def _linked(rows: OwnBoxes, own: OwnCamera) -> tuple[OwnBoxes, str]:
    """Detections linked to tracks by the bundled tracker, and a note."""
    factory: TrackerFactory = load("tracker", "byte")
    tracker = factory(dt=rows.timeline.dt, period=own.camera.period)
    shares = replace(rows, scores=scores_as_shares(rows.scores))
    linked = link(shares, tracker, np.arange(rows.timeline.frames))
    if not len(linked):
        problem = "has no ids, and the tracker links none of its boxes"
        raise FileError(rows.path, f"{problem}; are frames close in time, and scores from 0 to 1?")
    people = len(np.unique(linked.track))
    return linked, f"boxes without ids: the tracker links {len(linked)} of {len(rows)} of them to {people} tracks"


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
    """The footage with the person behind each track, and notes if boxes and places of people disagree.

    Ids of the boxes are those of the people, unless the tracker gave them: then people are matched by overlap.
    """
    heights, camera = np.where(np.isnan(scene.heights), height_mean, scene.heights), footage.camera

    def boxes_of_people(frames: IntArray, later: int) -> FloatArray:
        places = scene.positions[frames + later]
        places = places if footage.poses is None else world_to_relative(places, footage.poses[frames])
        return camera.project_unbounded(places, np.broadcast_to(heights, places.shape[:2]))

    def shifted(frames: IntArray, later: int) -> FloatArray:
        return in_columns(rectangles(boxes_of_people(frames, later)))

    expected, found = boxes_of_people(np.arange(footage.frames), 0), rectangles(footage.boxes)
    columns = None
    if linked_here:
        footage = replace(footage, persons=match_tracks(found, rectangles(expected), scene.people, camera))
    else:
        place = np.searchsorted(scene.people, footage.tracks).clip(max=len(scene.people) - 1)
        own = np.where(scene.people[place] == footage.tracks, place, -1)
        columns = np.broadcast_to(own, footage.visible.shape)
    offset = frame_offset(in_columns(found), shifted, camera.period, columns, least=FITTING)
    _, persons = footage.positions()
    frame, track = np.nonzero((persons != NOBODY) & footage.observed)
    boxes = int(footage.observed.sum())
    if not len(frame):
        how = "overlaps the box of a person of usual height" if linked_here else "has the id of a person in its frame"
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
