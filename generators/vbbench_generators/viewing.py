"""What one observer sees of a scene: the camera carried along, the boxes in it, and what is given."""

from dataclasses import replace

import numpy as np

from vbbench.arrays import BoolArray, FloatArray, IntArray
from vbbench.dataset_info import DatasetInfo
from vbbench.generator import Look, SequenceData
from vbbench.geometry import world_to_relative
from vbbench.protocol import START_FRAMES
from vbbench.scene import Scene
from vbbench.sequence import Given, Sequence, Truth
from vbbench_generators.corruption import add_pixel_noise
from vbbench_generators.eligibility import Span
from vbbench_generators.heading import wandering_look


def view(
    scene: Scene,
    span: Span,
    crowd: BoolArray,
    heading: FloatArray,
    *,
    info: DatasetInfo,
    look: Look,
    index: int,
    rng: np.random.Generator,
) -> SequenceData:
    """The sequence of one observer.

    Parameters
    ----------
    scene, span : the observer's frames of the scene.
    crowd : [T, K] who is there to be seen in these frames.
    heading : [T] where the observer walks, in rad.
    info : camera and noise of the dataset.
    look : whether the camera looks where its bearer walks.
    index : number of the sequence.
    rng : the sequence's random numbers.
    """
    frames = slice(span.first, span.first + len(span.counted))
    if look == "wander":
        heading = heading + wandering_look(len(heading), scene.dt, rng)
    wrapped = np.arctan2(np.sin(heading), np.cos(heading))
    poses = np.concatenate([scene.positions[frames, span.column], wrapped[:, None]], axis=1)
    seen = crowd & span.counted[:, None]
    seen[:, span.column] = False
    columns = np.flatnonzero(seen.any(axis=0))
    positions = scene.positions[frames].take(columns, axis=1)
    truth = Truth(poses=poses, positions=positions, heights=scene.heights[columns])
    boxes = _boxes(truth, seen[:, columns], info, rng)
    return _without_unseen(_sequence(index, span, scene, columns, boxes, truth), truth)


def _boxes(truth: Truth, seen: BoolArray, info: DatasetInfo, rng: np.random.Generator) -> FloatArray:
    """Boxes [T, K, 3] in px of whoever is to be seen ([T, K]); NaN elsewhere and outside the picture."""
    camera, who = info.camera, np.flatnonzero(seen)
    relative = world_to_relative(truth.positions, truth.poses).reshape(-1, 2).take(who, axis=0)
    found = camera.project(relative, truth.heights.take(who % len(truth.heights)))
    if info.pixel_std > 0:
        found = add_pixel_noise(found, camera, info.pixel_std, rng)
    boxes = np.full((seen.size, 3), np.nan)
    boxes[who] = found
    return boxes.reshape(*seen.shape, 3)


def _sequence(index: int, span: Span, scene: Scene, columns: IntArray, boxes: FloatArray, truth: Truth) -> Sequence:
    observed = ~np.isnan(boxes[..., 2])
    return Sequence(
        index=index,
        scene=span.scene,
        observer=int(scene.people[span.column]),
        first_frame=span.first,
        tracks=scene.people[columns],
        observations=boxes,
        visible=np.where(observed, 1.0, np.nan),
        given=arrivals_given(truth, observed),
    )


def _without_unseen(sequence: Sequence, truth: Truth) -> SequenceData:
    """Leave out whoever never comes into the picture."""
    kept = sequence.observed.any(axis=0)
    if not kept.all():
        given = replace(sequence.given, positions=sequence.given.positions[:, kept])
        sequence = replace(
            sequence,
            tracks=sequence.tracks[kept],
            observations=sequence.observations[:, kept],
            visible=sequence.visible[:, kept],
            given=given,
        )
        truth = replace(truth, positions=truth.positions[:, kept], heights=truth.heights[kept])
    return SequenceData(sequence=sequence, truth=truth)


def arrivals_given(truth: Truth, observed: BoolArray) -> Given:
    """What `sequential` gives: the first two poses, and each track's first two visible frames, from [T, K]."""
    first_two = observed & (np.cumsum(observed, axis=0) <= START_FRAMES)
    first_poses = np.arange(len(truth.poses))[:, None] < START_FRAMES
    positions = np.full(truth.positions.shape, np.nan)
    positions[first_two] = truth.positions[first_two]
    return Given(poses=np.where(first_poses, truth.poses, np.nan), positions=positions)
