"""map-causal and map-batch on a camera known only roughly: frames a second on one core over people K, beside vb-sf.

Synthetic people walk about an observer whose camera is tilted by more than it says, with boxes as noisy as their size.
The last column is how many times as long as vb-sf a solver takes; it says more than frames a second on a busy machine.
"""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.sequence import Given
from vbbench.solver import Estimate, Frame, FrameSolver, Problem
from vbbench.solving.runner import given_at
from vbbench_baselines.joint_map import MapBatch
from vbbench_baselines.joint_map import MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier

FRAMES, PEOPLE, REPEATS = 40, (6, 20, 40), 2

TILT, BOX_STD = 0.03, 0.03
"""In rad, and as a share of a box."""


def crowd(people: int) -> tuple[Problem, FloatArray, Given]:
    """Boxes [T, K, 3] of people who walk about a walking observer, and the first two frames given."""
    rng = np.random.default_rng(0)
    speeds = rng.normal(0.0, 0.3, (people, 2)) + np.cumsum(rng.normal(0.0, 0.03, (FRAMES, people, 2)), axis=0)
    places = rng.uniform(-8.0, 8.0, (people, 2)) + np.cumsum(speeds, axis=0)
    yaw = np.cumsum(rng.normal(0.0, 0.03, FRAMES))
    poses = np.column_stack((np.cumsum(0.4 * np.column_stack((np.cos(yaw), np.sin(yaw))), axis=0), yaw))
    camera = PanoramaCamera()
    boxes = replace(camera, pitch=TILT).project(world_to_relative(places, poses), np.full((FRAMES, people), 1.7))
    boxes = boxes + rng.normal(0.0, BOX_STD, boxes.shape) * boxes[..., 2:] * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    start = np.arange(FRAMES) < 2
    given = Given(
        poses=np.where(start[:, None], poses, np.nan), positions=np.where(start[:, None, None], places, np.nan)
    )
    facts: dict[str, Any] = {"height_mean": 1.7, "height_std": 0.07, "pixel_std": 1.0}
    problem = Problem(camera=camera, dt=0.4, tracks=np.arange(people), box_std=BOX_STD, tilt_std=TILT, **facts)
    return problem, boxes, given


def frame_by_frame(make: Callable[[], FrameSolver], problem: Problem, boxes: FloatArray, given: Given) -> Estimate:
    """The answers of a solver that sees one frame after the other."""
    solver, answers = make(), []
    solver.start(problem)
    for t, seen in enumerate(boxes):
        answers.append(solver.step(Frame(index=t, observations=seen, given=given_at(given, t))))
    return Estimate.of_frames(answers)


def timed(solve: Callable[..., Estimate], *arguments: Any) -> float:
    """The fewest seconds that it takes once everything is compiled."""
    seconds = []
    for _ in range(1 + REPEATS):
        started = perf_counter()
        solve(*arguments)
        seconds.append(perf_counter() - started)
    return min(seconds[1:])


def whole(problem: Problem, boxes: FloatArray, given: Given) -> Estimate:
    """The answer of map-batch."""
    return MapBatch().solve(problem, boxes, given)


def main() -> None:
    print(f"{'':10s}    K   frames/s   times as long as vb-sf")
    for people in PEOPLE:
        problem, boxes, given = crowd(people)
        least = timed(frame_by_frame, SocialForceBirdifier, problem, boxes, given)
        print(f"{'vb-sf':10s} {people:4d} {FRAMES / least:10.0f}")
        for name, arguments in (("map-causal", (frame_by_frame, MapCausal)), ("map-batch", (whole,))):
            seconds = timed(*arguments, problem, boxes, given)
            print(f"{name:10s} {people:4d} {FRAMES / seconds:10.0f} {seconds / least:10.1f}")


if __name__ == "__main__":
    main()
