"""Reads one annotation file of MOTSynth: COCO-style JSON of one video."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, TypeAlias

import msgspec
import numpy as np
from msgspec import Meta, Struct

from vbbench.errors import FileError
from vbbench.files.tables import first_repetition
from vbbench.geometry import FloatArray, IntArray

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
