"""Boxes of people, and what of them shows, as a camera carried along sees them."""

from dataclasses import dataclass

import numpy as np

from vbbench.arrays import BoolArray, FloatArray
from vbbench.camera import Camera
from vbbench.geometry import world_to_relative
from vbbench.sequence import Truth
from vbbench_generators.corruption import Corruption, add_pixel_noise
from vbbench_generators.occlusion import enough, see


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


def project(truth: Truth, seen: BoolArray, camera: Camera) -> FloatArray:
    """Exact boxes [T, K, 3] in px of whoever is to be seen ([T, K]); NaN elsewhere and outside the picture."""
    who = np.flatnonzero(seen)
    relative = world_to_relative(truth.positions, truth.poses).reshape(-1, 2).take(who, axis=0)
    boxes = np.full((seen.size, 3), np.nan)
    boxes[who] = camera.project(relative, truth.heights.take(who % max(len(truth.heights), 1)))
    return boxes.reshape(*seen.shape, 3)
