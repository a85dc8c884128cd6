"""What one observer sees of a scene: the camera carried along, people's boxes, what shows, and what is given."""

import numpy as np

from vbbench.camera import Camera
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Look
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import Sequence, SequenceData, Truth
from vbbench_generators.recordings.eligibility import Span
from vbbench_generators.tiers.corruption import Corruption
from vbbench_generators.tiers.noise import add_pixel_noise, wandering
from vbbench_generators.tiers.occlusion import enough, see
from vbbench_generators.tiers.tracking.observing import Tracked, track_people
from vbbench_generators.views.heading import WANDER_STD, WANDER_TIME


def look_at(
    truth: Truth, seen: BoolArray, camera: Camera, corruption: Corruption, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Boxes [T, K, 3] in px of whoever is to be seen and in the picture, corrupted, and visible fractions [T, K].

    Both are NaN where nobody is seen.

    Parameters
    ----------
    truth : everybody who can be seen, or hide others.
    seen : [T, K] who is to be seen.
    """
    if corruption.hiding is None:
        boxes = project(truth, seen, camera)
        visible = np.where(np.isnan(boxes[..., 2]), np.nan, 1.0)
    else:
        showing = see(truth.positions, truth.heights, truth.poses, camera, corruption.hiding.outline)
        seen = seen & enough(showing, corruption.hiding.least_visible)
        boxes = project(truth, seen, camera)
        observed = ~np.isnan(boxes[..., 2])
        visible = np.where(observed, showing.visible, np.nan)
        if corruption.hiding.cut:
            boxes = np.where(observed[..., None], showing.boxes, np.nan)
    if corruption.pixel_std > 0:
        boxes[seen] = add_pixel_noise(boxes[seen], camera, corruption.pixel_std, rng)
    return boxes, visible


def track_sights(
    truth: Truth,
    seen: BoolArray,
    people: IntArray,
    info: DatasetInfo,
    corruption: Corruption,
    watched: BoolArray,
    rng: np.random.Generator,
) -> Tracked:
    """What the tracker makes of whoever is to be seen ([T, P]); ``people`` [P] are their ids, ``watched`` as there."""
    settings, hiding = corruption.tracking, corruption.hiding
    if settings is None or hiding is None:
        raise ValueError("this tier has no tracker")
    showing = see(truth.positions, truth.heights, truth.poses, info.camera, hiding.outline)
    boxes = project(truth, seen, info.camera)
    return track_people(boxes, showing, people, info.camera, info.dt, watched, settings, hiding.outline, rng)


def truth_of_tracks(truth: Truth, people: IntArray, persons: IntArray) -> Truth:
    """Truth of tracks [T, K] behind which are ``persons``, from that of ``people`` [P]; NaN where nobody is."""
    positions, heights = np.full((*persons.shape, 2), np.nan), np.full(persons.shape[1], np.nan)
    frame, track = np.nonzero(persons >= 0)
    column = np.searchsorted(people, persons[frame, track])
    positions[frame, track] = truth.positions[frame, column]
    heights[track[::-1]] = truth.heights[column[::-1]]  # the first person's, where there are several
    return Truth(poses=truth.poses, positions=positions, heights=heights)


def project(truth: Truth, seen: BoolArray, camera: Camera) -> FloatArray:
    """Exact boxes [T, K, 3] in px of whoever is to be seen ([T, K]); NaN elsewhere and outside the picture."""
    who = np.flatnonzero(seen)
    relative = world_to_relative(truth.positions, truth.poses).reshape(-1, 2).take(who, axis=0)
    boxes = np.full((seen.size, 3), np.nan)
    boxes[who] = camera.project(relative, truth.heights.take(who % max(len(truth.heights), 1)))
    return boxes.reshape(*seen.shape, 3)


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
        heading = heading + WANDER_STD * wandering((len(heading),), WANDER_TIME, scene.dt, rng)
    wrapped = np.arctan2(np.sin(heading), np.cos(heading))
    poses = np.concatenate([scene.positions[frames, span.column], wrapped[:, None]], axis=1)
    seen = crowd & span.counted[:, None]
    seen[:, span.column] = False
    columns = np.flatnonzero((scene.present[frames] if corruption.hiding else seen).any(axis=0))
    columns = columns[columns != span.column]
    positions = scene.positions[frames].take(columns, axis=1)
    truth = Truth(poses=poses, positions=positions, heights=scene.heights[columns])
    seen, people = seen[:, columns], scene.people[columns]
    persons = None
    if corruption.tracking is None:
        boxes, visible = look_at(truth, seen, info.camera, corruption, rng)
        kept = ~np.isnan(boxes[..., 2]).all(axis=0)  # whoever never comes into the picture is left out
        boxes, visible, tracks = boxes[:, kept], visible[:, kept], people[kept]
        truth = Truth(poses=poses, positions=positions[:, kept], heights=truth.heights[kept])
    else:
        tracked = track_sights(truth, seen, people, info, corruption, span.counted, rng)
        boxes, visible, persons = tracked.boxes, tracked.scores, tracked.persons
        tracks = np.arange(boxes.shape[1])
        truth = truth_of_tracks(truth, people, persons)
    boxes = corruption.written(boxes, info.camera)
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
