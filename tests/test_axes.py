"""Axes of trajectories: each usual convention becomes the same poses, or is refused by its name."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vbbench.errors import FileError
from vbbench.exchange.axes import AXES, ground_poses, off_course
from vbbench.exchange.trajectory import read_trajectory
from vbbench.geometry import motion_between, wrap_angle

FLU_TO = {
    "camera": np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], float),
    "opengl": np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0]], float),
    "ned": np.diag([1.0, -1.0, -1.0]),
    "imu": np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], float),
    "unity": np.array([[0, -1, 0], [0, 0, 1], [1, 0, 0]], float),
    "unreal": np.diag([1.0, -1.0, 1.0]),
    "body": np.eye(3),
}
"""Rows: the axes x, y, z of a convention in (forward, left, up)."""


def drive(bend: float = 1.57, way: float = 6.0, rows: int = 60, still: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Places [N, 3] and yaws [N] of a body that goes ``way`` m and turns by ``bend`` rad, after it stood."""
    share = np.append(np.zeros(still), np.linspace(0.0, 1.0, rows))
    yaw = bend * share**2
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    steps = way * np.diff(share)[:, None] * np.stack([np.cos(middle), np.sin(middle), 0.0 * middle], axis=-1)
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]), yaw


def rotations_of(yaw: np.ndarray, pitch: float = 0.0) -> np.ndarray:
    """[N, 3, 3] of a body (forward, left, up) that looks up by ``pitch``."""
    return Rotation.from_euler("ZY", np.stack([yaw, np.full(len(yaw), -pitch)], axis=-1)).as_matrix()


def written(path: Path, places: np.ndarray, rotations: np.ndarray, *, first: bool = False, noise: float = 0.0) -> Path:
    """A TUM file; ``first`` with qw before qx."""
    quaternions = Rotation.from_matrix(rotations).as_quat()
    quaternions = np.roll(quaternions, 1, axis=1) if first else quaternions
    places = places + np.random.default_rng(0).normal(0.0, noise, places.shape)
    rows = np.column_stack([0.1 * np.arange(len(places)), places, quaternions])
    path.write_text("".join(" ".join(f"{value:.7f}" for value in row) + "\n" for row in rows))
    return path


def changed(places, rotations, axes: str, *, world: bool) -> tuple[np.ndarray, np.ndarray]:
    """The same in other axes of the body and, with ``world``, of the world."""
    body = FLU_TO[axes]
    outer = body if world else np.eye(3)
    return places @ outer.T, outer @ rotations @ body.T


def same_motion(poses: np.ndarray, places: np.ndarray, yaw: np.ndarray, atol: float = 2e-3) -> None:
    wanted = np.column_stack([places[:, :2], yaw])
    found, wanted = (motion_between(np.broadcast_to(one[0], one.shape), one) for one in (poses, wanted))
    np.testing.assert_allclose(found[:, :2], wanted[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_angle(found[:, 2] - wanted[:, 2]), 0.0, atol=atol)


@pytest.mark.parametrize("pitch", [0.0, -0.17])
@pytest.mark.parametrize("bend", [0.0, 0.15, 1.57, -3.0])
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize(
    ("axes", "world"), [("body", True), ("camera", True), ("camera", False), ("opengl", False), ("unity", True)]
)
def test_motion_shows_axes_and_order(tmp_path, pitch, bend, first, axes, world):
    places, yaw = drive(bend)
    path = written(tmp_path / "t.txt", *changed(places, rotations_of(yaw, pitch), axes, world=world), first=first)
    same_motion(ground_poses(read_trajectory(path)).poses, places, yaw)
