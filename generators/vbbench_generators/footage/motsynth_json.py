"""Reads one annotation file of MOTSynth: COCO-style JSON of one video."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, quoted, suggestion
from vbbench.files.tables import first_repetition
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.numbers import Within

JOINTS = 22
VISIBLE = 2
"""What ``keypoints`` says of a joint that is seen; 1 = hidden, 0 = not known."""

_VIDEO_KEYS = ("width", "height", "cam_fov", "fps")
_POSE_KEYS = ("cam_world_pos", "cam_world_rot")

_RANGES = {
    "width": Within(16, 20_000, "px"),
    "height": Within(16, 20_000, "px"),
    "cam_fov": Within(1.0, 170.0, "degrees"),
    "fps": Within(0.1, 1000.0, "Hz"),
    "fx": Within(1.0, 1e6, "px"),
    "fy": Within(1.0, 1e6, "px"),
    "cx": Within(-1e6, 1e6, "px"),
    "cy": Within(-1e6, 1e6, "px"),
}
FOCAL_AGREES = 0.02
"""Share by which the focal length in the file may differ from that of its field of view."""


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
    values = _load(path)
    images, rows = (_objects(path, values, name) for name in ("images", "annotations"))
    info = values.get("info", {})
    if not isinstance(info, dict):
        raise FileError(path, f"info is {quoted(info)}, not an object")
    video = info | {name: images[0][name] for name in images[0] if name not in info}
    video = {"width": info.get("img_width"), "height": info.get("img_height")} | video
    facts = {name: _number(path, video, name) for name in _VIDEO_KEYS}
    _refuse_zoom(path, images)
    frames = _frame_of_image(path, _in_order(path, images))
    positions, angles = (_vectors(path, "image", images, name, 3) for name in _POSE_KEYS)
    rows = [row for row in rows if not row.get("iscrowd")]
    boxes = _vectors(path, "annotation", rows, "bbox", 4)
    pixels = _vectors(path, "annotation", rows, "keypoints", 3 * JOINTS).reshape(-1, JOINTS, 3)
    joints = _vectors(path, "annotation", rows, "keypoints_3d", 4 * JOINTS).reshape(-1, JOINTS, 4)
    frame = np.array([_frame(path, frames, row) for row in rows], np.int64)
    person = np.array([_whole(path, row, "ped_id") for row in rows], np.int64)
    visible = (pixels[..., 2] == VISIBLE).mean(axis=1)
    order = np.lexsort((frame, person))
    order = order[(visible[order] > 0.0) & (boxes[order, 2:] > 0.0).all(axis=1)]
    if not len(order):
        raise FileError(path, "nobody is seen: all annotations are of crowds, hidden or without a box")
    _refuse_repetition(path, frame[order], person[order])
    _refuse_points(path, rows, joints[..., :3], order)
    return Annotations(
        path=path,
        width=int(facts["width"]),
        height=int(facts["height"]),
        focal=_focal_length(path, video, facts),
        cx=_number(path, {"cx": 0.5 * facts["width"]} | video, "cx"),
        cy=_number(path, {"cy": 0.5 * facts["height"]} | video, "cy"),
        fps=facts["fps"],
        first=_whole(path, images[0], "frame_n"),
        positions=positions,
        angles=angles,
        frame=frame[order],
        person=person[order],
        boxes=boxes[order],
        joints=joints[order, :, :3],
        pixels=pixels[order, :, :2],
        visible=visible[order],
    )


def _load(path: Path) -> dict[str, Any]:
    """The JSON object of the file, without the masks of people, which take most of its bytes."""
    try:
        values = json.loads(path.read_bytes(), object_hook=_without_mask)
    except FileNotFoundError:
        raise FileError(path, "the file is missing") from None
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"is not JSON ({error}); unpack the annotations of MOTSynth again") from None
    if not isinstance(values, dict) or not {"images", "annotations"} <= values.keys():
        raise FileError(path, "has no lists 'images' and 'annotations': it is no annotation file of MOTSynth")
    return values


def _without_mask(values: dict[str, Any]) -> dict[str, Any]:
    values.pop("segmentation", None)
    return values


def _objects(path: Path, values: dict[str, Any], name: str) -> list[dict[str, Any]]:
    found = values[name]
    if not isinstance(found, list) or not found or not all(isinstance(one, dict) for one in found):
        raise FileError(path, f"'{name}' is not a list of objects, or has none")
    return found


def _in_order(path: Path, images: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The images sorted by frame, in place; they must be consecutive frames of one video."""
    videos = sorted({str(image["seq_name"]) for image in images if "seq_name" in image})
    if len(videos) > 1:
        problem = f"holds {len(videos)} videos ({videos[0]}, {videos[1]} …)"
        raise FileError(path, f"{problem}; name the folder that has a file for each, 000.json and so on")
    images.sort(key=lambda image: _whole(path, image, "frame_n", "image"))
    for before, after in pairwise(_whole(path, image, "frame_n") for image in images):
        if after != before + 1:
            raise FileError(path, f"frame {after} follows frame {before}; frames must not be missing")
    return images


def _vectors(path: Path, what: str, rows: list[dict[str, Any]], name: str, size: int) -> FloatArray:
    """[N, size] of a key that is a list of numbers."""
    for row in rows:
        if name not in row:
            raise _missing(path, f"{what} {quoted(row.get('id'))}", name, row)
        if not isinstance(row[name], list) or len(row[name]) != size:
            raise FileError(path, f"{what} {quoted(row.get('id'))}: {name} is {quoted(row[name])}, not {size} numbers")
    try:
        found = np.array([row[name] for row in rows], np.float64).reshape(-1, size)
    except (TypeError, ValueError, OverflowError):
        raise FileError(path, f"{name} of some {what} is not a list of {size} numbers") from None
    if not np.isfinite(found).all():
        raise FileError(
            path,
            f"{name} of {what} {quoted(rows[int(np.argwhere(~np.isfinite(found))[0, 0])].get('id'))} is not finite",
        )
    return found


def _missing(path: Path, what: str, name: str, known: Iterable[str]) -> FileError:
    return FileError(
        path, f"{what} has no key '{name}' ({suggestion(name, known)}); wanted: the COCO annotations of MOTSynth"
    )


def _number(path: Path, video: dict[str, Any], name: str) -> float:
    """The number ``name`` of the video, which may be written as text."""
    if video.get(name) is None:
        raise _missing(path, "neither 'info' nor the first image", name, video)
    try:
        value = float(video[name])
    except (TypeError, ValueError, OverflowError):
        raise FileError(path, f"{name} is {quoted(video[name])}, not a number") from None
    try:
        _RANGES[name].check(name, value)
    except ValueError as error:
        raise FileError(path, str(error)) from None
    return value


def _whole(path: Path, row: dict[str, Any], name: str, what: str = "annotation") -> int:
    if name not in row:
        raise _missing(path, f"{what} {quoted(row.get('id'))}", name, row)
    value = row[name]
    number = int(value) if isinstance(value, str) and value.isdecimal() else value
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < 2**31:
        raise FileError(
            path, f"{what} {quoted(row.get('id'))}: {name} is {quoted(value)}, not a whole number from 0 on"
        )
    return number


def _frame_of_image(path: Path, images: list[dict[str, Any]]) -> dict[str, int]:
    """The frame of each image by its id, as text: some programs write ids as text in one of the two lists."""
    frames: dict[str, int] = {}
    for number, image in enumerate(images):
        name = image.get("id")
        if not isinstance(name, int | str) or str(name) in frames:
            raise FileError(path, f"image {quoted(image['frame_n'])}: id is {quoted(name)}, not a new one")
        frames[str(name)] = number
    return frames


def _frame(path: Path, frames: dict[str, int], row: dict[str, Any]) -> int:
    name = row.get("image_id")
    if not isinstance(name, int | str) or str(name) not in frames:
        raise FileError(path, f"annotation {quoted(row.get('id'))}: there is no image {quoted(name)}")
    return frames[str(name)]


def _focal_length(path: Path, video: dict[str, Any], facts: dict[str, float]) -> float:
    """The focal length in px; ``cam_fov`` is the vertical field of view, and ``fx`` and ``fy`` must agree with it."""
    focal = 0.5 * facts["height"] / float(np.tan(np.radians(0.5 * facts["cam_fov"])))
    for name in ("fx", "fy"):
        written = focal if video.get(name) is None else _number(path, video, name)
        if abs(written / focal - 1.0) > FOCAL_AGREES:
            view = f"a vertical field of view of {facts['cam_fov']:g} degrees is {focal:.0f} px"
            raise FileError(path, f"{name} is {written:g} px, but {view}: one of them is wrong")
    return focal


def _refuse_zoom(path: Path, images: list[dict[str, Any]]) -> None:
    views = {image["cam_fov"] for image in images if isinstance(image.get("cam_fov"), int | float)}
    if views and max(views) - min(views) > FOCAL_AGREES * min(views):
        raise FileError(path, f"the camera zooms: cam_fov is {min(views):g} to {max(views):g} degrees; it must stay")


def _refuse_repetition(path: Path, frame: IntArray, person: IntArray) -> None:
    found = first_repetition(frame, person)
    if found is not None:
        _, again = found
        raise FileError(path, f"person {person[again]} has two boxes in frame {frame[again]}")


def _refuse_points(path: Path, rows: list[dict[str, Any]], joints: FloatArray, seen: IntArray) -> None:
    """Refuse people ``seen`` whose joints all lie at one point."""
    points = seen[np.ptp(joints[seen], axis=1).max(axis=1) == 0.0]
    if len(points):
        name = quoted(rows[int(points.min())].get("id"))
        raise FileError(path, f"annotation {name}: all joints of keypoints_3d are in one place; remove it")
