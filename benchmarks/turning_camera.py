"""How far astray solvers go where a camera turns and few people are in sight, with an uncertain calibration.

    python -m benchmarks.turning_camera [--solver map-causal vb-sf] [--runs 4] [--speed 1] [--dt .4 .1]

A camera goes ahead at 1 m/s, or another ``--speed``, for 16 s. From second 3 to 7 it turns to the left and from 10 to
14 to the right, at a rate in rad/s that stands in a column's head. About four people are in sight, who walk straight
on. Protocol `sequential`: the first two frames of everybody are given. Figures are mean Δx / Δt in m without a cap.
"""

import argparse

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.geometry import BoolArray, FloatArray, relative_to_world, world_to_relative
from vbbench.protocol import arrivals_given, get_protocol
from vbbench.registry import make_solver
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Problem
from vbbench.solving.runner import run_sequence

FRAME_TIMES, RATES, SECONDS = (0.4, 0.1), (0.0, 0.15, 0.3, 0.6), 16.0
CAMERA = PerspectiveCamera(width=1280, height=720, focal=640.0, cx=640.0, cy=360.0, mount_height=1.5)
NEAREST, FARTHEST, TAKEN = 3.0, 16.0, 3
"""How far off people are seen in m; frames after which somebody else comes into sight."""
NOISE, MEMORY, TILT = 0.02, 0.3, 0.004
"""Boxes' noise as a share of their height, for how many seconds it lasts, and how much the camera nods in rad."""
IN_SIGHT = 4


def way(dt: float, rate: float, speed: float) -> FloatArray:
    """Poses [T, 3] of the camera."""
    time = np.arange(0.0, SECONDS, dt)
    turning = rate * (((time >= 3.0) & (time < 7.0)) * 1.0 - ((time >= 10.0) & (time < 14.0)) * 1.0)
    yaw: FloatArray = np.concatenate([[0.0], np.cumsum(turning[1:] * dt)])
    steps = speed * dt * np.column_stack((np.cos(yaw), np.sin(yaw)))
    return np.column_stack((np.cumsum(steps, axis=0) - steps[0], yaw))


def walks(poses: FloatArray, dt: float, rng: np.random.Generator) -> FloatArray:
    """Places [T, K, 2] of people who walk straight on; the next comes into sight whenever fewer than four are."""
    columns: list[FloatArray] = []
    frames = np.arange(len(poses))[:, None]
    for t in range(0, len(poses), TAKEN):
        while not columns or in_sight(np.stack(columns, axis=1)[t], poses[t]).sum() < IN_SIGHT:
            aside = rng.uniform(-0.8, 0.8) * np.arctan(0.5 * CAMERA.width / CAMERA.focal)
            away = rng.uniform(NEAREST + 1.0, FARTHEST - 1.0)
            place = relative_to_world(away * np.array([[np.sin(aside), np.cos(aside)]]), poses[t])[0]
            course, speed = rng.uniform(-np.pi, np.pi), rng.normal(1.2, 0.25)
            columns.append(place + dt * (frames - t) * speed * np.array([np.cos(course), np.sin(course)]))
    return np.stack(columns, axis=1)


def in_sight(places: FloatArray, pose: FloatArray) -> BoolArray:
    """[K] whether people at ``places`` [K, 2] are seen from a ``pose``."""
    relative = world_to_relative(places, pose)
    column = CAMERA.project(relative, np.full(len(places), 1.7))[:, 0]
    away = np.hypot(relative[:, 0], relative[:, 1])
    seen: BoolArray = (column > 20.0) & (column < CAMERA.width - 20.0) & (away > NEAREST) & (away < FARTHEST)
    return seen


def slow_noise(shape: tuple[int, ...], dt: float, rng: np.random.Generator) -> FloatArray:
    """Noise [T, ...] of unit variance that lasts for `MEMORY` seconds."""
    kept = np.exp(-dt / MEMORY)
    noise = rng.normal(size=shape)
    for t in range(1, len(noise)):
        noise[t] = kept * noise[t - 1] + np.sqrt(1.0 - kept * kept) * noise[t]
    return noise


def sequence_of(dt: float, rate: float, speed: float, seed: int) -> tuple[Sequence, Truth]:
    """Boxes of everybody who is in sight in at least three frames."""
    rng, poses = np.random.default_rng(seed), way(dt, rate, speed)
    places = walks(poses, dt, rng)
    seen = np.stack([in_sight(there, pose) for there, pose in zip(places, poses, strict=True)])
    kept = seen.sum(axis=0) >= 3
    places, seen = places[:, kept], seen[:, kept]
    heights = rng.normal(1.72, 0.07, (places.shape[1],))
    boxes = CAMERA.project(world_to_relative(places, poses), np.broadcast_to(heights, seen.shape))
    boxes += NOISE * boxes[..., 2:] * slow_noise(boxes.shape, dt, rng)
    boxes[..., 1] += CAMERA.focal * TILT * slow_noise((len(poses), 1), dt, rng)
    boxes[~seen] = np.nan
    truth = Truth(poses=poses, positions=places, heights=heights)
    sequence = Sequence(
        index=0,
        scene=0,
        observer=len(heights),
        first_frame=0,
        tracks=np.arange(len(heights)),
        observations=boxes,
        visible=np.where(seen, 1.0, np.nan),
        given=arrivals_given(truth, seen),
    )
    return sequence, truth


def errors(solver: str, dt: float, rate: float, speed: float, seed: int) -> FloatArray:
    """Mean Δx of people in sight, and mean Δt, in m."""
    sequence, truth = sequence_of(dt, rate, speed, seed)
    problem = Problem(
        camera=CAMERA,
        dt=dt,
        tracks=sequence.tracks,
        height_mean=1.72,
        height_std=0.09,
        pixel_std=2.0,
        tilt_std=0.03,
        mount_height_std=0.16,
    )
    answer, _ = run_sequence(make_solver(solver), problem, sequence, get_protocol("sequential"), truth)
    off = np.linalg.norm(answer.positions - truth.positions, axis=-1)[sequence.observed]
    return np.array([off.mean(), np.linalg.norm(answer.poses[2:, :2] - truth.poses[2:, :2], axis=-1).mean()])


def main() -> None:
    parser = argparse.ArgumentParser(description="Errors of solvers while the camera turns among few people.")
    parser.add_argument("--solver", nargs="+", default=["vb-cv", "vb-sf", "map-causal", "map-batch", "vb-former"])
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--speed", type=float, default=1.0, help="of the camera, in m/s")
    parser.add_argument("--dt", type=float, nargs="+", default=FRAME_TIMES, help="seconds from frame to frame")
    chosen = parser.parse_args()
    print(f"| frame, s | solver | {' | '.join(f'{rate:g} rad/s' for rate in RATES)} |\n|---|---|{'---|' * len(RATES)}")
    for dt in chosen.dt:
        for solver in chosen.solver:
            cells = []
            for rate in RATES:
                off, away = np.mean(
                    [errors(solver, dt, rate, chosen.speed, seed) for seed in range(chosen.runs)], axis=0
                )
                cells.append(f"{off:.2f} / {away:.2f}")
            print(f"| {dt:g} | `{solver}` | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
