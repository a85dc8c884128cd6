"""Boxes of people, and what of them shows, as a camera carried along sees them."""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera
from vbbench.files.dataset_info import DatasetInfo
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.sequence import Truth
from vbbench_generators.corruption import Corruption, add_pixel_noise
from vbbench_generators.occlusion import enough, see
from vbbench_generators.tracking import Tracked, track_people


@dataclass(frozen=True)
class Sights:
    """What is seen of people.

    Parameters
    ----------
    boxes : [T, K, 3] (u, v, l) in px, NaN = not seen.
    visible : [T, K] visible fraction in (0, 1], NaN = not seen.
    """

    boxes: FloatArray
    visible: FloatArray


def look_at(truth: Truth, seen: BoolArray, camera: Camera, corruption: Corruption, rng: np.random.Generator) -> Sights:
    """Boxes of whoever is to be seen and in the picture, corrupted.

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
    return Sights(boxes, visible)


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
