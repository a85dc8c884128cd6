"""The estimator's speed: frames a second on one core over people K, with known and with uncertain calibration.

    python -m benchmarks.bench_estimator [--people 6 20 40] [--frames 40] [--runs 2] [--against vb-sf]

Simulated people walk around an observer, protocol `sequential`: the first two frames are given. Where the calibration
is uncertain the camera is tilted, and boxes are as noisy as their size. The last column is the time beside that of
another solver in the same run, which says more than frames a second on a busy machine.
"""

import argparse
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np

from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.registry import make_solver
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem, SequenceSolver
from vbbench.solving.runner import given_at

SOLVERS = ("map-causal", "map-batch")
TILT, BOX_STD, PIXELS = 0.03, 0.03, 1.0
"""Of an uncertain calibration in rad and as a share of a box; px of noise of a known one."""


@dataclass(frozen=True)
class Crowd:
    """A problem, its boxes [T, K, 3], and what is given."""

    problem: Problem
    boxes: FloatArray
    given: Given


def crowd(people: int, frames: int = 40, known: bool = False) -> Crowd:
    """People who walk around a walking observer, seen for ``frames`` frames of .4 s."""
    rng = np.random.default_rng(0)
    speeds = rng.normal(0.0, 0.3, (people, 2)) + np.cumsum(rng.normal(0.0, 0.03, (frames, people, 2)), axis=0)
    places = rng.uniform(-8.0, 8.0, (people, 2)) + np.cumsum(speeds, axis=0)
    yaw = np.cumsum(rng.normal(0.0, 0.03, frames))
    poses = np.column_stack((np.cumsum(0.4 * np.column_stack((np.cos(yaw), np.sin(yaw))), axis=0), yaw))
    camera = PanoramaCamera()
    tilted = camera if known else replace(camera, pitch=TILT)
    boxes = tilted.project(world_to_relative(places, poses), np.full((frames, people), 1.7))
    noise = PIXELS if known else BOX_STD * boxes[..., 2:]
    boxes = boxes + rng.normal(0.0, 1.0, boxes.shape) * noise * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    start = np.arange(frames) < 2
    given = Given(
        poses=np.where(start[:, None], poses, np.nan), positions=np.where(start[:, None, None], places, np.nan)
    )
    facts: dict[str, Any] = {} if known else {"box_std": BOX_STD, "tilt_std": TILT}
    problem = Problem(
        camera=camera,
        dt=0.4,
        tracks=np.arange(people),
        height_mean=1.7,
        height_std=0.07,
        pixel_std=PIXELS,
        **facts,
    )
    return Crowd(problem, boxes, given)


def solve(name: str, crowd: Crowd) -> None:
    """Solve the crowd by the solver of that name."""
    solver = make_solver(name)
    if isinstance(solver, SequenceSolver):
        solver.solve(crowd.problem, crowd.boxes, crowd.given)
        return
    solver.start(crowd.problem)
    for t, seen in enumerate(crowd.boxes):
        solver.step(Frame(index=t, observations=seen, given=given_at(crowd.given, t)))


def seconds(name: str, crowd: Crowd, runs: int) -> float:
    """The fewest seconds of the processor of ``runs`` runs, after one that loads what there is to load."""
    spent = []
    for _ in range(1 + runs):
        started = process_time()
        solve(name, crowd)
        spent.append(process_time() - started)
    return min(spent[1:])


def main() -> None:
    parser = argparse.ArgumentParser(description="Frames a second of the estimator.")
    parser.add_argument("--people", type=int, nargs="+", default=[6, 20, 40])
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--against", default="vb-sf")
    chosen = parser.parse_args()
    print(f"| calibration | K | solver | frames/s | time beside {chosen.against} |\n|---|---:|---|---:|---:|")
    for known in (True, False):
        for people in chosen.people:
            case = crowd(people, chosen.frames, known)
            yardstick = seconds(chosen.against, case, chosen.runs)
            found = {chosen.against: yardstick} | {name: seconds(name, case, chosen.runs) for name in SOLVERS}
            for name, spent in found.items():
                kind = "known" if known else "uncertain"
                print(f"| {kind} | {people} | {name} | {chosen.frames / spent:,.0f} | {spent / yardstick:.2f} |")


if __name__ == "__main__":
    main()
