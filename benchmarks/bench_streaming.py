"""What a frame costs a solver that runs for hours: people come and go, and columns stand for one after the other.

``python -m benchmarks.bench_streaming [--solver map-causal] [--frames 20000] [--people 50] [--columns 128]`` prints
percentiles of the processor's time of ``step`` in ms (other programs do not count), covariances included, and the most
memory in use so far, for each tenth of the frames.
"""

import argparse
import resource
from collections.abc import Iterator
from time import thread_time
from typing import Any

import numpy as np

from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.registry import make_solver
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem

DT, STAY, REACH, PACE = 0.1, 30.0, 12.0, 1.3
"""Seconds per frame, mean seconds that somebody stays in sight, m around the observer, and m/s."""


class Street:
    """An observer who walks among ``people``, each of whom leaves at some time, somebody else coming in their place.

    Who comes gets the column that was left longest ago, and ``arrived`` names it.
    """

    def __init__(self, people: int, columns: int) -> None:
        self._rng, self.camera = np.random.default_rng(0), PanoramaCamera()
        self._places, self._velocities = np.full((2, columns, 2), np.nan)
        self._heights, self._left = np.full(columns, np.nan), np.full(columns, -np.inf)
        self._frame, self._pose = 0, np.zeros(3)
        self.arrived: IntArray = np.arange(people)
        self._enter()

    def step(self) -> FloatArray:
        """Boxes [K, 3] of the next frame."""
        self._frame += 1
        self._pose = self._pose + DT * np.array((PACE, 0.0, 0.1 * np.sin(0.01 * self._frame)))
        self._places += DT * self._velocities + self._rng.normal(0.0, 0.003, self._places.shape)
        here = ~np.isnan(self._heights)
        gone = np.flatnonzero(here & (self._rng.random(len(here)) < DT / STAY))
        self._places[gone], self._heights[gone], self._left[gone] = np.nan, np.nan, self._frame
        free = np.where(here, np.inf, self._left)
        self.arrived = np.argsort(free, kind="stable")[: len(gone)]
        self._enter()
        boxes = self.camera.project(world_to_relative(self._places[None], self._pose[None])[0], self._heights)
        noise: FloatArray = self._rng.normal(0.0, 1.0, boxes.shape)
        return boxes + noise

    def _enter(self) -> None:
        count = len(self.arrived)
        self._places[self.arrived] = self._pose[:2] + self._rng.uniform(-REACH, REACH, (count, 2))
        self._velocities[self.arrived] = self._rng.normal((PACE, 0.0), 0.5, (count, 2))
        self._heights[self.arrived] = self._rng.normal(1.7, 0.07, count)
        self._left[self.arrived] = np.inf


def times(solver: Any, people: int, columns: int, frames: int) -> Iterator[tuple[float, FloatArray]]:
    """Seconds of each step, and the pose it answers."""
    street, nothing = Street(people, columns), np.full((3, columns, 2), np.nan)
    tracks = np.arange(columns)
    problem = Problem(
        camera=street.camera,
        dt=DT,
        tracks=tracks,
        height_mean=1.7,
        height_std=0.07,
        pixel_std=1.0,
        covariances=True,
    )
    solver.start(problem)
    for t in range(frames):
        boxes, poses = street.step(), np.full((3, 3), np.nan)
        if t < 3:
            poses[2 - t] = 0.0
        started = thread_time()
        if t > 0 and len(street.arrived):
            solver.forget(street.arrived)
        answer = solver.step(Frame(index=t, observations=boxes, given=Given(poses=poses, positions=nothing)))
        yield thread_time() - started, answer.pose


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solver", default="map-causal")
    parser.add_argument("--frames", type=int, default=20000)
    parser.add_argument("--people", type=int, default=50)
    parser.add_argument("--columns", type=int, default=128)
    options = parser.parse_args()
    part: list[float] = []
    print("| frames | median ms | 99 % | worst | memory, MB |")
    print("|---|---|---|---|---|")
    for t, (seconds, _) in enumerate(
        times(make_solver(options.solver), options.people, options.columns, options.frames)
    ):
        part.append(1e3 * seconds)
        if len(part) == options.frames // 10:
            median, most = np.percentile(part, (50, 99))
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(f"| to {t + 1} | {median:.2f} | {most:.2f} | {max(part):.2f} | {memory:.0f} |", flush=True)
            part.clear()


if __name__ == "__main__":
    main()
