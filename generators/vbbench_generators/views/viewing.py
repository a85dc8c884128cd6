"""What one observer sees of a scene: the camera carried along, people's boxes, what shows, and what is given."""

import numpy as np

from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Look
from vbbench.generation.tier import Sight, Tier
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import Sequence, SequenceData, Truth, held_persons
from vbbench_generators.recordings.eligibility import Span
from vbbench_generators.tiers.noise import Precision, wandering
from vbbench_generators.views.heading import WANDER_STD, WANDER_TIME, wrapped


def truth_of_tracks(truth: Truth, people: IntArray, persons: IntArray) -> Truth:
    """Truth of tracks [T, K] behind which are ``persons``, from that of ``people`` [P]; NaN where nobody is."""
    positions, heights = np.full((*persons.shape, 2), np.nan), np.full(persons.shape[1], np.nan)
    frame, track = np.nonzero(persons >= 0)
    column = np.searchsorted(people, persons[frame, track])
    positions[frame, track] = truth.positions[frame, column]
    heights[track[::-1]] = truth.heights[column[::-1]]  # the first person's, where there are several
    return Truth(poses=truth.poses, positions=positions, heights=heights)


def view(
    scene: Scene,
    span: Span,
    crowd: BoolArray,
    heading: FloatArray,
    *,
    info: DatasetInfo,
    look: Look,
    tier: Tier,
    index: int,
    rng: np.random.Generator,
    precision: Precision | None = None,
) -> SequenceData:
    """The sequence of one observer.

    Parameters
    ----------
    scene, span : the observer's frames of the scene.
    crowd : [T, K] who is there to be seen in these frames; who is not may still hide others.
    heading : [T] where the observer walks, in rad.
    info : camera of the dataset.
    look : whether the camera looks where its bearer walks.
    tier : what is done to exact boxes.
    index : number of the sequence.
    rng : the sequence's random numbers.
    precision : what boxes are rounded to in the end; ``None`` = not at all.
    """
    frames = slice(span.first, span.first + len(span.counted))
    if look == "wander":
        heading = heading + WANDER_STD * wandering((len(heading),), WANDER_TIME, scene.dt, rng)
    poses = np.concatenate([scene.positions[frames, span.column], wrapped(heading)[:, None]], axis=1)
    seen = crowd & span.counted[:, None]
    seen[:, span.column] = False
    columns = np.flatnonzero((scene.present[frames] if tier.hides else seen).any(axis=0))
    columns = columns[columns != span.column]
    positions, people = scene.positions[frames].take(columns, axis=1), scene.people[columns]
    truth = Truth(poses=poses, positions=positions, heights=scene.heights[columns])
    sight = Sight(
        truth=truth, people=people, seen=seen[:, columns], watched=span.counted, camera=info.camera, dt=info.dt
    )
    made = tier.observe(sight, rng)
    boxes, visible, persons = made.boxes, made.visible, made.persons
    if persons is None:
        kept = ~np.isnan(boxes[..., 2]).all(axis=0)  # whoever never comes into the picture is left out
        boxes, visible, tracks = boxes[:, kept], visible[:, kept], people[kept]
        truth = Truth(poses=poses, positions=positions[:, kept], heights=truth.heights[kept])
    else:
        tracks, persons = np.arange(boxes.shape[1]), held_persons(persons, ~np.isnan(boxes[..., 2]))
        truth = truth_of_tracks(truth, people, persons)
    if precision is not None:
        boxes = precision.rounded(boxes, info.camera)
    sequence = Sequence(
        index=index,
        scene=span.scene,
        observer=int(scene.people[span.column]),
        first_frame=span.first,
        tracks=tracks,
        observations=boxes,
        visible=visible,
        given=arrivals_given(truth, ~np.isnan(boxes[..., 2] + truth.positions[..., 0])),
    )
    return SequenceData(sequence=sequence, truth=truth, persons=persons)
