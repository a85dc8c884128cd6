"""One video of MOTSynth: its annotations, COCO-style JSON, and its camera.

People are given in the camera's axes (right, down, forward), the camera in the game's world, z up. How the camera's
angles are written is recognised. Reprojection tests three things: the axes of the joints (they must project onto the
joints in the picture), the boxes (the joints must project into them), and the frames of the poses. The last test
predicts people by constant velocity in the world, from half a second and a second before, and compares the prediction
in the picture.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, TypeAlias

import msgspec
import numpy as np
from msgspec import Meta, Struct

from vbbench.errors import FileError
from vbbench.files.tables import first_repetition
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.numbers import BODY_HEIGHT

JOINTS = 22
VISIBLE = 2
"""What ``keypoints`` says of a joint that is seen; 1 = hidden, 0 = not known."""
FOCAL_AGREES = 0.02
"""Share by which the focal length in the file may differ from that of its field of view."""
WANTED = "wanted: the COCO annotations of MOTSynth"

Three: TypeAlias = Annotated[list[float], Meta(min_length=3, max_length=3)]
Pixels: TypeAlias = Annotated[float, Meta(ge=-1e6, le=1e6)]
Id: TypeAlias = Annotated[int, Meta(ge=0, lt=2**31)]


class _Video(Struct):
    """Facts of the video, which stand in ``info`` or in each image; as numbers or as text."""

    seq_name: str | None = None
    width: Annotated[float, Meta(ge=16, le=20_000)] | None = None
    height: Annotated[float, Meta(ge=16, le=20_000)] | None = None
    img_width: Annotated[float, Meta(ge=16, le=20_000)] | None = None
    img_height: Annotated[float, Meta(ge=16, le=20_000)] | None = None
    cam_fov: Annotated[float, Meta(ge=1, le=170)] | None = None
    fps: Annotated[float, Meta(gt=0, le=1000)] | None = None
    fx: Annotated[float, Meta(ge=1, le=1e6)] | None = None
    fy: Annotated[float, Meta(ge=1, le=1e6)] | None = None
    cx: Pixels | None = None
    cy: Pixels | None = None


class _Image(_Video, kw_only=True):
    id: int
    frame_n: Id
    cam_world_pos: Three
    cam_world_rot: Three


class _Person(Struct):
    image_id: int
    ped_id: Id
    bbox: Annotated[list[float], Meta(min_length=4, max_length=4)]
    keypoints: Annotated[list[float], Meta(min_length=3 * JOINTS, max_length=3 * JOINTS)]
    keypoints_3d: Annotated[list[float], Meta(min_length=4 * JOINTS, max_length=4 * JOINTS)]
    iscrowd: bool | int = 0


class _File(Struct):
    images: Annotated[list[_Image], Meta(min_length=1)]
    annotations: Annotated[list[_Person], Meta(min_length=1)]
    info: _Video = msgspec.field(default_factory=_Video)


@dataclass(frozen=True, kw_only=True)
class Annotations:
    """One video: T frames, N boxes, sorted by person and frame.

    Parameters
    ----------
    width, height : of the pictures in px.
    focal, cx, cy : focal length and principal point in px.
    fps : frames per second.
    first : number of the first frame in the file, and of its picture.
    positions : [T, 3] of the camera in the game's world, in m, z up.
    angles : [T, 3] of the camera in degrees, in the file's order.
    frame, person : [N] frame from 0, and id of the person, of each box.
    boxes : [N, 4] (left, top, width, height) in px.
    joints : [N, 22, 3] (right, down, forward) of the camera in m.
    pixels : [N, 22, 2] the same in the picture.
    visible : [N] share of the joints that are seen.
    """

    path: Path
    width: int
    height: int
    focal: float
    cx: float
    cy: float
    fps: float
    first: int
    positions: FloatArray
    angles: FloatArray
    frame: IntArray
    person: IntArray
    boxes: FloatArray
    joints: FloatArray
    pixels: FloatArray
    visible: FloatArray

    @property
    def frames(self) -> int:
        """Number of frames T."""
        return len(self.positions)

    def project(self, points: FloatArray) -> FloatArray:
        """Pixels [..., 2] of points [..., 3] (right, down, forward); NaN behind the camera."""
        depth = np.where(points[..., 2:] > 0.0, points[..., 2:], np.nan)
        return np.array([self.cx, self.cy]) + self.focal * points[..., :2] / depth


def read_annotations(path: Path) -> Annotations:
    """Read one annotation file, without invisible people and those marked as crowd."""
    found = _load(path)
    images = _in_order(path, found.images)
    rows = [row for row in found.annotations if not row.iscrowd]
    width, height, fov, fps = (
        _fact(path, found.info, images[0], *names)
        for names in (("width", "img_width"), ("height", "img_height"), ("cam_fov",), ("fps",))
    )
    frames = {image.id: number for number, image in enumerate(images)}
    if len(frames) < len(images):
        raise FileError(path, f"has {len(images)} images of {len(frames)} ids: an id stands there twice")
    lost = next((row.image_id for row in rows if row.image_id not in frames), None)
    if lost is not None:
        raise FileError(path, f"an annotation is of image {lost}, and there is no such image")
    frame = np.array([frames[row.image_id] for row in rows], np.int64)
    person = np.array([row.ped_id for row in rows], np.int64)
    boxes = np.array([row.bbox for row in rows], np.float64).reshape(-1, 4)
    pixels = np.array([row.keypoints for row in rows], np.float64).reshape(-1, JOINTS, 3)
    joints = np.array([row.keypoints_3d for row in rows], np.float64).reshape(-1, JOINTS, 4)
    visible = (pixels[..., 2] == VISIBLE).mean(axis=1)
    order = np.lexsort((frame, person))
    order = order[(visible[order] > 0.0) & (boxes[order, 2:] > 0.0).all(axis=1)]
    if not len(order):
        raise FileError(path, "nobody is seen: all annotations are of crowds, hidden or without a box")
    frame, person, joints = frame[order], person[order], joints[order, :, :3]
    twice = first_repetition(frame, person)
    if twice is not None:
        raise FileError(path, f"person {person[twice[1]]} has two boxes in frame {frame[twice[1]]}")
    points = np.ptp(joints, axis=1).max(axis=1) == 0.0
    if points.any():
        row = int(points.argmax())
        problem = f"person {person[row]}, frame {frame[row]}: all joints of keypoints_3d are in one place; remove it"
        raise FileError(path, problem)
    cx, cy = (_either(found.info, images[0], name) for name in ("cx", "cy"))
    return Annotations(
        path=path,
        width=int(width),
        height=int(height),
        focal=_focal_length(path, found.info, images[0], height, fov),
        cx=0.5 * width if cx is None else cx,
        cy=0.5 * height if cy is None else cy,
        fps=fps,
        first=images[0].frame_n,
        positions=np.array([image.cam_world_pos for image in images]),
        angles=np.array([image.cam_world_rot for image in images]),
        frame=frame,
        person=person,
        boxes=boxes[order],
        joints=joints,
        pixels=pixels[order, :, :2],
        visible=visible[order],
    )


def _load(path: Path) -> _File:
    """The values of the file that are read; the masks of people, which take most of its bytes, are skipped."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=_File, strict=False)
    except FileNotFoundError:
        raise FileError(path, "the file is missing") from None
    except msgspec.ValidationError as error:
        raise FileError(path, f"{error}; {WANTED}") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FileError(path, f"is not JSON ({error}); unpack the annotations of MOTSynth again") from None


def _in_order(path: Path, images: list[_Image]) -> list[_Image]:
    """The images by frame, which must be consecutive frames of one video, without zoom."""
    videos = sorted({image.seq_name for image in images if image.seq_name is not None})
    if len(videos) > 1:
        problem = f"holds {len(videos)} videos ({videos[0]}, {videos[1]} …)"
        raise FileError(path, f"{problem}; name the folder that has a file for each, 000.json and so on")
    images = sorted(images, key=lambda image: image.frame_n)
    for before, after in pairwise(image.frame_n for image in images):
        if after != before + 1:
            raise FileError(path, f"frame {after} follows frame {before}; frames must not be missing")
    views = {image.cam_fov for image in images if image.cam_fov is not None}
    if views and max(views) - min(views) > FOCAL_AGREES * min(views):
        raise FileError(path, f"the camera zooms: cam_fov is {min(views):g} to {max(views):g} degrees; it must stay")
    return images


def _either(info: _Video, image: _Image, name: str) -> float | None:
    """A fact of the video from ``info``, or else from its first image."""
    own: float | None = getattr(info, name)
    other: float | None = getattr(image, name)
    return other if own is None else own


def _fact(path: Path, info: _Video, image: _Image, *names: str) -> float:
    """A fact of the video that must be there, by one of its names."""
    found = next((value for name in names if (value := _either(info, image, name)) is not None), None)
    if found is None:
        raise FileError(path, f"neither 'info' nor the first image has the key '{names[0]}'; {WANTED}")
    return found


def _focal_length(path: Path, info: _Video, image: _Image, height: float, fov: float) -> float:
    """The focal length in px; ``cam_fov`` is the vertical field of view, and ``fx`` and ``fy`` must agree with it."""
    focal = 0.5 * height / float(np.tan(np.radians(0.5 * fov)))
    for name in ("fx", "fy"):
        written = _either(info, image, name) or focal
        if abs(written / focal - 1.0) > FOCAL_AGREES:
            view = f"a vertical field of view of {fov:g} degrees is {focal:.0f} px"
            raise FileError(path, f"{name} is {written:g} px, but {view}: one of them is wrong")
    return focal


HEAD_TOP, HIPS, ANKLES = 0, (16, 19), (18, 21)
"""Joints, in the order of JTA, an earlier recording of the same game by the same authors."""
ANKLE_HEIGHT = 0.08
"""Of an ankle above the sole, in m."""


@dataclass(frozen=True, kw_only=True)
class Convention:
    """How the camera's pose is written.

    Parameters
    ----------
    places, angles : ``cam_world_pos`` and ``cam_world_rot`` in words.
    matrix : [3, 3] from the numbers of ``cam_world_pos`` to (x, y, height).
    where, signs : indices of pitch, roll and yaw in ``cam_world_rot``, and their signs; pitch is positive upwards, roll
        clockwise as the camera sees, yaw to the left.
    fixed_axes : whether roll turns about a fixed axis, after yaw and pitch; else about the camera's own.
    """

    places: str
    angles: str
    matrix: tuple[tuple[int, ...], ...]
    where: tuple[int, ...]
    signs: tuple[int, ...]
    fixed_axes: bool


CONVENTIONS = (
    Convention(
        places="x, -height, y",
        angles="pitch, -yaw, roll",
        matrix=((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        where=(0, 2, 1),
        signs=(1, 1, -1),
        fixed_axes=True,
    ),
    Convention(
        places="x, y, height",
        angles="pitch, roll, yaw",
        matrix=((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        where=(0, 1, 2),
        signs=(1, 1, 1),
        fixed_axes=False,
    ),
)
"""That of the published files, as Quo Vadis, a public program, reads them; and the game's own."""

MOST_SHIFT = 5
"""Frames by which poses may be too early or too late."""
MOST_LEAN = 8.0
"""Degrees that people may lean on average."""
MOST_JOINT_ERROR = 10.0
"""px that the median joint may be off."""
MOST_BOX_ERROR, MOST_POSE_ERROR = 0.15, 0.25
"""Shares of a box's height that its centre may be off the centre of the joints, and that the place that is predicted
from the past may be off, in the median."""
AHEAD = 0.5
"""s that places are predicted ahead: long enough for a camera's turns, short enough for people's."""
CLEARLY = 0.8
"""A shift is taken if its error is less than so many times the error without."""
MOST_TRIPLES = 3000
"""Predictions from which the convention and the shift are chosen."""
FASTEST, QUICKEST = 100.0, 15.0
"""In m/s and rad/s: no camera that walks, drives or turns is faster from a frame to the next."""
MOST_TILT_SPREAD = 0.05
"""rad between the 5th and 95th percentile of pitch, and of roll: a sequence's camera has one of each."""
MOST_HEIGHT_SPREAD = 0.2
"""Of the camera's height, between the 5th and 95th percentile, as a share of it."""


@dataclass(frozen=True, kw_only=True)
class CameraPath:
    """The camera of a video, checked.

    Parameters
    ----------
    annotations : boxes, joints and poses of the same frames; a shift of the poses is corrected.
    poses : [T, 3] (x, y, yaw) in m and rad.
    pitch, roll, mount_height : medians in rad and m.
    people : [N, 2] place of each box's person on the ground: between the hips.
    statures : [N] height in m, from the lower ankle to the top of the head.
    report : figures of the checks.
    """

    annotations: Annotations
    poses: FloatArray
    pitch: float
    roll: float
    mount_height: float
    people: FloatArray
    statures: FloatArray
    report: dict[str, float | str]


def find_camera_path(found: Annotations) -> CameraPath:
    """Find the convention of angles, check poses, joints and boxes by reprojection, and correct a shift of poses."""
    off = np.linalg.norm(found.project(found.joints) - found.pixels, axis=-1)
    if not np.isfinite(off).any():
        raise FileError(
            found.path, "no joint of keypoints_3d lies before the camera; wanted (right, down, forward) in m"
        )
    joint_error = float(np.nanmedian(off))
    if not joint_error <= MOST_JOINT_ERROR:
        expected = "keypoints_3d must be (right, down, forward) of the camera in m"
        raise FileError(found.path, f"joints project {joint_error:.0f} px from those in the picture: {expected}")
    box_error = _box_error(found)
    if not box_error <= MOST_BOX_ERROR:
        problem = f"boxes lie {box_error:.0%} of their height from their people"
        raise FileError(found.path, f"{problem}: joints and boxes are not of one video")
    reading = _find_reading(found)
    convention, pose_shift = reading.convention, reading.shift
    turned = replace(found, positions=found.positions @ np.array(convention.matrix).T)
    found = _shift_poses(turned, pose_shift)
    axes = camera_axes(found.angles, convention)
    _refuse_leaps(found, axes, pose_shift)
    places = _to_world(found, axes, found.joints)
    right, down, forward = np.moveaxis(axes, 2, 0)
    pitch, roll = np.arcsin(forward[:, 2]), np.arctan2(-right[:, 2], -down[:, 2])
    soles = places[:, ANKLES, 2].min(axis=1) - ANKLE_HEIGHT
    above = found.positions[found.frame, 2] - soles
    spreads = {name: float(np.ptp(np.percentile(v, (5, 95)))) for name, v in (("pitch", pitch), ("roll", roll))}
    height, height_spread = _mount_height(found, above)
    statures = places[:, HEAD_TOP, 2] - soles
    try:
        BODY_HEIGHT.check("their median height", float(np.median(statures)))
    except ValueError as error:
        raise FileError(found.path, f"people by keypoints_3d: {error}; it must be in m") from None
    for name, spread in spreads.items():
        if spread > MOST_TILT_SPREAD:
            raise FileError(found.path, f"the camera's {name} changes by {spread:.2f} rad; a sequence has one {name}")
    return CameraPath(
        annotations=found,
        poses=np.column_stack([found.positions[:, :2], np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))]),
        pitch=float(np.median(pitch)),
        roll=float(np.median(roll)),
        mount_height=height,
        people=places[:, HIPS, :2].mean(axis=1),
        statures=statures,
        report={
            "places": convention.places,
            "angles": convention.angles,
            "joint_px": joint_error,
            "box_error": box_error,
            "pose_shift": pose_shift,
            "pose_error": reading.error,
            "lean_degrees": reading.lean,
            "pitch_spread": spreads["pitch"],
            "roll_spread": spreads["roll"],
            "mount_height_spread": height_spread,
        },
    )


def _refuse_leaps(found: Annotations, axes: FloatArray, shift: int) -> None:
    """Raise FileError at the first pose too far from the last; poses are ``shift`` frames later in the file."""
    moved = np.linalg.norm(np.diff(found.positions, axis=0), axis=1)
    turned = np.arccos(np.clip(np.einsum("tij,tij->t", axes[1:], axes[:-1]) * 0.5 - 0.5, -1.0, 1.0))
    leaps = (moved > FASTEST / found.fps) | (turned > QUICKEST / found.fps)
    if leaps.any():
        frame = int(leaps.argmax())
        problem = f"frame {found.first + frame + 1 + shift}: the camera moves {moved[frame]:,.1f} m and turns "
        problem += f"{np.degrees(turned[frame]):.0f} degrees from the frame before"
        raise FileError(found.path, f"{problem}; a video is one shot of one camera, in m and degrees")


def camera_axes(angles: FloatArray, convention: Convention) -> FloatArray:
    """[T, 3, 3] right, down and forward of the camera as columns, in the world, from angles [T, 3] in degrees.

    The camera looks along +y; pitch turns it about x, roll about y, yaw about z.
    """
    from scipy.spatial.transform import Rotation

    pitch, roll, yaw = np.radians(angles[:, convention.where] * convention.signs).T
    level, rolled = Rotation.from_euler("ZX", np.stack([yaw, pitch], -1)), Rotation.from_euler("y", roll[:, None])
    turned = (rolled * level if convention.fixed_axes else level * rolled).as_matrix()
    return np.stack([turned[..., 0], -turned[..., 2], turned[..., 1]], axis=-1)


def _to_world(found: Annotations, axes: FloatArray, points: FloatArray) -> FloatArray:
    """Points [N, J, 3] from the camera's axes to the world's."""
    return found.positions[found.frame, None] + points @ np.moveaxis(axes[found.frame], 1, 2)


def _box_error(found: Annotations) -> float:
    """Median distance of boxes' centres from those of joints, if all are in the picture, as a share of the height."""
    joints = found.project(found.joints)
    whole = ((joints >= 0.0) & (joints < [found.width, found.height])).all(axis=(1, 2))
    if not whole.any():
        return np.inf
    joints, boxes = joints[whole], found.boxes[whole]
    middle = 0.5 * (joints.min(axis=1) + joints.max(axis=1))
    away = np.linalg.norm(boxes[:, :2] + 0.5 * boxes[:, 2:] - middle, axis=1)
    return float(np.median(away / boxes[:, 3]))


def _partners(found: Annotations, shift: int) -> tuple[IntArray, IntArray]:
    """Rows [M], and the rows [M] of the same person ``shift`` frames later."""
    margin = abs(shift)
    key = found.person * (found.frames + 2 * margin) + found.frame + margin
    place = np.searchsorted(key, key + shift).clip(max=len(key) - 1)
    here = np.flatnonzero(key[place] == key + shift)
    return here, place[here]


@dataclass(frozen=True, kw_only=True)
class _Reading:
    """A convention; mean lean of people in degrees, and the shift of poses with its error under it."""

    convention: Convention
    lean: float
    shift: int
    error: float


def _find_reading(found: Annotations) -> _Reading:
    """The convention under which people stand upright and walk as predicted."""
    triples, leans = _triples(found), [_lean(found, convention) for convention in CONVENTIONS]
    if min(leans) > MOST_LEAN:
        problem = "people do not stand upright however cam_world_rot is read: they lean "
        problem += f"{min(leans):.0f} degrees at best, as ({CONVENTIONS[leans.index(min(leans))].angles})"
        raise FileError(found.path, problem)
    readings = []
    for convention, lean in zip(CONVENTIONS, leans, strict=True):
        if lean <= MOST_LEAN:
            axes, positions = camera_axes(found.angles, convention), found.positions @ np.array(convention.matrix).T
            errors = _errors(found, axes, positions, triples)
            shift = _best(errors)
            readings.append(_Reading(convention=convention, lean=lean, shift=shift, error=errors[shift]))
    best = min(readings, key=lambda reading: reading.error)
    if not best.error <= MOST_POSE_ERROR:
        problem = f"people jump by {best.error:.0%} of their height, at best ({best.shift:+d} frames, "
        problem += f"cam_world_pos as {best.convention.places}, cam_world_rot as {best.convention.angles})"
        raise FileError(found.path, f"{problem}: the camera's poses are not those of these boxes")
    return best


def _lean(found: Annotations, convention: Convention) -> float:
    """Degrees by which the mean of people's bodies, from ankles to head, leans under a convention."""
    rows = np.linspace(0, len(found.frame) - 1, min(len(found.frame), MOST_TRIPLES)).astype(int)
    bodies = found.joints[rows, HEAD_TOP] - found.joints[rows][:, ANKLES].mean(axis=1)
    bodies = bodies / np.maximum(np.linalg.norm(bodies, axis=1, keepdims=True), 1e-9)
    x, y, z = np.einsum("nwc,nc->nw", camera_axes(found.angles, convention)[found.frame[rows]], bodies).mean(axis=0)
    return float(np.degrees(np.arctan2(np.hypot(x, y), z)))


def _triples(found: Annotations) -> IntArray:
    """Rows [3, M] of the same person at three times, `AHEAD` apart."""
    step = max(1, round(AHEAD * found.fps))
    (late, before), (later, long_before) = (_partners(found, -steps) for steps in (step, 2 * step))
    last, n, m = np.intersect1d(late, later, return_indices=True)
    if not len(last):
        raise FileError(found.path, f"nobody is seen for {2 * AHEAD:g} s: the camera's poses cannot be checked")
    rows = np.stack([long_before[m], before[n], last])
    return rows[:, np.linspace(0, len(last) - 1, min(len(last), MOST_TRIPLES)).astype(int)]


def _errors(found: Annotations, axes: FloatArray, positions: FloatArray, rows: IntArray) -> dict[int, float]:
    """Median error in box heights of predicted places of ``rows`` [3, M], by each shift of the poses in frames."""
    hips = found.joints[rows][:, :, HIPS].mean(axis=2)
    errors = {}
    for shift in range(-MOST_SHIFT, MOST_SHIFT + 1):
        frames = found.frame[rows] + shift
        known = ((frames >= 0) & (frames < found.frames)).all(axis=0)
        if not known.any():
            errors[shift] = np.inf
            continue
        here, seen = frames[:, known], hips[:, known]
        world = positions[here] + np.einsum("sntc,snc->snt", axes[here], seen)
        expected = np.einsum("ntc,nt->nc", axes[here[2]], 2.0 * world[1] - world[0] - positions[here[2]])
        off = np.linalg.norm(found.project(expected) - found.project(seen[2]), axis=-1)
        errors[shift] = float(np.nanmedian(off / found.boxes[rows[2, known], 3]))
    return errors


def _best(errors: dict[int, float]) -> int:
    """The shift with the least error; 0 unless another is clearly better."""
    best = min(errors, key=lambda shift: (errors[shift], abs(shift)))
    return best if errors[best] < CLEARLY * errors[0] else 0


def _shift_poses(found: Annotations, shift: int) -> Annotations:
    """The video with the poses of ``shift`` frames later; frames that have none are removed."""
    if not shift:
        return found
    frames = np.arange(max(0, -shift), found.frames - max(0, shift))
    rows = (found.frame >= frames[0]) & (found.frame <= frames[-1])
    kept = {name: getattr(found, name)[rows] for name in ("person", "boxes", "joints", "pixels", "visible")}
    poses = {name: getattr(found, name)[frames + shift] for name in ("positions", "angles")}
    return replace(found, **kept, **poses, frame=found.frame[rows] - frames[0], first=found.first + int(frames[0]))


def _mount_height(found: Annotations, above: FloatArray) -> tuple[float, float]:
    """Median height in m of the camera above the soles of people, [N], and how much it changes between frames."""
    frames = np.unique(found.frame)
    heights = [float(np.median(above[found.frame == frame])) for frame in frames]
    middle, spread = float(np.median(above)), float(np.ptp(np.percentile(heights, (5, 95))))
    if not 0.3 <= middle <= 100.0 or spread > MOST_HEIGHT_SPREAD * middle:
        problem = f"the camera is {middle:.2f} m above people's feet, and this changes by {spread:.2f} m"
        raise FileError(found.path, f"{problem}: people and camera must be on one level ground")
    return middle, spread
