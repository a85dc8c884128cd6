"""vb-sf: frames a second on one core by size of crowd, and beside scipy.optimize on the same energies.

The plain implementation writes the two energies of `docs/reference-solver.md` down and minimises them in general
form: the pose with the people's places by BFGS, then the places given the pose by BFGS from the places so found.
"""

import argparse
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import minimize

from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, relative_to_world, world_to_relative, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import Frame, FrameEstimate, FrameSolver, Problem
from vbbench_baselines._core import link, minimise
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import Answer, Task

DT, FRAMES, DENSITY = 0.4, 12, 0.17  # seconds, frames, people a square metre as in Students
SIZES = (5, 10, 20, 43, 70, 100, 200, 400, 800)
GRADIENT = 1e-6  # at which the plain implementation ends
CASES: tuple[tuple[float, dict[str, Any]], ...] = ((0.0, {}), (1.0, {}), (1.0, {"calibrate": False}))


def minimised(energy: Callable[[FloatArray], float], start: FloatArray) -> FloatArray:
    """Where BFGS ends."""
    found: FloatArray = minimize(energy, start.ravel(), method="BFGS", options={"gtol": GRADIENT}).x
    return found


class Recorder(SocialForceBirdifier):
    """vb-sf that keeps what it last minimised."""

    def _minimise(self, task: Task) -> Answer:
        self.task = task
        return super()._minimise(task)


class Plain:
    """The energies of one frame, over v = (pose, ξ), ξ [K, 2] whitened deviations of the measurements."""

    def __init__(self, solver: Recorder) -> None:
        factors = solver.task.factors
        rr, rf, ff = factors.covariance.T
        noise = np.stack((np.stack((rr, rf), -1), np.stack((rf, ff), -1)), -2)
        self.root = np.linalg.cholesky(noise + 1e-12 * np.eye(2))
        self.solver, self.factors = solver, factors
        alone = minimise(factors, solver.task.pose, solver.softness, solver.iterations, solver.tolerance)[1]
        self.i, self.j = link(alone, solver.reach, solver.neighbours).T

    def places(self, v: FloatArray) -> FloatArray:
        """People's places [K, 2] in m."""
        return relative_to_world(self.factors.relative + (self.root @ v[3:].reshape(-1, 2, 1))[..., 0], v[:3])

    def own(self, v: FloatArray) -> float:
        """E_c: everybody's own terms and the observer's."""
        f = self.factors
        strays = np.vstack(((self.places(v) - f.expected) / f.std[:, None], (v[:2] - f.walk[:2]) / f.walk_std))
        norms = np.sqrt(np.sum(strays**2, axis=1) + self.solver.softness**2)
        return float(np.sum(norms) + 0.5 * v[3:] @ v[3:])

    def crowd(self, v: FloatArray) -> float:
        """E_p: the same, and the pairwise potential."""
        x, sigma = self.places(v), self.solver.sigma
        distance = np.linalg.norm(x[self.i] - x[self.j], axis=1)
        potential = distance / sigma**2 * np.exp(-0.5 * (distance / sigma) ** 2)
        return self.own(v) + self.solver.strength / self.solver.acceleration_std * float(np.sum(potential))

    def answer(self) -> FrameEstimate:
        """Pose by E_c, then places by E_p."""
        people = len(self.factors.std)
        v = minimised(self.own, np.append(self.factors.walk, np.zeros(2 * people)))
        if self.factors.covariance.any():
            pose = v[:3].copy()
            v[3:] = minimised(lambda xi: self.crowd(np.append(pose, xi)), v[3:])
        return FrameEstimate(pose=v[:3], positions=self.places(v))


def crowd(people: int, pixel_std: float) -> tuple[Problem, list[Frame]]:
    """A crowd as dense as Students around the observer, and its frames from t = 2 as one-step shows them."""
    rng, camera = np.random.default_rng(people), PanoramaCamera()
    velocity = rng.normal(0.0, 0.05, (FRAMES, people, 2)).cumsum(axis=0) + rng.normal(0.0, 0.7, (people, 2))
    extent = 0.5 * np.sqrt(people / DENSITY)
    positions = rng.uniform(-extent, extent, (people, 2)) + velocity.cumsum(axis=0) * DT
    poses = np.cumsum(rng.normal((0.4, 0.0, 0.0), (0.02, 0.02, 0.05), (FRAMES, 3)), axis=0)
    heights = np.broadcast_to(rng.normal(1.7, 0.07, people), (FRAMES, people))
    boxes = camera.project(world_to_relative(positions, poses), heights)
    boxes += pixel_std * rng.normal(0.0, 1.0, boxes.shape) * (1.0, 0.7, 1.4)
    nothing = [np.full((1, *rows.shape[1:]), np.nan) for rows in (poses, positions)]
    shown = [np.concatenate((rows, none)) for rows, none in zip((poses, positions), nothing, strict=True)]
    frames = [
        Frame(
            index=t,
            observations=boxes[t],
            given=Given(poses=shown[0][[t - 2, t - 1, FRAMES]], positions=shown[1][[t - 2, t - 1, FRAMES]]),
        )
        for t in range(2, FRAMES)
    ]
    facts: dict[str, Any] = {"height_mean": 1.7, "height_std": 0.07, "pixel_std": pixel_std}
    return Problem(camera=camera, dt=DT, tracks=np.arange(people), **facts), frames


def seconds_per_frame(solver: FrameSolver, problem: Problem, frames: list[Frame], repeats: int = 20) -> float:
    """The least of ``repeats`` runs."""
    best = np.inf
    for _ in range(repeats):
        solver.start(problem)
        started = perf_counter()
        for frame in frames:
            solver.step(frame)
        best = min(best, (perf_counter() - started) / len(frames))
    return best


def compare(people: int, pixel_std: float, **parameters: Any) -> tuple[float, float]:
    """Seconds per frame of the plain implementation, and the greatest gap in m or rad."""
    solver, (problem, frames) = Recorder(**parameters), crowd(people, pixel_std)
    solver.start(problem)
    spent = gap = 0.0
    for frame in frames:
        fast = solver.step(frame)
        started = perf_counter()
        slow = Plain(solver).answer()
        spent += perf_counter() - started
        turn = wrap_angle(fast.pose[2:] - slow.pose[2:])
        gaps = (fast.pose[:2] - slow.pose[:2], turn, (fast.positions - slow.positions).ravel())
        gap = max(gap, np.abs(np.concatenate(gaps)).max())
    return spent / len(frames), gap


def main() -> None:
    parser = argparse.ArgumentParser(description="Frames a second of vb-sf.")
    parser.add_argument("--people", type=int, nargs="+", default=SIZES)
    parser.add_argument("--compared", type=int, default=43, help="people beside scipy.optimize")
    asked = parser.parse_args()
    print("people   ideal frames/s   noisy   heights unknown")
    for people in asked.people:
        rates = [1.0 / seconds_per_frame(SocialForceBirdifier(**how), *crowd(people, px)) for px, how in CASES]
        print(f"{people:6d} {rates[0]:16,.0f} {rates[1]:7,.0f} {rates[2]:17,.0f}")
    for px, how in CASES:
        fast = seconds_per_frame(SocialForceBirdifier(**how), *crowd(asked.compared, px))
        plain, gap = compare(asked.compared, px, **how)
        print(f"{asked.compared} people, {px:g} px, {how}: {1 / fast:,.0f} frames/s;")
        print(f"    scipy.optimize {plain:.3g} s per frame, ratio {plain / fast:,.0f}x, gap {gap:.1e} m, rad")
        assert gap < 1e-4, "the two implementations disagree"


if __name__ == "__main__":
    main()
