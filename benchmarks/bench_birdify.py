"""`vbbench birdify` on a long recording: processor seconds of the whole command, first and best of three more.

Run from the repository: ``python -m benchmarks.bench_birdify [--frames 1000] [--people 12]``. Made-up people cross the
view of somebody who walks, others every few seconds, with boxes as noisy as their size and a camera that looks a little
higher than its file says. Processor time, user and system, is what other work on the machine disturbs least; the last
column, how many times as long as with the solver ``cv`` (whatever is read, written and drawn, and hardly any solving),
depends least on the machine.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.geometry import FloatArray, world_to_relative

DT, STAY = 0.1, (40, 60)
"""Seconds per frame, and for how many frames a person is seen."""

YARDSTICK, SOLVERS, REPEATS = "cv", ("map-causal",), 3

TILT, BOX_STD = 0.02, 0.03
"""In rad, and as a share of a box."""

CAMERA = PerspectiveCamera(width=1280, height=720, focal=900.0, mount_height=1.6)
CAMERA_FILE = f"""\
width = {CAMERA.width}
height = {CAMERA.height}
focal = {CAMERA.focal}
mount_height = {CAMERA.mount_height}
dt = {DT}
"""


def crowd(frames: int, people: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Rows [N, 2] of frame and id, and boxes [N, 4] of left, top, width and height in px.

    At any time ``people`` are there; who has been seen for a while is followed by somebody new.
    """
    rng = np.random.default_rng(seed)
    yaw = np.cumsum(rng.normal(0.0, 0.004, frames))
    poses = np.column_stack((np.cumsum(1.2 * DT * np.column_stack((np.cos(yaw), np.sin(yaw))), axis=0), yaw))
    keys, boxes = [], []
    for place in range(people):
        end = int(rng.integers(1, STAY[1]))
        begin, number = 0, place
        while begin < frames:
            here = np.arange(begin, min(end, frames))
            keys.append(np.column_stack((here, np.full(len(here), number))))
            boxes.append(_seen(poses[here], rng))
            begin, end, number = end, end + int(rng.integers(*STAY)), number + people
    return np.concatenate(keys), np.concatenate(boxes)


def _seen(poses: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Boxes [n, 4] of one person, who stays about the middle of the view, from an observer's ``poses`` [n, 3]."""
    sin, cos = np.sin(poses[0, 2]), np.cos(poses[0, 2])
    across, ahead = rng.uniform(-3.0, 3.0), rng.uniform(8.0, 14.0)
    start = poses[0, :2] + (ahead * cos - across * sin, ahead * sin + across * cos)
    step = DT * (1.2 * np.array((cos, sin)) * rng.uniform(0.3, 1.2) + rng.normal(0.0, 0.2, 2))
    walked = start + np.cumsum(step + np.cumsum(rng.normal(0.0, 0.002, (len(poses), 2)), axis=0), axis=0)
    height = np.full((len(poses), 1), rng.normal(1.72, 0.08))
    box = replace(CAMERA, pitch=TILT).project(world_to_relative(walked[:, None], poses), height)[:, 0]
    box = box + rng.normal(0.0, BOX_STD, box.shape) * box[:, 2:] * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    u, v, size = box.T
    return np.column_stack((u - 0.2 * size, v - 0.5 * size, 0.4 * size, size))


def write_recording(folder: Path, frames: int, people: int) -> None:
    """``boxes.csv`` and ``camera.toml``."""
    keys, boxes = crowd(frames, people)
    good = np.isfinite(boxes).all(axis=1)
    keys, boxes = keys[good], boxes[good]
    rows = np.column_stack((keys, boxes))
    names = "frame,id,left,top,width,height"
    np.savetxt(folder / "boxes.csv", rows, ("%d", "%d", *["%.2f"] * 4), ",", header=names, comments="")
    (folder / "camera.toml").write_text(CAMERA_FILE)


def processor_seconds(folder: Path, solver: str) -> float:
    """Of one command, user and system."""
    command = ["birdify", "boxes.csv", "--camera", "camera.toml", "--out", "map", "--overwrite"]
    before = os.times()
    subprocess.run(
        [sys.executable, "-W", "ignore", "-m", "vbbench", *command, "--solver", solver],
        cwd=folder,
        check=True,
        stdout=subprocess.DEVNULL,
    )
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--people", type=int, default=12)
    parser.add_argument("--solver", nargs="+", default=SOLVERS)
    parser.add_argument("--runs", type=int, default=REPEATS, help="of each solver")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_recording(folder, options.frames, options.people)
        print(f"{'':12s}{'first':>10s}{'best':>10s}   times as long as {YARDSTICK}")
        yardstick = np.nan
        for solver in (YARDSTICK, *options.solver):
            first = processor_seconds(folder, solver)
            best = min(processor_seconds(folder, solver) for _ in range(options.runs))
            yardstick = best if solver == YARDSTICK else yardstick
            print(f"{solver:12s}{first:8.2f} s{best:8.2f} s{best / yardstick:8.1f}")


if __name__ == "__main__":
    main()
