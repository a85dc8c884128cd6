"""A crowd in memory that leaves the observer alone for a while: gaps, few people, arrivals one at a time."""

import numpy as np

from tests.lib.made_sequence import sequence_of
from tests.lib.solver_runs import DT
from vbbench.camera import Camera, PanoramaCamera
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench.sequence import Sequence, Truth

GAP = 27
"""Frames without anybody, as in the recording zara01."""


def stroll(frames: int, rng: np.random.Generator, speed: float = 1.3) -> FloatArray:
    """Poses [T, 3] of an observer who walks along a bending path and looks where it goes, or stands (``speed`` 0)."""
    yaw = np.cumsum(rng.normal(0.0, 0.06, frames))
    steps = speed * DT * np.column_stack((np.cos(yaw), np.sin(yaw)))
    return np.column_stack((np.cumsum(steps, axis=0) - steps[0], yaw))


def passers_by(poses: FloatArray, shown: BoolArray, rng: np.random.Generator) -> FloatArray:
    """Positions [T, K, 2] of people who walk straight on past the observer; NaN where they are not ``shown`` [T, K]."""
    frames, people = shown.shape
    middle = np.array([np.flatnonzero(row).mean() if row.any() else 0.0 for row in shown.T])
    nearest = poses[middle.astype(int), :2] + rng.uniform(-8.0, 8.0, (people, 2))
    velocity = rng.normal(0.0, 0.8, (people, 2))
    paths = nearest + (np.arange(frames)[:, None, None] - middle[:, None]) * DT * velocity
    return np.where(shown[..., None], paths, np.nan)


def one_by_one(frames: int, gaps: list[tuple[int, int]], together: int, stay: int) -> BoolArray:
    """Who is shown [T, K]: in turn, so that ``together`` people are there at once, each for ``stay`` frames.

    Nobody is in the ``gaps`` (first frame, frames), and whoever is seen after one is somebody new.
    """
    every = max(stay // together, 1)
    columns: list[BoolArray] = []
    open_frames = np.ones(frames, np.bool_)
    for first, length in gaps:
        open_frames[first : first + length] = False
    stretch = np.cumsum(np.diff(open_frames.astype(int), prepend=0) != 0)
    for number in np.unique(stretch[open_frames]):
        first, last = np.flatnonzero(stretch == number)[[0, -1]]
        for begin in range(first - stay + every, last + 1, every):
            column = np.zeros(frames, np.bool_)
            column[max(begin, first) : min(begin + stay, last + 1)] = True
            columns.append(column)
    return np.array(columns).T


def sparse_crowd(
    seed: int,
    shown: BoolArray,
    *,
    speed: float = 1.3,
    pixel_std: float = 1.0,
    camera: Camera | None = None,
) -> tuple[Sequence, Truth]:
    """What an observer sees of the people ``shown`` [T, K], and what protocol `sequential` gives."""
    rng, camera = np.random.default_rng(seed), camera or PanoramaCamera()
    poses = stroll(len(shown), rng, speed)
    positions = passers_by(poses, shown, rng)
    heights = np.asarray(rng.normal(1.7, 0.07, shown.shape[1]))
    boxes = camera.project(world_to_relative(positions, poses), np.broadcast_to(heights, shown.shape))
    boxes = boxes + pixel_std * rng.normal(size=boxes.shape) * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    truth = Truth(poses=poses, positions=positions, heights=heights)
    return sequence_of(truth, boxes), truth
