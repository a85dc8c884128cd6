"""A crowd seen from a vehicle by a camera that is not what its calibration says: for the tests of rough cameras."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.made_sequence import sequence_of
from vbbench.camera import Camera, PerspectiveCamera
from vbbench.geometry import FloatArray, world_to_relative, wrap_angle
from vbbench.protocol import get_protocol
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Estimate, Problem
from vbbench.solving.runner import given_at, run_sequence
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.tracking import Tracking

DT = 0.4
LEVEL = PerspectiveCamera()
TILTED = PerspectiveCamera(pitch=0.04, roll=-0.01)
"""What the calibration says, and what the camera is."""

BOX_STD = 0.02
"""Noise of a detector, as a share of the box."""


EDGE = 0.45
"""By how many m the side of a body that a box ends at is nearer than its middle."""


def drive(
    seed: int, frames: int = 30, people: int = 25, speed: float = 1.5, turning: float = 0.01, wander: float = 0.0
) -> Truth:
    """A vehicle among people who walk at constant velocity but for a few cm.

    With ``wander``, their second differences are that many m, and the vehicle's speed and turning change, too.
    """
    rng = np.random.default_rng(seed)
    swerves, surges = rng.normal(0.0, 0.002, frames), np.cumsum(rng.normal(0.0, 0.5 * wander, frames))
    yaw = np.pi / 2 + turning * np.arange(1, frames + 1) + np.cumsum(swerves)
    steps = (speed * DT + surges)[:, None] * np.stack((np.cos(yaw), np.sin(yaw)), axis=-1)
    poses = np.column_stack((np.cumsum(steps, axis=0), wrap_angle(yaw)))
    start = np.column_stack((rng.uniform(-5.0, 5.0, people), rng.uniform(7.0, 14.0 + speed * DT * frames, people)))
    velocity = np.column_stack((rng.uniform(-0.4, 0.4, people), rng.uniform(-1.2, 1.2, people)))
    positions = start + velocity * DT * np.arange(frames)[:, None, None]
    positions += np.cumsum(rng.normal(0.0, 0.01, positions.shape), axis=0)
    positions += np.cumsum(np.cumsum(rng.normal(0.0, wander, positions.shape), axis=0), axis=0)
    return Truth(poses=poses, positions=positions, heights=np.clip(rng.normal(1.7, 0.07, people), 1.5, 1.95))


def photograph(
    truth: Truth,
    camera: Camera = TILTED,
    box_std: float = BOX_STD,
    *,
    pixel_std: float = 0.0,
    edge: float = EDGE,
    seed: int = 0,
) -> FloatArray:
    """Boxes [T, K, 3] of the near sides of bodies; column, top and bottom are each off by a share of the height."""
    heights = np.broadcast_to(truth.heights, truth.positions.shape[:2])
    relative = world_to_relative(truth.positions, truth.poses)
    relative *= 1.0 - edge / np.maximum(np.linalg.norm(relative, axis=-1, keepdims=True), 1.0)
    boxes = camera.project(relative, heights)
    spread = np.hypot(box_std * boxes[..., 2], pixel_std)
    u, top, bottom = np.random.default_rng(seed).normal(0.0, 1.0, (3, *boxes.shape[:2])) * spread
    noisy: FloatArray = boxes + np.stack((u, 0.5 * (top + bottom), bottom - top), axis=-1)
    return noisy


def problem_of(sequence: Sequence, camera: Camera = LEVEL, **facts: Any) -> Problem:
    """A problem that says of its camera what ``facts`` say: by default, that boxes are not exact."""
    return Problem(
        camera=camera,
        dt=DT,
        tracks=sequence.tracks,
        height_mean=1.7,
        height_std=0.07,
        **{"pixel_std": 1.0, "box_std": BOX_STD, **facts},
    )


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A drive with what is seen of it, and the problem that it poses."""

    truth: Truth
    sequence: Sequence
    problem: Problem

    def solved(self, make: Callable[[], Any], protocol: str = "sequential") -> Estimate:
        """The estimate of a solver."""
        return run_sequence(make(), self.problem, self.sequence, get_protocol(protocol), self.truth)[0]

    def errors(self, estimate: Estimate) -> FloatArray:
        """[T] by how many m the observer's place is off."""
        off: FloatArray = np.linalg.norm((estimate.poses - self.truth.poses)[:, :2], axis=1)
        return off


def made_drive(truth: Truth, boxes: FloatArray | None = None, **facts: Any) -> Drive:
    """What is seen of ``truth``, by default by the tilted camera, and a problem that takes the camera for level."""
    sequence = sequence_of(truth, photograph(truth) if boxes is None else boxes)
    return Drive(truth=truth, sequence=sequence, problem=problem_of(sequence, **facts))


@dataclass(frozen=True)
class Window:
    """A window in the middle of being solved."""

    point: Point
    seen: Seen
    model: Model


def made_window(frames: int = 7, people: int = 4, seed: int = 3) -> Window:
    """A few frames of a drive, as they were believed when the last was solved; no pose but the first two is given."""
    made = made_drive(drive(seed, frames, people))
    tracking = Tracking(Settings(window=frames), made.problem)
    for t, boxes in enumerate(made.sequence.observations):
        tracking.step(boxes, given_at(made.sequence.given, t))
    rows = tracking.rows
    seen, columns = rows.seen()
    point = Point(rows.frames.copy(), rows.places[:, columns].copy(), rows.numbers[columns], rows.variances[columns])
    return Window(point, seen, tracking.model)
