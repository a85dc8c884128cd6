"""The ROS 2 node of docs/robot.md, run with stand-ins for ROS: the messages as they are defined, and nothing else."""

import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

PAGE = (Path(__file__).parent.parent / "docs" / "robot.md").read_text("utf-8")


class Node:
    """What the page uses of ``rclpy.node.Node``."""

    def __init__(self, name: str) -> None:
        self.published: list[Any] = []
        self.warnings: list[str] = []

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=self.published.append)

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
    stamp = SimpleNamespace(sec=int(seconds), nanosec=round(1e9 * (seconds % 1.0)))
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp), detections=found)


def odometry(x: float, y: float, yaw: float) -> Any:
    pose = SimpleNamespace(position=point(x, y), orientation=quaternion(yaw))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose, covariance=36 * [0.0]))


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The page's node."""
    filters = SimpleNamespace(registerCallback=lambda callback: None)
    modules: dict[str, dict[str, Any]] = {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "geometry_msgs.msg": {"PoseWithCovarianceStamped": pose_with_covariance_stamped},
        "nav_msgs.msg": {"Odometry": object},
        "vision_msgs.msg": {"Detection2DArray": object},
        "message_filters": {
            "Subscriber": lambda node, kind, topic: (kind, topic),
            "ApproximateTimeSynchronizer": lambda inputs, queue_size, slop: filters,
        },
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
    exec(block[block.index("import numpy") :], names)  # noqa: S102
    return names["Birdifier"]()


def test_the_node_publishes_poses_and_warns_of_what_it_leaves_out(node: Any) -> None:
    people = ("7", "person", 640.0), ("9", "person", 900.0)
    for step in range(5):
        node.on_frame(
            detections(10.0 + 0.1 * step, *people, ("", "person", 100.0), ("3", "dog", 300.0)),
            odometry(5.0, 0.1 * step, np.pi / 2),
        )
    assert not node.warnings
    node.on_frame(detections(10.4, *people), odometry(5.0, 0.4, np.pi / 2))
    node.on_frame(detections(10.5, *people, people[0]), odometry(5.0, 0.5, np.pi / 2))
    assert len(node.warnings) == 2
    node.on_frame(detections(10.6, *people), odometry(5.0, 0.6, np.pi / 2))
    assert len(node.published) == 6
    first, last = node.published[0], node.published[-1]
    assert (first.pose.pose.position.x, first.pose.pose.position.y) == (0.0, 0.0)
    assert last.header.frame_id == "birdified_map"
    assert 0.2 < last.pose.pose.position.x < 1.0
    covariance = np.array(last.pose.covariance).reshape(6, 6)
    assert (covariance[[0, 1, 5], [0, 1, 5]] > 0.0).all()
    assert len(last.pose.covariance) == 36
