"""map-causal and map-batch: frames a second on one core over frames T and people K, with noise of 1 px.

Time should grow as K·T: the last column is microseconds for a frame and a person. Seconds are the processor's, of one
thread.
"""

from time import process_time
from typing import Any

import numpy as np

from benchmarks.bench_real_camera import frame_by_frame
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.sequence import Given
from vbbench.solver import Estimate, Problem
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal

SIZES = [(20, 6), (40, 6), (20, 40), (40, 40), (160, 20), (320, 20)]


def crowd(frames: int, people: int) -> tuple[Problem, Any, Given]:
    """Boxes [T, K, 3] of people who wander about the observer, and the first two frames given."""
    rng = np.random.default_rng(0)
    places = rng.uniform(-8, 8, (people, 2)) + np.cumsum(rng.normal(0.0, 0.05, (frames, people, 2)), axis=0)
    yaw = np.cumsum(rng.normal(0.0, 0.03, frames))
    poses = np.column_stack((np.cumsum(rng.normal(0.02, 0.02, (frames, 2)), axis=0), yaw))
    boxes = PanoramaCamera().project(world_to_relative(places, poses), np.full((frames, people), 1.7))
    boxes += rng.normal(0.0, 1.0, boxes.shape) * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    start = np.arange(frames) < 2
    given = Given(
        poses=np.where(start[:, None], poses, np.nan), positions=np.where(start[:, None, None], places, np.nan)
    )
    facts: dict[str, Any] = {"height_mean": 1.7, "height_std": 0.07, "pixel_std": 1.0}
    return Problem(camera=PanoramaCamera(), dt=0.4, tracks=np.arange(people), **facts), boxes, given


def causal(problem: Problem, boxes: FloatArray, given: Given) -> Estimate:
    """The answer of map-causal."""
    return frame_by_frame(MapCausal, problem, boxes, given)


def timed(solve: Any, *arguments: Any) -> tuple[Estimate, float]:
    """The answer, and the seconds it took once everything is compiled."""
    solve(*arguments)
    started = process_time()
    return solve(*arguments), process_time() - started


def main() -> None:
    for name, solve in (("map-causal", causal), ("map-batch", lambda *a: MapBatch().solve(*a))):
        print(f"{name:10s}    T    K   frames/s   µs per frame and person")
        for frames, people in SIZES:
            _, seconds = timed(solve, *crowd(frames, people))
            print(f"{'':10s} {frames:4d} {people:4d} {frames / seconds:10.0f} {1e6 * seconds / frames / people:10.1f}")


if __name__ == "__main__":
    main()
