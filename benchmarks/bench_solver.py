"""vb-cv, one-step, 43 people: frames a second on one core, beside the same energy in plain NumPy and scipy.optimize."""

from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, relative_to_world, world_to_relative, wrap_angle
from vbbench.protocol import START_FRAMES
from vbbench.sequence import Given
from vbbench.solver import Estimate, Frame, FrameEstimate, FrameSolver, Problem
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

PEOPLE, FRAMES, DT = 43, 46, 0.4  # the mean sequence of Students


class PlainBirdifier:
    """One-step vb-cv as one would write it down: whitened residuals and a general least-squares solver."""

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self.problem = problem
        self.mean = np.full(len(problem.tracks), problem.height_mean)
        self.variance = np.full(len(problem.tracks), problem.height_std**2)
        self.previous: FloatArray | None = None

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        poses, positions, camera = frame.given.poses, frame.given.positions, self.problem.camera
        sigma, motion = self.problem.pixel_std, 0.6 * DT**2
        if self.previous is not None:
            self._learn(world_to_relative(positions[1], poses[1]), self.previous)
        self.previous = frame.observations
        if not np.isnan(poses[2, 0]):
            return FrameEstimate(pose=poses[2], positions=positions[2])
        rays, sideways = self._rays(frame.observations)
        along = self.variance + (self.mean * np.sqrt(2.0) * sigma / frame.observations[:, 2]) ** 2
        noise = along[:, None, None] * rays[:, :, None] * rays[:, None]
        noise += (self.mean**2)[:, None, None] * sideways[:, :, None] * sideways[:, None]
        relative = camera.unproject(frame.observations, self.mean)
        expected, walk = 2.0 * positions[1] - positions[0], 2.0 * poses[1] - poses[0]
        weight = np.linalg.inv(noise + motion**2 * np.eye(2))
        root = np.linalg.cholesky(weight).transpose(0, 2, 1)

        def residuals(pose: FloatArray) -> FloatArray:
            people = root @ (relative - world_to_relative(expected, pose))[..., None]
            return np.append(people.ravel(), (pose[:2] - walk[:2]) / motion)

        start = np.append(walk[:2], poses[1, 2])
        pose = least_squares(residuals, start, method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14).x
        prior = world_to_relative(expected, pose)
        moved = prior + motion**2 * (weight @ (relative - prior)[..., None])[..., 0]
        return FrameEstimate(pose=pose, positions=relative_to_world(moved, pose))

    def _rays(self, boxes: FloatArray) -> tuple[FloatArray, FloatArray]:
        unit = np.ones(len(boxes))
        rays = self.problem.camera.unproject(boxes, unit)
        shifted = self.problem.camera.unproject(boxes + np.array((1.0, 0.0, 0.0)), unit)
        return rays, self.problem.pixel_std * (shifted - rays)

    def _learn(self, relative: FloatArray, boxes: FloatArray) -> None:
        rays, sideways = self._rays(boxes)
        squared = np.sum(rays**2, axis=1)
        height = np.sum(relative * rays, axis=1) / squared
        slip = np.sum(rays * sideways, axis=1) / squared
        noise = height**2 * (2.0 * (self.problem.pixel_std / boxes[:, 2]) ** 2 + slip**2) + 1e-10
        gain = self.variance / (self.variance + noise)
        self.mean = np.clip(self.mean + gain * (height - self.mean), 1.4, 2.0)
        self.variance = self.variance * (1.0 - gain)


def crowd() -> tuple[Problem, list[Frame]]:
    """A crowd as dense as Students seen with 1 px of noise, and its frames as one-step shows them."""
    rng, camera = np.random.default_rng(0), PanoramaCamera()
    velocity = rng.normal(0.0, 0.05, (FRAMES, PEOPLE, 2)).cumsum(axis=0) + rng.normal(0.0, 0.7, (PEOPLE, 2))
    positions = rng.uniform(-8, 8, (PEOPLE, 2)) + velocity.cumsum(axis=0) * DT
    poses = np.cumsum(rng.normal((0.4, 0.0, 0.0), (0.02, 0.02, 0.05), (FRAMES, 3)), axis=0)
    heights = np.broadcast_to(rng.normal(1.7, 0.07, PEOPLE), (FRAMES, PEOPLE))
    boxes = camera.project(world_to_relative(positions, poses), heights)
    boxes = np.maximum(boxes + rng.normal(0.0, 1.0, boxes.shape) * (1.0, 0.7, 1.4), (-np.inf, -np.inf, 1.0))
    known = [np.concatenate((rows, np.full((1, *rows.shape[1:]), np.nan))) for rows in (poses, positions)]
    frames = []
    for t in range(FRAMES):
        shown = [past if past >= 0 else FRAMES for past in (t - 2, t - 1)] + [t if t < START_FRAMES else FRAMES]
        given = Given(poses=known[0][shown], positions=known[1][shown])
        frames.append(Frame(index=t, observations=boxes[t], given=given))
    facts: dict[str, Any] = {"height_mean": 1.7, "height_std": 0.07, "pixel_std": 1.0}
    return Problem(camera=camera, dt=DT, tracks=np.arange(PEOPLE), **facts), frames


def timed(solver: FrameSolver, problem: Problem, frames: list[Frame], repeats: int) -> tuple[Estimate, float]:
    """Answers, and the least seconds per frame of ``repeats`` runs."""
    best = np.inf
    for _ in range(repeats):
        started = perf_counter()
        solver.start(problem)
        answers = [solver.step(frame) for frame in frames]
        best = min(best, (perf_counter() - started) / len(frames))
    return Estimate.of_frames(answers), best


def main() -> None:
    problem, frames = crowd()
    fast, seconds = timed(ConstantVelocityBirdifier(), problem, frames, 50)
    slow, plain = timed(PlainBirdifier(), problem, frames, 3)
    turn = wrap_angle(fast.poses[:, 2] - slow.poses[:, 2])
    gap = max(np.abs(fast.poses - slow.poses)[:, :2].max(), np.abs(turn).max())
    gap = max(gap, np.abs(fast.positions - slow.positions).max())
    print(f"vb-cv, one-step, {PEOPLE} people: {1 / seconds:,.0f} frames/s, {seconds * 1e6:.0f} µs per frame")
    print(
        f"NumPy and scipy.optimize:       {1 / plain:,.0f} frames/s; ratio {plain / seconds:.0f}x; gap {gap:.1e} m, rad"
    )
    assert gap < 1e-6, "the two implementations disagree"


if __name__ == "__main__":
    main()
