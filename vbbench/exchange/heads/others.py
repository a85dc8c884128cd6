"""What else is annotated in pictures of crowds, and does not count: see `Others`."""

from dataclasses import dataclass

import numpy as np

from vbbench.exchange.heads.camera import SurveillanceCamera
from vbbench.exchange.heads.sighting import HEAD
from vbbench.geometry import FloatArray, IntArray

PEDESTRIAN, STATIC, IGNORE, ON_VEHICLE = 1, 2, 3, 4
"""Classes of MOTChallenge Head Tracking 21."""
SITTING, POSTERS, RIDERS, REFLECTIONS = 4, 2, 3, 5
"""How many there are: people who sit, regions to ignore, people on vehicles, heads of confidence 0."""
SEAT_HEIGHT, SADDLE_HEIGHT, REFLECTION_HEIGHT = 1.15, 1.75, 2.5
"""Heights of their heads over the ground in m."""
RIDING_SPEED = 5.0
"""In m/s, across the picture and back."""


@dataclass(frozen=True, kw_only=True)
class Others:
    """Boxes that an evaluation leaves out.

    Parameters
    ----------
    frame : [N] from 0.
    number : [N] whose they are, from 0.
    boxes : [N, 4] (left, top, width, height) in px from 0.
    kind : [N] class.
    confidence : [N] 0 or 1.
    """

    frame: IntArray
    number: IntArray
    boxes: FloatArray
    kind: IntArray
    confidence: IntArray


def draw_others(camera: SurveillanceCamera, frames: int, dt: float, rng: np.random.Generator) -> Others:
    """A few people who sit (class 2), regions to ignore (3), people on vehicles (4) and reflections (confidence 0)."""
    kinds = np.repeat([STATIC, ON_VEHICLE, PEDESTRIAN, IGNORE], [SITTING, RIDERS, REFLECTIONS, POSTERS])
    heads = len(kinds) - POSTERS
    up = np.repeat([SEAT_HEIGHT, SADDLE_HEIGHT, REFLECTION_HEIGHT], [SITTING, RIDERS, REFLECTIONS])
    (left, near), (right, _), (_, far), _ = camera.footprint()
    start = np.column_stack([rng.uniform(left, right, heads), rng.uniform(near, (near + far) / 2.0, heads), up])
    paths = np.broadcast_to(start, (frames, heads, 3)).copy()
    riding = kinds[:heads] == ON_VEHICLE
    road = right - left
    way = paths[:, riding, 0] - left + RIDING_SPEED * dt * np.arange(frames)[:, None]
    paths[:, riding, 0] = left + np.abs(np.mod(way, 2.0 * road) - road)
    boxes = np.concatenate([_head_boxes(camera, paths), _posters(camera, frames, rng)], axis=1)
    frame, number = np.nonzero(~np.isnan(boxes[..., 0]))
    faint = np.arange(len(kinds)) >= SITTING + RIDERS
    return Others(
        frame=frame,
        number=number,
        boxes=boxes[frame, number],
        kind=kinds[number],
        confidence=np.where(faint & (kinds == PEDESTRIAN), 0, 1)[number],
    )


def _head_boxes(camera: SurveillanceCamera, paths: FloatArray) -> FloatArray:
    """[T, N, 4] boxes of heads at [T, N, 3] (right, forward, up) m, NaN outside the picture."""
    seen = camera.project(paths)
    sizes = np.repeat(camera.focal * HEAD / seen[..., 2:], 2, axis=-1)
    boxes = np.concatenate([seen[..., :2] - sizes / 2.0, sizes], axis=-1)
    boxes[~camera.inside(seen)] = np.nan
    return boxes


def _posters(camera: SurveillanceCamera, frames: int, rng: np.random.Generator) -> FloatArray:
    """[T, P, 4] the same large boxes in every frame, along the top of the picture."""
    size = np.array([camera.width / 8.0, camera.height / 20.0])
    left = (np.arange(POSTERS) + rng.uniform(0.0, 0.5, POSTERS)) * camera.width / POSTERS
    boxes = np.column_stack([left, np.zeros(POSTERS), np.tile(size, (POSTERS, 1))])
    return np.broadcast_to(boxes, (frames, POSTERS, 4))
