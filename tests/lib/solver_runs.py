"""Walks, what a camera sees of them, and a solver's answer: shared by the tests of solvers."""

from dataclasses import replace
from typing import Any

import numpy as np

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.geometry import FloatArray, motion_between, world_to_relative, wrap_angle
from vbbench.protocol import get_protocol
from vbbench.sequence import Given, Odometry, Sequence, Truth
from vbbench.solver import Estimate, FrameSolver, Problem
from vbbench.solving.runner import run_sequence
from vbbench_baselines.extrapolation import ConstantVelocity, SocialForce
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

CAMERAS: list[Camera] = [PanoramaCamera(), PerspectiveCamera()]
BIRDIFIERS = [ConstantVelocityBirdifier, SocialForceBirdifier]
SOLVERS = [ConstantVelocity, SocialForce, *BIRDIFIERS]
DT = 0.4


def walk(seed: int, frames: int = 8, people: int = 6, wobble: float = 0.0) -> Truth:
    """People in front of an observer who turns its head; everybody at constant velocity but for ``wobble`` m."""
    rng = np.random.default_rng(seed)
    start = np.column_stack((rng.uniform(-2, 2, people), rng.uniform(5, 9, people)))
    steps = np.arange(frames)[:, None, None] * DT
    positions = start + (np.array((0, 1)) + rng.uniform(-0.2, 0.2, (people, 2))) * steps
    positions += rng.normal(0.0, wobble, positions.shape)
    yaw = np.pi / 2 + np.cumsum(rng.normal(0.0, 0.03, frames))
    poses = np.column_stack((np.zeros(frames), np.arange(frames) * DT, yaw))
    return Truth(poses=poses, positions=positions, heights=np.clip(rng.normal(1.7, 0.07, people), 1.45, 1.95))


def pairs(seed: int, frames: int = 8) -> Truth:
    """Walkers more than a metre apart, at constant velocity but for two who walk together exactly alike."""
    rng = np.random.default_rng(seed)
    start = np.array(((-5.0, 8), (-3, 11), (0, 9), (0.5, 9.3), (3, 10), (5, 8)))
    velocity = np.array((0.0, 1.0)) + rng.uniform(-0.2, 0.2, (6, 2))
    velocity[3] = velocity[2]
    positions = start + velocity * np.arange(frames)[:, None, None] * DT
    yaw = np.pi / 2 + np.cumsum(rng.normal(0.0, 0.03, frames))
    poses = np.column_stack((np.zeros(frames), np.arange(frames) * DT, yaw))
    return Truth(poses=poses, positions=positions, heights=np.clip(rng.normal(1.7, 0.07, 6), 1.45, 1.95))


def elsewhere(truth: Truth, shift: Any, turn: float) -> Truth:
    """The same walks in a world that is turned and shifted."""
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    poses = np.column_stack((truth.poses[:, :2] @ rotation + shift, truth.poses[:, 2] + turn))
    return replace(truth, poses=poses, positions=truth.positions @ rotation + shift)


def measured(truth: Truth, covariance: FloatArray, seed: int | None = None, missing: slice = slice(0, 1)) -> Odometry:
    """Odometry of the true motion, exact or with noise of its ``covariance`` [3, 3]; nothing of frame 0 and others."""
    moved = motion_between(truth.poses[:-1], truth.poses[1:])
    if seed is not None:
        moved += np.random.default_rng(seed).multivariate_normal(np.zeros(3), covariance, len(moved))
    motions = np.concatenate((np.full((1, 3), np.nan), moved))
    motions[missing] = np.nan
    return Odometry(motions=motions, covariances=np.tile(covariance, (len(motions), 1, 1)))


def showing(sequence: Sequence, boxes: FloatArray, **changes: Any) -> Sequence:
    """The sequence with other boxes [T, K, 3], NaN where nobody is seen."""
    return replace(sequence, observations=boxes, visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0), **changes)


def see(
    truth: Truth, camera: Camera, pixel_std: float = 0.0, seed: int = 0, odometry: Odometry | None = None
) -> Sequence:
    """The boxes of ``truth``, and its first two frames given."""
    frames, people = truth.positions.shape[:2]
    heights = np.broadcast_to(truth.heights, (frames, people))
    boxes = camera.project(world_to_relative(truth.positions, truth.poses), heights)
    noise = np.random.default_rng(seed).normal(0.0, pixel_std, boxes.shape) * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    everything = Given(poses=truth.poses, positions=np.where(np.isnan(boxes[..., :2]), np.nan, truth.positions))
    return Sequence(
        index=0,
        scene=0,
        observer=0,
        first_frame=0,
        tracks=np.arange(people) + 1,
        observations=boxes + noise,
        visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0),
        given=replace(everything.first_frames(2), odometry=odometry),
    )


def problem_of(sequence: Sequence, camera: Camera, pixel_std: float = 0.0, *, covariances: bool = False) -> Problem:
    return Problem(
        camera=camera,
        dt=DT,
        tracks=sequence.tracks,
        height_mean=1.7,
        height_std=0.07,
        pixel_std=pixel_std,
        covariances=covariances,
    )


def answer(
    solver: Any,
    sequence: Sequence,
    protocol: str = "cold-start",
    camera: Camera | None = None,
    pixel_std: float = 1.0,
    *,
    truth: Truth | None = None,
    covariances: bool = False,
    **facts: Any,
) -> Estimate:
    """A solver's answer to a sequence; ``facts`` are other ones of the problem."""
    problem = problem_of(sequence, camera or CAMERAS[0], pixel_std, covariances=covariances)
    return run_sequence(solver, replace(problem, **facts), sequence, get_protocol(protocol), truth)[0]


def run(
    solver: FrameSolver,
    truth: Truth,
    protocol: str,
    camera: Camera | None = None,
    pixel_std: float = 0.0,
    *,
    covariances: bool = False,
) -> Estimate:
    """A solver's answer to what the camera sees of the truth."""
    camera = camera or CAMERAS[0]
    shown = truth if get_protocol(protocol).needs_truth else None
    sequence = see(truth, camera, pixel_std)
    return answer(solver, sequence, protocol, camera, pixel_std, truth=shown, covariances=covariances)


def assert_close(estimate: Estimate, poses: FloatArray, positions: FloatArray, atol: float) -> None:
    np.testing.assert_allclose(estimate.poses[:, :2], poses[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_angle(estimate.poses[:, 2] - poses[:, 2]), 0.0, atol=atol)
    np.testing.assert_allclose(estimate.positions, positions, atol=atol)
