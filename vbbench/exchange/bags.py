"""Messages of ROS bags, ROS 1 files and ROS 2 folders, by the package rosbags."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchError, needs_extra

ODOMETRY, IMU = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu"
CAMERA, DETECTIONS = "sensor_msgs/msg/CameraInfo", "vision_msgs/msg/Detection2DArray"
"""Types of messages."""
_VISION = {
    "Point2D": "float64 x\nfloat64 y",
    "Pose2D": "vision_msgs/Point2D position\nfloat64 theta",
    "BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "ObjectHypothesis": "string class_id\nfloat64 score",
    "ObjectHypothesisWithPose": "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
    "Detection2D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox2D bbox\nstring id",
    "Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections",
}
"""Definitions of vision_msgs 3 and 4, which agree in bytes: bags of ROS 2 before Iron hold none."""


@dataclass(frozen=True)
class Message:
    """A message of a bag: its topic, without a slash before it, the recorder's time in s, and its fields."""

    topic: str
    recorded: float
    fields: Any

    @property
    def time(self) -> float:
        """Time of the measurement in s; the recorder's time for sensors without a clock."""
        stamp = self.fields.header.stamp
        return float(stamp.sec + 1e-9 * stamp.nanosec) or self.recorded


@dataclass(frozen=True)
class Bag:
    """An open bag: types and counts of messages by topic, without a slash before it."""

    path: Path
    kinds: Mapping[str, str]
    counts: Mapping[str, int]
    _reader: Any
    _types: Any

    def messages(self, *topics: str) -> Iterator[Message]:
        """The messages of some topics, in the order of recording."""
        deserialize = self._types.deserialize_cdr if self.path.is_dir() else self._types.deserialize_ros1
        connections = [one for one in self._reader.connections if one.topic.strip("/") in topics]
        for connection, recorded, raw in self._reader.messages(connections=connections) if connections else ():
            yield Message(connection.topic.strip("/"), 1e-9 * recorded, deserialize(raw, connection.msgtype))

    def topics_of(self, kind: str) -> list[str]:
        """The topics with messages of a type, the fullest first."""
        found = [name for name, count in self.counts.items() if self.kinds[name] == kind and count]
        return sorted(found, key=lambda name: -self.counts[name])


_STORES = (".db3", ".mcap")
"""Endings of the file with the messages in a bag of ROS 2."""


def is_bag(path: Path) -> bool:
    """Whether a path is a bag by its name: ``.bag`` of ROS 1; of ROS 2 a folder with ``metadata.yaml``, or its file."""
    return path.suffix in (".bag", *_STORES) or (path / "metadata.yaml").is_file()


@contextmanager
def open_bag(path: Path, purpose: str) -> Iterator[Bag]:
    """Open a bag: a file of ROS 1, or a folder of ROS 2; ``purpose`` begins the error without rosbags.

    Raises MissingExtraError if the package rosbags is not installed, and FileError if it is no bag, or damaged, also
    while messages are read.
    """
    with needs_extra("robot", purpose):
        from rosbags.rosbag1 import Reader as Reader1
        from rosbags.rosbag2 import Reader as Reader2
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    if not path.exists():
        raise FileError(path, "there is no such bag")
    path = path.parent if path.suffix in _STORES else path
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        raise FileError(path, "is no whole ROS 2 bag: metadata.yaml is missing; 'ros2 bag reindex' writes it")
    types = get_typestore(Stores.ROS2_HUMBLE if path.is_dir() else Stores.ROS1_NOETIC)
    try:
        with Reader2(path) if path.is_dir() else Reader1(path) as reader:
            kinds, counts = dict[str, str](), dict[str, int]()
            for one in reader.connections:
                name = one.topic.strip("/")
                kinds[name] = one.msgtype
                counts[name] = counts.get(name, 0) + int(one.msgcount)
                text = str(getattr(one.msgdef, "data", one.msgdef) or "")
                if one.msgtype == DETECTIONS and text and "IDL:" not in text:
                    found = get_types_from_msg(text, one.msgtype)
                    types.register({kind: fields for kind, fields in found.items() if kind not in types.fielddefs})
            if DETECTIONS in kinds.values() and DETECTIONS not in types.fielddefs:
                for name, text in _VISION.items():
                    types.register(get_types_from_msg(text, f"vision_msgs/msg/{name}"))
            yield Bag(path, kinds, counts, reader, types)
    except VbbenchError:
        raise
    except Exception as error:  # whatever rosbags raises on damaged bytes
        raise FileError(path, f"is no whole ROS {2 if path.is_dir() else 1} bag: {error}") from error


def yaw_of(orientation: Any) -> float:
    """The yaw in rad of a quaternion's message."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
