"""A sequence made up in memory, with gaps, late arrivals and a solver that errs: for the page's player."""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera, PanoramaCamera
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative, wrap_angle
from vbbench.protocol import arrivals_given
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Estimate

DT = 0.4


@dataclass(frozen=True, kw_only=True)
class MadeSequence:
    """A sequence with its camera and truth.

    Parameters
    ----------
    camera, sequence, truth : what they are called.
    """

    camera: Camera
    sequence: Sequence
    truth: Truth

    def estimate(self, rng: np.random.Generator, error: float) -> Estimate:
        """An answer that is off by ``error``, and here and there says nothing."""
        poses = self.truth.poses + rng.normal(0.0, error, self.truth.poses.shape)
        poses[:, 2] = wrap_angle(poses[:, 2])
        positions = self.truth.positions + rng.normal(0.0, error, self.truth.positions.shape)
        silent = rng.random(self.sequence.observed.shape) < 0.05
        positions[silent | ~self.sequence.observed] = np.nan
        return Estimate(poses=poses, positions=positions)


def made_sequence(
    people: int, frames: int, *, seed: int = 0, share: float = 0.9, far: float = 0.0, camera: Camera | None = None
) -> MadeSequence:
    """A crowd that walks evenly, of which each frame holds a ``share``, ``far`` m away from the map's origin."""
    rng, camera = np.random.default_rng(seed), camera or PanoramaCamera()
    spread = np.sqrt(people) + 2.0
    positions = _paths(rng, people, frames, spread) + far
    own = _paths(rng, 1, frames, 1.0)[:, 0] + far
    poses = np.column_stack([own, wrap_angle(3.0 + np.cumsum(rng.normal(0.0, 0.05, frames)))])
    positions[rng.random((frames, people)) >= share] = np.nan
    heights = rng.normal(1.7, 0.07, people)
    boxes = camera.project(world_to_relative(positions, poses), heights)
    truth = Truth(poses=poses, positions=positions, heights=heights)
    return MadeSequence(camera=camera, sequence=sequence_of(truth, boxes, 3 * np.arange(people)), truth=truth)


def _paths(rng: np.random.Generator, people: int, frames: int, spread: float) -> FloatArray:
    speed = rng.normal(0.0, 0.9, (1, people, 2)) + rng.normal(0.0, 0.05, (frames, people, 2))
    return rng.uniform(-spread, spread, (1, people, 2)) + np.cumsum(speed * DT, axis=0)


def sequence_of(truth: Truth, boxes: FloatArray, tracks: IntArray | None = None) -> Sequence:
    """The boxes [T, K, 3] of ``tracks`` [K], by default numbered from 0, and what protocol `sequential` gives."""
    observed: BoolArray = ~np.isnan(boxes[..., 2])
    return Sequence(
        index=0,
        scene=0,
        observer=10_000,
        first_frame=0,
        tracks=np.arange(boxes.shape[1]) if tracks is None else tracks,
        observations=boxes,
        visible=np.where(observed, 1.0, np.nan),
        given=arrivals_given(truth, observed),
    )
