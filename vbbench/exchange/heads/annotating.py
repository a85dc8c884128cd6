"""What annotators would draw: boxes around heads, by hand in key frames and interpolated, and others to ignore."""

from dataclasses import dataclass

import numpy as np

from vbbench.exchange.heads.camera import SurveillanceCamera
from vbbench.exchange.heads.sighting import HEAD, Heads
from vbbench.geometry import FloatArray, IntArray

ALIKE = 0.5
"""Correlation of the errors of a box's width and height."""
SMALLEST = 0.2
"""No box is drawn smaller than this part of the head."""


def draw_boxes(heads: Heads, noise: float, key_every: int, rng: np.random.Generator) -> FloatArray:
    """Boxes [N, 4] (left, top, width, height) in px from 0, with errors.

    Key frames are every ``key_every``-th, the first and the last of each track. There, width and height are each wrong
    by a normal factor, and each side of the box moves as much, so that the centre is wrong by half of that. The boxes
    between are interpolated; the errors of key boxes are raised so that those of all boxes together have ``noise``.

    Parameters
    ----------
    heads : sorted by track and frame.
    noise : root mean square of the relative errors of widths, and of heights.
    key_every : frames from key box to key box.
    rng : draws the errors.
    """
    keys = _keys(heads, key_every)
    spread = noise * _raised(key_every)
    errors = rng.standard_normal((len(keys), 5))
    factor = 1.0 + spread * (np.sqrt(ALIKE) * errors[:, :1] + np.sqrt(1.0 - ALIKE) * errors[:, 1:3])
    sizes = heads.sizes[keys] * np.maximum(factor, SMALLEST)
    corners = heads.places[keys] + 0.5 * spread * errors[:, 3:] * heads.sizes[keys] - sizes / 2.0
    return _joined(heads, keys, np.concatenate([corners, sizes], axis=1))


def _keys(heads: Heads, key_every: int) -> IntArray:
    """Rows that are key boxes."""
    begins = np.diff(heads.track, prepend=-1) != 0
    ends = np.append(begins[1:], True)
    return np.flatnonzero(begins | ends | (heads.frame % key_every == 0))


def _raised(key_every: int) -> float:
    """Root mean square error of key boxes, divided by that of all boxes, most of which are means of two."""
    part = np.arange(key_every) / key_every
    return float(1.0 / np.sqrt(np.mean(part**2 + (1.0 - part) ** 2)))


def _joined(heads: Heads, keys: IntArray, boxes: FloatArray) -> FloatArray:
    """Boxes [N, 4] of all rows from those [M, 4] of the rows ``keys``."""
    rows = np.arange(len(heads))
    before = np.searchsorted(keys, rows, side="right") - 1
    after = np.minimum(before + (keys[before] != rows), len(keys) - 1)
    start, end = heads.frame[keys[before]], heads.frame[keys[after]]
    part = ((heads.frame - start) / np.maximum(end - start, 1))[:, None]
    return np.asarray((1.0 - part) * boxes[before] + part * boxes[after])


PEDESTRIAN, STATIC, IGNORE, ON_VEHICLE = 1, 2, 3, 4
"""Classes of MOTChallenge Head Tracking 21."""
SITTING, POSTERS, RIDERS, REFLECTIONS = 4, 2, 3, 5
"""Numbers of people who sit, regions to ignore, people on vehicles, and heads of confidence 0."""
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
    number : [N] which object they belong to, from 0.
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
