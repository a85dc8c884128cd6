"""How far labelled people on KITTI share the camera's changes of speed, which people in a street do not.

    python -m benchmarks.kitti_labels --kitti ~/kitti

Labels that follow straight lines, as seen from the car, between the frames that somebody labelled brake with the car
until the next such frame; and errors of the car's poses move everybody with it. Either way no box tells of the change,
and no solver can know it.
Over frames w apart a place x_t has the change of velocity (x_{t+w} − 2x_t + x_{t−w})/(w dt); taken along the camera's
heading at t, that of people is compared with the camera's own: the slope of the line through 0, and the correlation.
People who walk as they like have 0, and people who are fixed to the car have 1. Of tier `field` a made vehicle passes
recorded people, which shows what chance does.
"""

import argparse
from pathlib import Path

import numpy as np

from benchmarks.real_camera.cells import KITTI
from benchmarks.real_camera.scenes import Scenes
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.sequence import Sequence, Truth

APART = (1, 2, 5, 10)
"""Frames from velocity to velocity."""

FEWEST = 30
"""Changes that tell."""


def changes(sequence: Sequence, truth: Truth, apart: int, dt: float) -> FloatArray:
    """[2, N] in m/s: the camera's changes of speed along its heading, and those of the people seen meanwhile."""
    before, here, after = slice(None, -2 * apart), slice(apart, -apart), slice(2 * apart, None)
    if len(truth.poses) <= 2 * apart:
        return np.zeros((2, 0))
    places = np.where(sequence.observed[..., None], truth.positions, np.nan)
    both = np.concatenate([truth.poses[:, None, :2], places], axis=1)
    heading = truth.poses[here, 2]
    along = np.column_stack((np.cos(heading), np.sin(heading)))
    change = np.einsum("tkx,tx->tk", both[after] - 2.0 * both[here] + both[before], along) / (apart * dt)
    camera = np.broadcast_to(change[:, :1], change[:, 1:].shape)
    known = ~np.isnan(change[:, 1:])
    return np.stack((camera[known], change[:, 1:][known]))


def shared(dataset: Dataset, apart: int) -> str:
    """The slope, the correlation, and how large the changes are, for a cell of the table."""
    parts = [changes(row, dataset.truth(row), apart, dataset.info.dt) for row in dataset.sequences()]
    camera, people = np.concatenate(parts, axis=1)
    if len(camera) < FEWEST:
        return ""
    slope, alike = camera @ people / (camera @ camera), np.corrcoef(camera, people)[0, 1]
    return f"{slope:.2f} ({alike:.2f}; {camera.std():.2f}, {people.std():.2f})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kitti", type=Path, required=True, help="KITTI's folder")
    parser.add_argument("--cache", type=Path, default=Path("out/real-camera"), help="where datasets are kept")
    asked = parser.parse_args()
    scenes = Scenes(kitti=asked.kitti, cache=asked.cache)
    moving = [(f"{name}, {0.1 * every:.1g} s", scenes.footage(name, every)) for every in (1, 4) for name in KITTI[:2]]
    print("| frames apart | " + " | ".join(map(str, APART)) + " |\n" + "|---" * (1 + len(APART)) + "|")
    for name, dataset in [*moving, ("hotel, field, .4 s", scenes.board("hotel", "field"))]:
        print(f"| {name} | " + " | ".join(shared(dataset, apart) for apart in APART) + " |", flush=True)


if __name__ == "__main__":
    main()
