"""What one observer sees of a scene: the camera carried along, the boxes in it, and what is given."""

from dataclasses import replace

import numpy as np

from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Look
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import Sequence, SequenceData, Truth
from vbbench_generators.corruption import Corruption
from vbbench_generators.eligibility import Span
from vbbench_generators.heading import wandering_look
from vbbench_generators.sights import Sights, look_at, track_sights, truth_of_tracks


def view(
    scene: Scene,
    span: Span,
    crowd: BoolArray,
    heading: FloatArray,
    *,
    info: DatasetInfo,
    look: Look,
    corruption: Corruption,
    index: int,
    rng: np.random.Generator,
) -> SequenceData:
    """The sequence of one observer.

    Parameters
    ----------
    scene, span : the observer's frames of the scene.
    crowd : [T, K] who is there to be seen in these frames; who is not may still hide others.
    heading : [T] where the observer walks, in rad.
    info : camera of the dataset.
    look : whether the camera looks where its bearer walks.
    corruption : what is done to exact boxes.
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
    columns = np.flatnonzero((scene.present[frames] if corruption.hiding else seen).any(axis=0))
    columns = columns[columns != span.column]
    positions = scene.positions[frames].take(columns, axis=1)
    truth = Truth(poses=poses, positions=positions, heights=scene.heights[columns])
    seen, people = seen[:, columns], scene.people[columns]
    if corruption.tracking is None:
        sights = look_at(truth, seen, info.camera, corruption, rng)
        sights = Sights(corruption.written(sights.boxes, info.camera), sights.visible)
        return _without_unseen(_sequence(index, span, scene, people, sights, truth), truth)
    tracked = track_sights(truth, seen, people, info, corruption, span.counted, rng)
    truth = truth_of_tracks(truth, people, tracked.persons)
    sights = Sights(corruption.written(tracked.boxes, info.camera), tracked.scores)
    sequence = _sequence(index, span, scene, np.arange(sights.boxes.shape[1]), sights, truth)
    return SequenceData(sequence=sequence, truth=truth, persons=tracked.persons)


def _sequence(index: int, span: Span, scene: Scene, tracks: IntArray, sights: Sights, truth: Truth) -> Sequence:
    return Sequence(
        index=index,
        scene=span.scene,
        observer=int(scene.people[span.column]),
        first_frame=span.first,
        tracks=tracks,
        observations=sights.boxes,
        visible=sights.visible,
        given=arrivals_given(truth, ~np.isnan(sights.boxes[..., 2] + truth.positions[..., 0])),
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
