"""The ROS 2 package in docs/ros2, run with stand-ins for ROS: the messages as they are defined, and nothing else."""

import re
import runpy
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

PACKAGE = Path(__file__).parents[2] / "docs" / "ros2" / "vbbench_ros"


class Node:
    """What the node uses of ``rclpy.node.Node``."""

    def __init__(self, name: str) -> None:
        self.published: dict[str, list[Any]] = {}
        self.warnings: list[str] = []
        self.subscribed: dict[str, Any] = {}
        self.chosen = dict(PARAMETERS["birdifier"]["ros__parameters"])

    def declare_parameter(self, name: str, value: Any) -> Any:
        return SimpleNamespace(value=self.chosen.pop(name, value))

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=self.published.setdefault(topic, []).append)

    def create_subscription(self, kind: type, topic: str, callback: Any, depth: int) -> None:
        self.subscribed[topic] = callback

    def get_logger(self) -> Any:
        return SimpleNamespace(warning=self.warnings.append)


PARAMETERS = yaml.safe_load((PACKAGE / "config" / "birdifier.yaml").read_text("utf-8"))


class Broadcaster:
    """What it uses of ``tf2_ros.TransformBroadcaster``."""

    def __init__(self, node: Node) -> None:
        self.sendTransform = node.published.setdefault("tf", []).append


def header() -> Any:
    return SimpleNamespace(stamp=None, frame_id="")


def pose_with_covariance() -> Any:
    pose = SimpleNamespace(position=point(0.0, 0.0), orientation=quaternion(0.0))
    return SimpleNamespace(pose=pose, covariance=36 * [0.0])


def pose_with_covariance_stamped() -> Any:
    return SimpleNamespace(header=header(), pose=pose_with_covariance())


def transform_stamped() -> Any:
    transform = SimpleNamespace(translation=point(0.0, 0.0), rotation=quaternion(0.0))
    return SimpleNamespace(header=header(), child_frame_id="", transform=transform)


def detection_3d() -> Any:
    pose = SimpleNamespace(position=point(0.0, 0.0), orientation=quaternion(0.0))
    bbox = SimpleNamespace(center=pose, size=point(0.0, 0.0))
    return SimpleNamespace(header=header(), id="", results=[], bbox=bbox)


def hypothesis() -> Any:
    return SimpleNamespace(hypothesis=SimpleNamespace(class_id="", score=0.0), pose=pose_with_covariance())


def camera_info(focal: float = 910.0) -> Any:
    rectified = [focal, 0.0, 640.0, 0.0, 0.0, focal, 360.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    return SimpleNamespace(width=1280, height=720, p=rectified)


def point(x: float, y: float) -> Any:
    return SimpleNamespace(x=x, y=y, z=0.0)


def quaternion(yaw: float) -> Any:
    return SimpleNamespace(x=0.0, y=0.0, z=np.sin(yaw / 2), w=np.cos(yaw / 2))


def detections(seconds: float, *boxes: tuple[str, str, float]) -> Any:
    """A message of boxes (id, class, centre column)."""
    found = [
        SimpleNamespace(
            id=track,
            results=[SimpleNamespace(hypothesis=SimpleNamespace(class_id=kind, score=0.9))],
            bbox=SimpleNamespace(
                center=SimpleNamespace(position=SimpleNamespace(x=column, y=400.0), theta=0.0),
                size_x=80.0,
                size_y=200.0,
            ),
        )
        for track, kind, column in boxes
    ]
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp_of(seconds)), detections=found)


def odometry(seconds: float, x: float, y: float, yaw: float) -> Any:
    pose = SimpleNamespace(position=point(x, y), orientation=quaternion(yaw))
    header = SimpleNamespace(stamp=stamp_of(seconds))
    return SimpleNamespace(header=header, pose=SimpleNamespace(pose=pose, covariance=36 * [0.0]))


def stamp_of(seconds: float) -> Any:
    return SimpleNamespace(sec=int(seconds), nanosec=round(1e9 * (seconds % 1.0)))


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """The node's module."""
    modules: dict[str, dict[str, Any]] = {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "geometry_msgs.msg": {
            "PoseWithCovarianceStamped": pose_with_covariance_stamped,
            "TransformStamped": transform_stamped,
        },
        "nav_msgs.msg": {"Odometry": object},
        "sensor_msgs.msg": {"CameraInfo": object},
        "tf2_ros": {"TransformBroadcaster": Broadcaster},
        "vision_msgs.msg": {
            "Detection2DArray": object,
            "Detection3D": detection_3d,
            "Detection3DArray": lambda: SimpleNamespace(header=header(), detections=[]),
            "ObjectHypothesisWithPose": hypothesis,
        },
    }
    for name, contents in modules.items():
        stand_in = ModuleType(name)
        vars(stand_in).update(contents)
        monkeypatch.setitem(sys.modules, name, stand_in)
    return SimpleNamespace(**runpy.run_path(str(PACKAGE / "vbbench_ros" / "birdifier.py")))


@pytest.fixture
def node(module: SimpleNamespace) -> Any:
    """The node with the parameters of its file, and a camera."""
    node = module.Birdifier()
    assert not node.chosen, "the parameters file has names that the node does not know"
    node.on_camera(camera_info(0.0))
    assert node.session is None
    node.on_camera(camera_info())
    return node


def drive(node: Any, begin: float, rate: float = 50.0) -> None:
    """Two seconds of odometry of a base that goes to its left at 1 m/s, looking there, and is heard of before boxes."""
    for step in range(int(2.0 * rate)):
        node.on_odometry(odometry(begin + step / rate, 5.0, step / rate, np.pi / 2))


def test_the_node_publishes_poses_and_warns_of_what_it_leaves_out(node: Any) -> None:
    people = ("7", "person", 640.0), ("9", "person", 900.0)
    drive(node, 9.9)
    for step in range(5):
        node.on_frame(detections(10.0 + 0.1 * step, *people, ("", "person", 100.0), ("3", "dog", 300.0)))
    assert not node.warnings
    node.on_frame(detections(10.4, *people))
    node.on_frame(detections(10.5, *people, people[0]))
    assert len(node.warnings) == 2
    node.on_frame(detections(10.6, *people))
    published = node.published["pose"]
    assert len(published) == 6
    first, last = published[0], published[-1]
    # The map begins at the camera, which is .2 m ahead of the base.
    assert (first.pose.pose.position.x, first.pose.pose.position.y) == (-0.2, 0.0)
    assert last.header.frame_id == "map"
    assert last.pose.pose.position.x == pytest.approx(0.4, abs=0.1)
    covariance = np.array(last.pose.covariance).reshape(6, 6)
    assert (covariance[[0, 1, 5], [0, 1, 5]] > 0.0).all()
    assert len(last.pose.covariance) == 36


def test_people_have_ids_places_and_heights(node: Any) -> None:
    drive(node, 9.9)
    for step in range(5):
        node.on_frame(detections(10.0 + 0.1 * step, ("7", "person", 640.0), ("9", "person", 900.0)))
    people = node.published["people"][-1]
    assert (people.header.frame_id, people.header.stamp.sec) == ("map", 10)
    assert [person.id for person in people.detections] == ["7", "9"]
    for person, right in zip(people.detections, (0.0, 2.3), strict=True):
        centre, found = person.bbox.center.position, person.results[0]
        assert centre.y == pytest.approx(-right, abs=0.5)
        assert 5.0 < centre.x < 10.0
        assert centre.z == person.bbox.size.z / 2
        assert 1.5 < person.bbox.size.z < 2.0
        assert found.hypothesis.class_id == "person"
        assert np.linalg.eigvalsh(np.reshape(found.pose.covariance, (6, 6))[:2, :2]).min() > 0.0


def test_map_to_odom_puts_the_robot_where_its_pose_is(node: Any) -> None:
    """REP 105: map to odom, and odom to base_link by the robot itself, lead to the pose that is published."""
    drive(node, 9.9)
    for step in range(4):
        node.on_frame(detections(10.0 + 0.1 * step, ("7", "person", 640.0), ("9", "person", 900.0)))
    moved, pose = node.published["tf"][-1], node.published["pose"][-1].pose.pose
    assert (moved.header.frame_id, moved.child_frame_id) == ("map", "odom")
    turn = 2.0 * np.arctan2(moved.transform.rotation.z, moved.transform.rotation.w)
    x, y, yaw = node.base_at(10.3)
    place = np.exp(1j * turn) * complex(x, y) + complex(moved.transform.translation.x, moved.transform.translation.y)
    assert place == pytest.approx(complex(pose.position.x, pose.position.y), abs=1e-9)
    assert np.exp(1j * (turn + yaw)) == pytest.approx(np.exp(2j * np.arctan2(pose.orientation.z, pose.orientation.w)))


def test_a_camera_may_look_to_a_side(module: SimpleNamespace) -> None:
    base = np.array([3.0, -1.0, 0.7])
    wheels = module.OdometryFacts(mount=(0.3, 0.1, 1.2))
    np.testing.assert_allclose(module.carrier(wheels.of_camera(base[None])[0], wheels.mount), base, atol=1e-12)


def test_without_odometry_or_camera_it_goes_on(module: SimpleNamespace) -> None:
    node, people = module.Birdifier(), (("7", "person", 640.0), ("9", "person", 900.0))
    node.on_frame(detections(10.0, *people))
    assert "no camera_info" in node.warnings[0]
    node.on_camera(camera_info())
    node.on_frame(detections(10.1, *people))
    assert {topic: len(sent) for topic, sent in node.published.items()} == {"pose": 1, "people": 1, "tf": 0}


def test_the_node_looks_odometry_up_between_its_messages(node: Any) -> None:
    drive(node, 9.9, rate=7.0)
    assert node.base_at(10.55) == pytest.approx([5.0, 0.65, np.pi / 2], abs=1e-9)
    assert node.base_at(9.0) is None
    assert node.base_at(13.0) is None


def test_the_node_begins_a_new_map_where_the_clock_was_set_back(node: Any) -> None:
    """As where a bag is played in a loop, or the first stamp is 0."""
    people = ("7", "person", 640.0), ("9", "person", 900.0)
    for begin in (1.7e9, 10.0, 1.8e9):
        drive(node, begin)
        for step in range(4):
            node.on_frame(detections(begin + 0.1 * step, *people))
    published = node.published["pose"]
    assert len(published) == 12
    assert len(node.warnings) == 2
    assert published[4].pose.pose.position.x == -0.2


def test_the_package_installs_what_it_launches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Names agree in package.xml, setup.py, the launch file and the page; what is imported is depended on."""
    declared: dict[str, Any] = {}
    setuptools = ModuleType("setuptools")
    vars(setuptools)["setup"] = lambda **given: declared.update(given)
    monkeypatch.setitem(sys.modules, "setuptools", setuptools)
    runpy.run_path(str(PACKAGE / "setup.py"))
    manifest = ElementTree.parse(PACKAGE / "package.xml").getroot()  # noqa: S314  a file of ours
    assert manifest.findtext("name") == declared["name"] == PACKAGE.name
    assert manifest.findtext("version") == declared["version"]
    assert manifest.findtext("export/build_type") == "ament_python"
    for _, files in declared["data_files"]:
        assert all((PACKAGE / file).is_file() for file in files)
    node = (PACKAGE / "vbbench_ros" / "birdifier.py").read_text("utf-8")
    launch = (PACKAGE / "launch" / "birdifier.launch.py").read_text("utf-8")
    used = set(re.findall(r"(?m)^from (\w+_msgs|tf2_ros|rclpy|launch_ros)\b", node + launch))
    assert used <= {element.text for element in manifest.iter("exec_depend")}
    page = (PACKAGE.parents[1] / "robot.md").read_text("utf-8")
    (topics,) = re.findall(r"(?m)^TOPICS = \((.*)\)$", launch)
    for topic in re.findall(r'"(\w+)"', topics):
        assert f'"{topic}", self.on_' in node
        assert f"| `{topic}` |" in page
