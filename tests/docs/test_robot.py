"""The ROS 2 node of docs/robot.md, run with stand-ins for ROS: the messages as they are defined, and nothing else."""

import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "robot.md").read_text("utf-8")


class Node:
    """What the page uses of ``rclpy.node.Node``."""

    def __init__(self, name: str) -> None:
        self.published: list[Any] = []
        self.warnings: list[str] = []

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=self.published.append)

    def create_subscription(self, kind: type, topic: str, callback: Any, depth: int) -> None:
        """As ROS, which calls it from then on."""

    def get_logger(self) -> Any:
        return SimpleNamespace(warning=self.warnings.append)


def pose_with_covariance_stamped() -> Any:
    pose = SimpleNamespace(position=point(0.0, 0.0), orientation=quaternion(0.0))
    return SimpleNamespace(
        header=SimpleNamespace(stamp=None, frame_id=""), pose=SimpleNamespace(pose=pose, covariance=36 * [0.0])
    )


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
def node(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The page's node."""
    modules: dict[str, dict[str, Any]] = {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "geometry_msgs.msg": {"PoseWithCovarianceStamped": pose_with_covariance_stamped},
        "nav_msgs.msg": {"Odometry": object},
        "vision_msgs.msg": {"Detection2DArray": object},
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    functions = re.search(r"^def planar.*?(?=^camera = )", PAGE, re.M | re.S)
    text = PAGE.partition("## In a ROS 2 node")[2].partition("\n## ")[0]
    block = "\n".join(line[4:] for line in text.splitlines() if line.startswith("    ") or not line)
    assert functions is not None
    names: dict[str, Any] = {"np": np}
    exec(functions[0], names)  # noqa: S102
    exec(block[block.index("from collections") :], names)  # noqa: S102
    return names["Birdifier"]()


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
    assert len(node.published) == 6
    first, last = node.published[0], node.published[-1]
    assert (first.pose.pose.position.x, first.pose.pose.position.y) == (0.0, 0.0)
    assert last.header.frame_id == "birdified_map"
    assert last.pose.pose.position.x == pytest.approx(0.6, abs=0.1)
    covariance = np.array(last.pose.covariance).reshape(6, 6)
    assert (covariance[[0, 1, 5], [0, 1, 5]] > 0.0).all()
    assert len(last.pose.covariance) == 36


def test_the_node_looks_odometry_up_between_its_messages(node: Any) -> None:
    drive(node, 9.9, rate=7.0)
    found = node.camera_at(10.55)
    assert found == pytest.approx([5.0, 0.65 + 0.2, np.pi / 2], abs=1e-9)
    assert node.camera_at(9.0) is None
    assert node.camera_at(13.0) is None


def test_the_node_begins_a_new_map_where_the_clock_was_set_back(node: Any) -> None:
    """As where a bag is played in a loop, or the first stamp is 0."""
    people = ("7", "person", 640.0), ("9", "person", 900.0)
    for begin in (1.7e9, 10.0, 1.8e9):
        drive(node, begin)
        for step in range(4):
            node.on_frame(detections(begin + 0.1 * step, *people))
    assert len(node.published) == 12
    assert len(node.warnings) == 2
    assert node.published[4].pose.pose.position.x == 0.0
