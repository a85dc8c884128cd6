"""From a ROS bag to a map: its detections, odometry and camera info become the files that birdify reads."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from typing import Any

import numpy as np
import yaml

from vbbench.birdify.birdify import Birdified, birdify
from vbbench.birdify.report import REPORT
from vbbench.errors import FileError
from vbbench.exchange.bags import CAMERA, DETECTIONS, ODOMETRY, Bag, open_bag
from vbbench.exchange.own.recording import RecordingFiles
from vbbench.folders.work_folder import check_free

_HEAD = ("time", "id", "left", "top", "width", "height", "score")


@dataclass(frozen=True, kw_only=True)
class BagTopics:
    """Topics of a bag; ``None`` for the only one of its type. Odometry and camera may be files instead."""

    boxes: str | None = None
    odometry: Path | str | None = None
    camera: Path | str | None = None


def birdify_bag(path: Path, out: Path | str, topics: BagTopics, **options: Any) -> Birdified:
    """Make a map of the messages of a bag.

    They are written to ``OUT.from-bag`` as boxes.csv, odometry.txt and camera_info.yaml, which is removed once the map
    is complete.

    Raises VbbenchError if the bag cannot be read, a topic is missing, or as `birdify` raises it.

    Parameters
    ----------
    path : file of ROS 1, or folder of ROS 2.
    out, options : as in `vbbench.birdify.birdify.birdify`.
    topics : vision_msgs/Detection2DArray, nav_msgs/Odometry and sensor_msgs/CameraInfo.
    """
    out = Path(out)
    check_free(out, REPORT, "folder that birdify made", bool(options.get("overwrite")))
    folder = out.with_name(f"{out.name}.from-bag")
    files = files_from_bag(path, topics, folder)
    made = birdify(files.boxes, files.camera, out, odometry=files.odometry, name=path.resolve().stem, **options)
    rmtree(folder)
    return made


def files_from_bag(path: Path, topics: BagTopics, folder: Path) -> RecordingFiles:
    """Write a bag's messages to files in a folder, which is created once the bag is open.

    Raises VbbenchError if the bag cannot be read, or a topic is missing.
    """
    with open_bag(path, "reading a bag (bag:DIR)") as bag:
        boxes_topic = _topic(bag, topics.boxes, DETECTIONS, "--boxes")
        odometry, camera = topics.odometry, topics.camera
        odometry_topic = camera_topic = ""
        if not _is_file(bag, odometry) and (odometry is not None or bag.topics_of(ODOMETRY)):
            odometry_topic = _topic(bag, odometry, ODOMETRY, "--odometry")
        if not _is_file(bag, camera):
            camera_topic = _topic(bag, camera, CAMERA, "--camera")
        folder.mkdir(parents=True, exist_ok=True)
        boxes = _write_boxes(bag, boxes_topic, folder / "boxes.csv")
        if odometry_topic:
            odometry = _write_odometry(bag, odometry_topic, folder / "odometry.txt")
        if camera_topic:
            camera = _write_camera(bag, camera_topic, folder / "camera_info.yaml")
    odometry = None if odometry is None else Path(odometry)
    return RecordingFiles(name=path.resolve().stem, camera=Path(camera or ""), boxes=boxes, odometry=odometry)


def _is_file(bag: Bag, given: Path | str | None) -> bool:
    return given is not None and str(given).strip("/") not in bag.kinds and Path(given).exists()


def _topic(bag: Bag, given: Path | str | None, kind: str, option: str) -> str:
    """The ``given`` topic, or the only one of the type ``kind``."""
    there = bag.topics_of(kind)
    if given is None and len(there) == 1:
        return there[0]
    if given is not None and str(given).strip("/") in there:
        return str(given).strip("/")
    none = "none; write them as CSV" if option == "--boxes" else f"none; name a file with {option}"
    listed = ", ".join(f"/{name}" for name in there) or none
    missing = f"{option} names no topic of the bag: {given}" if given else f"{option} is open"
    raise FileError(bag.path, f"{missing}; of type {kind.replace('/msg', '')} it has {listed}")


def _write_boxes(bag: Bag, topic: str, path: Path) -> Path:
    rows = [(repr(one.time), *row) for one in bag.messages(topic) for row in _boxes(one.fields.detections)]
    rows = list(dict.fromkeys(rows))  # messages may be recorded twice
    numbers = all(str(row[-1]).isdigit() for row in rows)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([(*_HEAD, "class" if numbers else "class_name"), *rows])
    return path


def _boxes(detections: Any) -> Iterator[tuple[Any, ...]]:
    """Id, left, top, width, height, score and class of each detection, of any version of vision_msgs."""
    for one in detections:
        box, centre = one.bbox, getattr(one.bbox.center, "position", one.bbox.center)
        found = [getattr(result, "hypothesis", result) for result in one.results]
        best = max(found, key=lambda result: result.score, default=None)
        kind = "" if best is None else getattr(best, "class_id", getattr(best, "id", ""))
        name = getattr(one, "id", "") or getattr(one, "tracking_id", "") or -1
        left, top = centre.x - 0.5 * box.size_x, centre.y - 0.5 * box.size_y
        yield name, left, top, box.size_x, box.size_y, "" if best is None else best.score, kind


def _write_odometry(bag: Bag, topic: str, path: Path) -> Path:
    """Write odometry as a TUM file, with 3-D rotations, since the body may have any axes."""
    poses = ((message.time, message.fields.pose.pose) for message in bag.messages(topic))
    rows = [
        (time, *(getattr(one.position, name) for name in "xyz"), *(getattr(one.orientation, name) for name in "xyzw"))
        for time, one in poses
    ]
    np.savetxt(path, list(dict.fromkeys(rows)), "%.9f", header="timestamp tx ty tz qx qy qz qw")
    return path


def _write_camera(bag: Bag, topic: str, path: Path) -> Path:
    """Write the first camera info with a calibration."""
    for message in bag.messages(topic):
        info = message.fields
        matrix, coefficients = (
            np.ravel(getattr(info, name.lower(), getattr(info, name, ()))).tolist() for name in "KD"
        )
        if any(matrix):
            table = {name: getattr(info, name) for name in ("width", "height", "distortion_model")}
            table |= {"binning_x": info.binning_x, "binning_y": info.binning_y, "K": matrix, "D": coefficients}
            table["roi"] = {name: getattr(info.roi, name) for name in ("x_offset", "y_offset", "width", "height")}
            path.write_text(yaml.safe_dump(table), "utf-8")
            return path
    raise FileError(bag.path, f"/{topic} holds no calibration: K is zero in every message")
