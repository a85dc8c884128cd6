"""A detector that errs as detectors do: misses, jitter, merged boxes and false alarms, from who shows how much."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vbbench.arrays import BoolArray, FloatArray, IntArray
from vbbench.boxes import overlaps
from vbbench.camera import Camera, PanoramaCamera
from vbbench_generators.tracking.association import from_centres
from vbbench_generators.tracking.settings import DetectorModel
from vbbench_generators.tracking.tracker import Detections

ALARM_HEIGHT, ALARM_SPREAD = 1.7, 0.2
"""False alarms are of things as tall as people: mean and standard deviation in m, on the ground."""
NEAREST_ALARM, FARTHEST_ALARM = 3.0, 25.0
"""Where they stand, in m from the camera."""
SMALLEST = 2.0
"""No detection is smaller than this, in px."""


@dataclass(frozen=True)
class Visible:
    """Everybody in the picture, [T, K].

    Parameters
    ----------
    boxes : [T, K, 4] whole people: centre column, centre row, width and height in px; NaN = not there to be detected.
    hidden : [T, K, 4] how far in px the left, top, right and bottom edges of what shows stand inside the person's own.
    visible : [T, K] how much shows.
    """

    boxes: FloatArray
    hidden: FloatArray
    visible: FloatArray


def detect(
    people: Visible, model: DetectorModel, camera: Camera, dt: float, watched: BoolArray, rng: np.random.Generator
) -> Iterator[Detections]:
    """The detections of every frame; no false alarms in frames that are not ``watched`` ([T])."""
    boxes, scores = _found(people, model, dt, rng)
    alarms, alarm_scores = _false_alarms(model, camera, dt, watched, rng)
    merging = rng.random((len(boxes), boxes.shape[1]))
    period = float(camera.width) if isinstance(camera, PanoramaCamera) else None
    for frame in range(len(boxes)):
        there = np.flatnonzero(~np.isnan(scores[frame]))
        found, sure = boxes[frame, there], scores[frame, there]
        found, sure = _merge(found, sure, people.boxes[frame, there], merging[frame, there], model, period)
        loud = ~np.isnan(alarm_scores[frame])
        found = np.concatenate([found, alarms[frame, loud]])
        sure = np.concatenate([sure, alarm_scores[frame, loud]])
        kept = _suppress(found, sure, model.suppress_overlap, period)
        yield Detections(found[kept], sure[kept])


def log_odds(heights: FloatArray, visible: FloatArray, model: DetectorModel) -> FloatArray:
    """Mean log-odds of scores of people so many px high who show so much."""
    return model.score_best - model.score_small / heights - model.score_hidden * (1.0 - visible)


def wandering(shape: tuple[int, ...], memory: float, dt: float, rng: np.random.Generator) -> FloatArray:
    """Standard normal numbers correlated over time, the first axis, with e^(−t/``memory``)."""
    numbers = rng.standard_normal(shape)
    kept = np.exp(-dt / memory)
    for t in range(1, len(numbers)):
        numbers[t] = kept * numbers[t - 1] + np.sqrt(1.0 - kept**2) * numbers[t]
    return numbers


def _found(people: Visible, model: DetectorModel, dt: float, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Boxes [T, K, 4] and scores [T, K] of everybody; NaN = not there, or showing too little."""
    noise = wandering((*people.visible.shape, 6), model.memory, dt, rng)
    height = people.boxes[..., 3]
    odds = log_odds(height, people.visible, model) + model.score_std * noise[..., 4]
    scores = np.where(people.visible >= model.least_visible, 1.0 / (1.0 + np.exp(-odds)), np.nan)
    stds = np.array([model.side_std, model.top_std, model.side_std, model.top_std]) * height[..., None]
    edges = np.concatenate([people.boxes[..., :2] - 0.5 * people.boxes[..., 2:]] * 2, axis=-1)
    edges[..., 2:] += people.boxes[..., 2:]
    pull = np.clip(model.pull + model.pull_std * noise[..., 5:], 0.0, 1.0)
    inwards = np.array([1.0, 1.0, -1.0, -1.0])
    edges += pull * inwards * people.hidden + np.hypot(stds, model.edge_std) * noise[..., :4]
    size = np.maximum(edges[..., 2:] - edges[..., :2], SMALLEST)
    return np.concatenate([0.5 * (edges[..., :2] + edges[..., 2:]), size], axis=-1), scores


def _merge(
    boxes: FloatArray,
    scores: FloatArray,
    true: FloatArray,
    chance: FloatArray,
    model: DetectorModel,
    period: float | None,
) -> tuple[FloatArray, FloatArray]:
    """The detections [N, 4], [N], some pairs of people who stand in one another's way made one box about both."""
    shared = np.triu(overlaps(from_centres(true), from_centres(true), period), k=1)
    kept = np.ones(len(boxes), bool)
    boxes, scores = boxes.copy(), scores.copy()
    for first, second in np.argwhere(shared > model.merge_overlap):
        if kept[first] and kept[second] and chance[first] < model.merge_rate:
            boxes[first] = _about(boxes[first], boxes[second], period)
            scores[first] = max(scores[first], scores[second])
            kept[second] = False
    return boxes[kept], scores[kept]


def _about(first: FloatArray, second: FloatArray, period: float | None) -> FloatArray:
    """The box [4] about two boxes."""
    shift = np.zeros(4)
    if period is not None:
        shift[0] = period * np.round((first[0] - second[0]) / period)
    a, b = first, second + shift
    low = np.minimum(a[:2] - 0.5 * a[2:], b[:2] - 0.5 * b[2:])
    high = np.maximum(a[:2] + 0.5 * a[2:], b[:2] + 0.5 * b[2:])
    return np.concatenate([0.5 * (low + high), high - low])


def _suppress(boxes: FloatArray, scores: FloatArray, overlap: float, period: float | None) -> IntArray:
    """Indices of the detections left when of two that overlap too much the worse goes, best first."""
    order = np.argsort(-scores, kind="stable")
    rectangles = from_centres(boxes[order])
    shared = overlaps(rectangles, rectangles, period) > overlap
    kept = np.ones(len(order), bool)
    for row in np.flatnonzero(np.triu(shared, k=1).any(axis=1)):
        if kept[row]:
            kept[row + 1 :] &= ~shared[row, row + 1 :]
    return np.asarray(order[kept], np.int64)


def _false_alarms(
    model: DetectorModel, camera: Camera, dt: float, watched: BoolArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Boxes [T, A, 4] and scores [T, A] of false alarms, NaN where there is none: each stands still in the picture."""
    frames = len(watched)
    lasting = max(model.false_alarm_memory / dt, 1.0)
    slots = int(rng.poisson(model.false_alarms * (frames / lasting + 1.0)))
    begins = rng.integers(1 - int(np.ceil(lasting)), frames, slots)
    ends = begins + rng.geometric(1.0 / lasting, slots)
    time = np.arange(frames)[:, None]
    there = (time >= begins) & (time < ends) & watched[:, None]
    reach = rng.uniform(NEAREST_ALARM, FARTHEST_ALARM, slots)
    tall = np.maximum(rng.normal(ALARM_HEIGHT, ALARM_SPREAD, slots), 0.5)
    scale = camera.focal / reach
    row = _horizon(camera) + scale * (camera.mount_height - 0.5 * tall)
    box = np.stack([rng.uniform(0.0, _width(camera), slots), row, model.aspect * scale * tall, scale * tall], axis=-1)
    noise = wandering((frames, slots, 5), model.memory, dt, rng)
    jitter = np.array([model.side_std, model.top_std, model.side_std, model.top_std]) * box[:, 3:]
    boxes = box + jitter * noise[..., :4]
    odds = model.false_alarm_score + model.score_std * noise[..., 4]
    boxes[..., 2:] = np.maximum(boxes[..., 2:], SMALLEST)
    return boxes, np.where(there, 1.0 / (1.0 + np.exp(-odds)), np.nan)


def _horizon(camera: Camera) -> float:
    """Row of the horizon: that of the centre of somebody twice as tall as the camera is high, anywhere ahead."""
    boxes = camera.project(np.array([[0.0, 5.0]]), np.array([2.0 * camera.mount_height]))
    return float(boxes[0, 1])


def _width(camera: Camera) -> float:
    return float(getattr(camera, "width", 0))
