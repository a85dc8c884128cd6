"""Made footage: a camera walks among people, of which everything is known, or less; and solvers that answer it."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from vbbench.camera import PerspectiveCamera
from vbbench.estimate import FrameEstimate
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import Pictures
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import Footage, Recordings
from vbbench.generation.generator import Card, Options
from vbbench.geometry import relative_to_world, world_to_relative
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_generators.footage.split import FootageSplit

CARD = Card(name="walk", title="A walk", licence="CC0", citation="-", sources=())
FRAMES, PEOPLE = 30, 5
KINDS = ("whole", "poses", "relative", "none")
"""What may be known of footage."""


def recording(name: str = "one", mount_height: float = 1.5, **changes: Any) -> Footage:
    """A camera walks forward among people who cross, and one track is no person's."""
    rng, time = np.random.default_rng(len(name)), 0.4 * np.arange(FRAMES)
    camera = PerspectiveCamera(mount_height=mount_height)
    poses = np.stack([0.5 * time, 0.1 * time, 0.02 * time], axis=-1)
    start = rng.uniform([8.0, -4.0], [14.0, 4.0], (PEOPLE, 2))
    people = start + time[:, None, None] * rng.normal(0.0, 0.3, (PEOPLE, 2))
    heights = rng.normal(1.72, 0.05, PEOPLE)
    boxes = camera.project(world_to_relative(people, poses), np.broadcast_to(heights, people.shape[:2]))
    boxes[:4, 0] = np.nan
    boxes = np.concatenate([boxes, boxes[:, -1:] + 30.0], axis=1)
    persons = np.where(np.isnan(boxes[..., 2]), NOBODY, np.append(np.arange(PEOPLE), NOBODY) * 10)
    persons[:, -1] = NOBODY
    facts: dict[str, Any] = {
        "name": name,
        "camera": camera,
        "dt": 0.4,
        "tracks": np.arange(PEOPLE + 1),
        "boxes": boxes,
        "visible": np.where(np.isnan(boxes[..., 2]), np.nan, 1.0),
        "poses": poses,
        "scene": Scene(name=name, dt=0.4, people=10 * np.arange(PEOPLE), positions=people, heights=heights),
        "persons": persons,
    }
    return Footage(**{**facts, **changes})


def relative(one: Footage) -> Footage:
    """The same where only the places from the camera are known."""
    scene = replace(one.scene, positions=world_to_relative(one.scene.positions, one.poses))
    return replace(one, poses=None, scene=scene)


def known_as(kind: str, **changes: Any) -> Footage:
    """The recording, with less known of it."""
    whole = recording(**changes)
    if kind == "relative":
        return relative(whole)
    unknown = {"whole": (), "poses": ("scene", "persons"), "none": ("scene", "persons", "poses")}[kind]
    return replace(whole, **dict.fromkeys(unknown))


@dataclass(frozen=True, kw_only=True)
class Walk(FootageSplit):
    """A split of made recordings."""

    card: Card = CARD
    found: tuple[Footage, ...] = ()

    def recordings(self, options: Options) -> Recordings:
        return Recordings(footage=self.found, definition={})


def made(folder: Any, *found: Footage, **options: Any) -> Dataset:
    """The dataset of some recordings."""
    return write_dataset(Walk(found=found).plan(Options(**options)), folder)


@pytest.fixture
def photographed(tmp_path: Path) -> Dataset:
    """Every frame but the last has a picture, a quarter as wide as the camera's, of its own colour."""
    (tmp_path / "photos").mkdir()
    for frame in range(FRAMES - 1):
        Image.new("RGB", (320, 180), (10 * frame % 256, 200, 40)).save(tmp_path / "photos" / f"{frame:03d}.png")
    pictures = Pictures(pattern=str(tmp_path / "photos" / "{:03d}.png"), first=0, step=1)
    return made(tmp_path / "d", recording(pictures=pictures))


class Still:
    """Stands where it was first and places people where their boxes are at the mean height."""

    def start(self, problem: Any) -> None:
        self.problem = problem

    def pose(self, frame: Any) -> Any:
        self.start_pose = frame.given.poses[2] if frame.index == 0 else self.start_pose
        return np.array(self.start_pose)

    def step(self, frame: Any) -> FrameEstimate:
        pose, heights = self.pose(frame), np.full(len(frame.observations), self.problem.height_mean)
        places = relative_to_world(self.problem.camera.unproject(frame.observations, heights), pose)
        return FrameEstimate(pose=pose, positions=places)


class Walker(Still):
    """Walks along the diagonal and turns, which is wrong, and places people by their boxes."""

    def pose(self, frame: Any) -> Any:
        return np.array([0.1 * frame.index, 0.2 * frame.index, 0.05 * frame.index])


class Watcher(Still):
    """Checks that odometry of frame t is shown at t, and never before."""

    def step(self, frame: Any) -> FrameEstimate:
        forward = frame.given.odometry.motions[:, 0]
        expected = np.array([3.0 * (t - 1) if t > 0 else np.nan for t in range(frame.index - 2, frame.index + 1)])
        np.testing.assert_array_equal(forward, expected)
        return super().step(frame)
