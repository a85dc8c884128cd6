"""Maps of ROS bags: detections, odometry and camera info of ROS 1 and ROS 2."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.lib.own_recording import Walk, make_walk
from tests.lib.ros_messages import Messages
from vbbench.birdify.bags import BagTopics, birdify_bag, files_from_bag
from vbbench.cli import main
from vbbench.errors import FileError
from vbbench.exchange.bags import is_bag
from vbbench.exchange.own.recording import files_in, read_recording

pytestmark = [pytest.mark.extra("rosbags"), pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")]
START = 1_700_000_000
OLD = {  # vision_msgs of ROS 1
    "ObjectHypothesisWithPose": "int64 id\nfloat64 score\ngeometry_msgs/PoseWithCovariance pose",
    "BoundingBox2D": "geometry_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "Detection2D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox2D bbox\nsensor_msgs/Image source_img\nbool is_tracking\nstring tracking_id",
    "Detection2DArray": "std_msgs/Header header\nvision_msgs/Detection2D[] detections",
}
NEW = {  # and of ROS 2
    "Point2D": "float64 x\nfloat64 y",
    "Pose2D": "vision_msgs/Point2D position\nfloat64 theta",
    "ObjectHypothesis": "string class_id\nfloat64 score",
    "ObjectHypothesisWithPose": "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose",
    "BoundingBox2D": "vision_msgs/Pose2D center\nfloat64 size_x\nfloat64 size_y",
    "Detection2D": "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
    "vision_msgs/BoundingBox2D bbox\nstring id",
    "Detection2DArray": OLD["Detection2DArray"],
}


@pytest.fixture(scope="module")
def walk() -> Walk:
    return make_walk(frames=30)


class Writing(Messages):
    """Messages of a bag of ROS 1 or 2."""

    def __init__(self, ros: int) -> None:
        from rosbags.typesys import get_types_from_msg

        super().__init__(ros, START)
        self.roi = (0, 0)
        for name, text in (OLD if ros == 1 else NEW).items():
            self.store.register(get_types_from_msg(text, f"vision_msgs/msg/{name}"))

    def detections(self, time: float, boxes: dict[int, np.ndarray]) -> Any:
        found = [self._detection(name, box, self.header(time)) for name, box in boxes.items()]
        return self.make("vision_msgs/msg/Detection2DArray", header=self.header(time), detections=found)

    def _detection(self, name: int, box: np.ndarray, header: Any) -> Any:
        left, top, width, height = box.tolist()
        x, y = left + width / 2, top + height / 2
        if self.ros == 1:
            centre = self.make("geometry_msgs/msg/Pose2D", x=x, y=y, theta=0.0)
            result = {"id": 1, "score": 0.9}
            image = self.make(
                "sensor_msgs/msg/Image",
                header=header,
                height=0,
                width=0,
                encoding="",
                is_bigendian=0,
                step=0,
                data=np.zeros(0, np.uint8),
            )
            rest = {"source_img": image, "is_tracking": True, "tracking_id": str(name)}
        else:
            point = self.make("vision_msgs/msg/Point2D", x=x, y=y)
            centre = self.make("vision_msgs/msg/Pose2D", position=point, theta=0.0)
            result = {"hypothesis": self.make("vision_msgs/msg/ObjectHypothesis", class_id="person", score=0.9)}
            rest = {"id": str(name)}
        results = [self.make("vision_msgs/msg/ObjectHypothesisWithPose", pose=self.pose(), **result)]
        bbox = self.make("vision_msgs/msg/BoundingBox2D", center=centre, size_x=width, size_y=height)
        return self.make("vision_msgs/msg/Detection2D", header=header, results=results, bbox=bbox, **rest)

    def camera_info(self, walk: Walk) -> Any:
        width, height = walk.camera.picture_size
        focal = walk.camera.focal
        matrix = np.array([focal, 0, width / 2, 0, focal, height / 2, 0, 0, 1.0])
        roi = {"x_offset": 0, "y_offset": 0, "height": self.roi[1], "width": self.roi[0], "do_rectify": False}
        arrays = {"D": np.zeros(5), "K": matrix, "R": np.eye(3).ravel(), "P": np.zeros(12)}
        return self.make(
            "sensor_msgs/msg/CameraInfo",
            header=self.header(0.0),
            height=height,
            width=width,
            distortion_model="plumb_bob",
            **{(name if self.ros == 1 else name.lower()): values for name, values in arrays.items()},
            binning_x=0,
            binning_y=0,
            roi=self.make("sensor_msgs/msg/RegionOfInterest", **roi),
        )

    def rows(self, walk: Walk) -> list[tuple[float, str, str, Any]]:
        """Times, topics, types and messages of a walk."""
        rows = [(0.0, "/camera_info", "sensor_msgs/msg/CameraInfo", self.camera_info(walk))]
        for t, pose in enumerate(walk.poses):
            seen = {k + 1: walk.boxes[t, k] for k in np.flatnonzero(np.isfinite(walk.boxes[t, :, 0]))}
            rows.append((0.1 * t, "/odom", "nav_msgs/msg/Odometry", self.odometry(0.1 * t, pose)))
            rows.append((0.1 * t, "/detections", "vision_msgs/msg/Detection2DArray", self.detections(0.1 * t, seen)))
        return rows


def write_bag(folder: Path, walk: Walk, ros: int, *, second: bool = False, writing: Writing | None = None) -> Path:
    """A bag of a walk; with a ``second`` topic of odometry."""
    writing = writing or Writing(ros)
    rows = writing.rows(walk)
    rows += [(t, "/odom_2", kind, message) for t, name, kind, message in rows if second and name == "/odom"]
    if ros == 1:
        from rosbags.rosbag1 import Writer

        path, bag = folder / "walk.bag", Writer(folder / "walk.bag")
        serialize = writing.store.serialize_ros1
    else:
        from rosbags.rosbag2 import Writer as Writer2

        path, bag = folder / "walk", Writer2(folder / "walk", version=8)
        serialize = writing.store.serialize_cdr
    with bag:
        topics = {
            name: bag.add_connection(name, kind, typestore=writing.store)
            for name, kind in {row[1]: row[2] for row in rows}.items()
        }
        for time, name, kind, message in rows:
            bag.write(topics[name], writing.nanoseconds(time + 0.05), serialize(message, kind))
    return path


@pytest.mark.slow
@pytest.mark.parametrize(("ros", "defined"), [(1, True), (2, True), (2, False)])
def test_a_bag_becomes_a_map(tmp_path: Path, walk: Walk, ros: int, defined: bool) -> None:
    path, out = write_bag(tmp_path, walk, ros).rename(tmp_path / "map.bag"), tmp_path / "map"  # a bag's usual name
    if not defined:  # as before ROS 2 Iron
        with closing(sqlite3.connect(next(path.glob("*.db3")))) as storage:
            storage.executescript("DROP TABLE message_definitions; UPDATE schema SET schema_version = 3;")
    topics = ["--boxes", "/detections", "--odometry", "odom", "--camera", "/camera_info", "--mount-height", "1.5"]
    given = str(path) if ros == 1 else f"bag:{next(path.glob('*.db3'))}" if defined else f"bag:{path}"
    assert main(["birdify", given, *topics, "--out", str(out), "--solver", "cv"]) == 0
    assert path.exists()
    assert not (tmp_path / "map.from-bag").exists()
    rows = np.genfromtxt(out / "recording" / "boxes.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    seen = np.argwhere(np.isfinite(walk.boxes[..., 0]))
    np.testing.assert_allclose(rows["time"] - START, 0.1 * seen[:, 0], atol=1e-6)
    np.testing.assert_array_equal(rows["id"], seen[:, 1] + 1)
    np.testing.assert_allclose(rows["left"], walk.boxes[seen[:, 0], seen[:, 1], 0])
    assert set(rows["class" if ros == 1 else "class_name"].tolist()) == {1 if ros == 1 else "person"}
    odometry = np.loadtxt(out / "recording" / "odometry.txt")
    np.testing.assert_allclose(odometry[:, 1:3], walk.poses[:, :2])


@pytest.mark.parametrize("ros", [1, 2])
def test_topics_that_are_missing_or_several_are_listed(tmp_path: Path, walk: Walk, ros: int) -> None:
    path = write_bag(tmp_path, walk, ros, second=True)
    mount = {"mount": {"mount_height": 1.5}}
    with pytest.raises(FileError, match=r"--odometry is open; of type nav_msgs/Odometry it has /odom, /odom_2"):
        birdify_bag(path, tmp_path / "map", BagTopics(), **mount)
    with pytest.raises(FileError, match=r"--boxes names no topic of the bag: /people; .* it has /detections"):
        birdify_bag(path, tmp_path / "map", BagTopics(boxes="/people"), **mount)
    with pytest.raises(FileError, match=r"--camera names no topic of the bag: /info; .* it has /camera_info"):
        birdify_bag(path, tmp_path / "map", BagTopics(odometry="/odom", camera="/info"), **mount)
    assert not (tmp_path / "map.from-bag").exists(), "nothing is half-written"


def test_what_is_no_bag(tmp_path: Path) -> None:
    (tmp_path / "no.bag").write_text("nothing")
    with pytest.raises(FileError, match="there is no such bag"):
        birdify_bag(tmp_path / "none", tmp_path / "map", BagTopics())
    for path, kind in ((tmp_path / "no.bag", "1"), (tmp_path, "2")):
        with pytest.raises(FileError, match=f"is no whole ROS {kind} bag"):
            birdify_bag(path, tmp_path / "map", BagTopics())
    (tmp_path / "walk.db3").touch()
    assert is_bag(tmp_path / "walk.db3")
    with pytest.raises(FileError, match=r"metadata.yaml is missing; 'ros2 bag reindex' writes it"):
        birdify_bag(tmp_path / "walk.db3", tmp_path / "map", BagTopics())


class Optical(Writing):
    """Odometry of a camera's own axes, and a camera info of a part of the picture."""

    def odometry(self, time: float, pose: np.ndarray) -> Any:
        message = super().odometry(time, pose)
        optical = Rotation.from_euler("z", pose[2]) * Rotation.from_quat([-0.5, 0.5, -0.5, 0.5])
        names = dict(zip("xyzw", optical.as_quat().tolist(), strict=True))
        message.pose.pose.orientation = self.make("geometry_msgs/msg/Quaternion", **names)
        return message


@pytest.mark.slow
def test_odometry_may_be_of_the_camera_and_a_region_of_interest_is_refused(tmp_path: Path, walk: Walk) -> None:
    writing, mount = Optical(2), {"mount_height": 1.5}
    path = write_bag(tmp_path, walk, 2, writing=writing)
    birdify_bag(path, tmp_path / "map", BagTopics(), mount=mount, solver="cv")
    odometry = read_recording(files_in(tmp_path / "map" / "recording")).footage.odometry
    np.testing.assert_allclose(
        odometry.motions[1:, 0], np.linalg.norm(np.diff(walk.poses[:, :2], axis=0), axis=1), atol=0.01
    )
    np.testing.assert_allclose(odometry.motions[1:, 2], np.diff(walk.poses[:, 2]), atol=1e-6)
    writing.roi = (640, 360)
    (tmp_path / "part").mkdir()
    with pytest.raises(FileError, match="has a roi"):
        birdify_bag(
            write_bag(tmp_path / "part", walk, 2, writing=writing), tmp_path / "again", BagTopics(), mount=mount
        )


def test_messages_that_were_recorded_twice_count_once(tmp_path: Path, walk: Walk) -> None:
    class Twice(Writing):
        def rows(self, walk: Walk) -> list[tuple[float, str, str, Any]]:
            return sorted(2 * super().rows(walk), key=lambda row: row[0])

    files = files_from_bag(write_bag(tmp_path, walk, 2, writing=Twice(2)), BagTopics(), tmp_path / "files")
    recording = read_recording(files, mount={"mount_height": 1.5})
    assert recording.footage.boxes.shape[:2] == (30, 8)
    assert recording.footage.odometry is not None
