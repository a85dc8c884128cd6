"""A session over many frames of a crowd that comes and goes: milliseconds a step and memory, by blocks of frames.

Whoever is farther than 15 m is replaced by a new person with a new id; who is nearer than 1 m has no box. Steps and
memory should not grow: the last line compares the last block with the first, by time of the processor, which does not
count what else the machine does. A solver that does nothing shows what the session itself costs.

    python -m benchmarks.bench_session [--people 50] [--frames 20000] [--no-odometry] [--uncertain]
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from resource import getpagesize
from time import perf_counter, thread_time
from typing import NamedTuple

import numpy as np

from vbbench import Frame, FrameEstimate, Problem, Session
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, IntArray, world_to_relative

BLOCK = 2000
DT = 0.1
NEAREST, FARTHEST = 1.0, 15.0
"""In m: who is in between has a box."""
ODOMETRY = np.diag([0.01, 0.01, 0.002]) ** 2
PIXELS = 1.0
TILT = 0.03


class Silent:
    """A solver that stays at the origin and puts everybody there."""

    def start(self, problem: Problem) -> None:
        """Nothing to remember."""

    def step(self, frame: Frame) -> FrameEstimate:
        """Everybody is where the observer is."""
        people = len(frame.observations)
        sigma, sigmas = np.eye(3), np.zeros((people, 2, 2))
        places = np.zeros((people, 2))
        return FrameEstimate(
            pose=sigma[0], positions=places, pose_covariance=sigma, position_covariances=sigmas, heights=places[:, 0]
        )

    def forget(self, columns: IntArray) -> None:
        """Nothing to forget."""


class Seen(NamedTuple):
    """A frame: the pose [3], its measured motion [3], and boxes [3] and places [2] of people by id."""

    pose: FloatArray
    motion: FloatArray
    boxes: dict[int, FloatArray]
    places: dict[int, FloatArray]


def crowd(people: int, frames: int, seed: int = 0) -> Iterator[Seen]:
    """People who walk straight on, seen from an observer who walks in a circle of 20 m."""
    rng, camera = np.random.default_rng(seed), PanoramaCamera()
    ids, places = np.arange(people), rng.uniform(-8.0, 8.0, (people, 2))
    velocities, heights = rng.normal(0.0, 0.8, (people, 2)), rng.normal(1.72, 0.07, people)
    turn = 1.0 / 20.0 * DT
    for frame in range(frames):
        yaw = turn * frame
        pose = np.array([20.0 * np.sin(yaw), 20.0 - 20.0 * np.cos(yaw), yaw])
        places += DT * velocities + rng.normal(0.0, 0.005, places.shape)
        gone = np.flatnonzero(np.linalg.norm(places - pose[:2], axis=1) > FARTHEST)
        angles = rng.uniform(0.0, 2.0 * np.pi, len(gone))
        ids[gone] = ids.max() + 1 + np.arange(len(gone))
        places[gone] = pose[:2] + (FARTHEST - 3.0) * np.column_stack([np.cos(angles), np.sin(angles)])
        velocities[gone], heights[gone] = rng.normal(0.0, 0.8, (len(gone), 2)), rng.normal(1.72, 0.07, len(gone))
        boxes = camera.project(world_to_relative(places, pose), heights)
        boxes += rng.normal(0.0, PIXELS, boxes.shape) * (1.0, np.sqrt(0.5), np.sqrt(2.0))
        motion = rng.multivariate_normal([20.0 * np.sin(turn), 20.0 * (1.0 - np.cos(turn)), turn], ODOMETRY)
        seen = np.linalg.norm(places - pose[:2], axis=1) > NEAREST
        by_id = (dict(zip(ids[seen].tolist(), values[seen], strict=True)) for values in (boxes, places))
        yield Seen(pose, motion, *by_id)


def memory() -> float:
    """Resident memory of this process in MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * getpagesize() / 1e6


def run(session: Session, people: int, frames: int, odometry: bool) -> None:
    """Step through the crowd, and print a line for each block of frames."""
    times, errors, blocks = np.zeros((frames, 2)), np.zeros(frames), []
    print("    frames        p50       p99       max ms a step     p50       p99 ms of processor   memory MB   Δt m")
    for frame, seen in enumerate(crowd(people, frames)):
        measured = (seen.motion, ODOMETRY) if odometry and frame else None
        started = np.array([perf_counter(), thread_time()])
        answer = session.step_observations(seen.boxes, measured)
        times[frame] = 1e3 * (np.array([perf_counter(), thread_time()]) - started)
        errors[frame] = np.linalg.norm(answer.pose[:2] - seen.pose[:2])
        if (frame + 1) % BLOCK == 0 or frame + 1 == frames:
            block = slice(frame // BLOCK * BLOCK, frame + 1)
            wall, processor = np.percentile(times[block], (50, 99, 100), axis=0).T
            blocks.append((*processor[:2], memory()))
            print(f"{block.start:6d}–{frame:<6d}", end="")
            print("".join(f"{value:10.2f}" for value in (*wall, *processor[:2])), end="")
            print(f"{blocks[-1][2]:22.1f}{errors[block].mean():10.2f}")
    ratios = np.array(blocks[-1]) / np.array(blocks[0])
    print(f"last block / first block: processor p50 {ratios[0]:.2f}, p99 {ratios[1]:.2f}, memory {ratios[2]:.3f}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Steps of a session: time and memory over many frames.")
    parser.add_argument("--solver", default="map-causal")
    parser.add_argument("--people", type=int, default=50)
    parser.add_argument("--frames", type=int, default=10 * BLOCK)
    parser.add_argument("--no-odometry", dest="odometry", action="store_false")
    parser.add_argument("--uncertain", action="store_true", help=f"the camera may be tilted by {TILT} rad")
    chosen = parser.parse_args()
    for name, solver, frames in (
        (chosen.solver, chosen.solver, chosen.frames),
        ("nothing", Silent(), min(BLOCK, chosen.frames)),
    ):
        print(f"{name}, {chosen.people} people at once")
        tilt = TILT if chosen.uncertain else 0.0
        session = Session(solver, PanoramaCamera(), DT, pixel_std=PIXELS, tilt_std=tilt)
        run(session, chosen.people, frames, chosen.odometry)


if __name__ == "__main__":
    main()
