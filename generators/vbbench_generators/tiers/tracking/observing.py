"""From visible parts of people to tracks, with the person behind each.

A simulated detector: misses, jitter, merged boxes and false alarms, depending on visible parts.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import ceil

import numpy as np

from vbbench.boxes import rectangles
from vbbench.camera import Camera
from vbbench.exchange.matching import match_tracks
from vbbench.generation.tier import Observations, Sight
from vbbench.geometry import BoolArray, FloatArray, shorter_way, wrap_angle
from vbbench.sequence import Truth
from vbbench_generators import _core
from vbbench_generators.tiers.noise import Outline, Showing, wandering
from vbbench_generators.tiers.tracking import DetectorModel, TrackingSettings
from vbbench_generators.tiers.tracking.tracker import CentredDetections, Found, Tracker, from_centres


def estimated_turns(yaw: FloatArray, camera: Camera, std: float, rng: np.random.Generator) -> FloatArray:
    """Estimated rotations [T, 3, 3] of directions (right, down, forward), from the frame before to each frame.

    Parameters
    ----------
    yaw : [T] in rad, of a camera with constant tilt; NaN counts as no rotation.
    camera : the camera, whose tilt the directions have.
    std : error of each rotation, in px in the middle of the picture.
    rng : random numbers of the errors.
    """
    left = np.nan_to_num(wrap_angle(np.diff(yaw, prepend=yaw[:1])))
    left = left + std / camera.focal * rng.standard_normal(len(yaw))
    sin, cos, zero = np.sin(left), np.cos(left), np.zeros_like(left)
    level = np.stack([cos, zero, sin, zero, zero + 1.0, zero, -sin, zero, cos], axis=-1).reshape(-1, 3, 3)
    tilt: FloatArray = camera.to_level(np.eye(3))  # rows: the camera's axes in the frame of a level one
    turned: FloatArray = tilt @ level @ tilt.T
    return turned


def carried(boxes: FloatArray, rotation: FloatArray, camera: Camera) -> FloatArray:
    """Boxes [N, 4] (centre column, centre row, width, height) in px after a ``rotation`` [3, 3] of the camera.

    NaN for boxes behind a camera whose picture has borders.
    """
    if camera.cylinder is not None and camera.period is not None and rotation[1, 1] == 1.0:
        moved = boxes.copy()
        moved[:, 0] += np.arctan2(rotation[0, 2], rotation[0, 0]) * camera.period / (2.0 * np.pi)
        return moved
    half = 0.5 * boxes[:, 3]
    rows = np.stack([boxes[:, 1] - half, boxes[:, 1] + half])
    ends = np.stack([np.broadcast_to(boxes[:, 0], rows.shape), rows], axis=-1)
    top, foot = camera.pixels(camera.directions(ends) @ rotation.T)
    across = shorter_way(foot[:, 0] - top[:, 0], camera.period)
    height = np.hypot(across, foot[:, 1] - top[:, 1])
    width = boxes[:, 2] * height / boxes[:, 3]
    return np.stack([top[:, 0] + 0.5 * across, 0.5 * (top[:, 1] + foot[:, 1]), width, height], axis=-1)


ALARM_HEIGHT, ALARM_SPREAD = 1.7, 0.2
"""False alarms are of things as tall as people: mean and standard deviation in m, on the ground."""
NEAREST_ALARM, FARTHEST_ALARM = 3.0, 25.0
"""Where they stand, in m from the camera."""
CUT = 1e-6
"""In px: boxes that end so near to the first or last row are cut off by it."""
SMALLEST = 2.0
"""No detection is smaller than this, in px."""


@dataclass(frozen=True)
class Visible:
    """All people in the picture.

    Parameters
    ----------
    boxes : [T, K, 4] boxes of whole people: centre column, centre row, width and height in px; NaN = not detectable.
    hidden : [T, K, 4] distances in px of left, top, right and bottom edges of the visible part from the person's.
    visible : [T, K] visible fractions.
    """

    boxes: FloatArray
    hidden: FloatArray
    visible: FloatArray


def detect(
    people: Visible, model: DetectorModel, camera: Camera, dt: float, watched: BoolArray, rng: np.random.Generator
) -> Iterator[CentredDetections]:
    """The detections of every frame; no false alarms in frames that are not ``watched`` ([T])."""
    boxes, scores = _found(people, model, camera, dt, rng)
    alarms = _false_alarms(model, camera, dt, watched, rng)
    merging = rng.random((len(boxes), boxes.shape[1]))
    period = camera.period or 0.0
    for frame in range(len(boxes)):
        there = np.flatnonzero(~np.isnan(scores[frame]))
        found, sure = boxes[frame, there], scores[frame, there]
        true, chance = people.boxes[frame, there], merging[frame, there]
        single = _core.merge_people(found, sure, true, chance, model.merge_overlap, model.merge_rate, period)
        found = np.concatenate([found[single], alarms[frame].boxes])
        sure = np.concatenate([sure[single], alarms[frame].scores])
        order = np.argsort(-sure, kind="stable")
        kept = order[_core.remaining(found, order, model.suppress_overlap, period)[order]]
        yield CentredDetections(found[kept], sure[kept])


def log_odds(heights: FloatArray, visible: FloatArray, model: DetectorModel) -> FloatArray:
    """Mean log-odds [...] of scores, by ``heights`` in px and ``visible`` fractions."""
    return model.score_best - model.score_small / heights - model.score_hidden * (1.0 - visible)


def _found(
    people: Visible, model: DetectorModel, camera: Camera, dt: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Boxes [T, K, 4] and scores [T, K] of all people; NaN = absent, or hardly visible.

    A box cut off by the first or last row ends there: all boxes of a detector on KITTI did, within 2 px.
    """
    noise = wandering((*people.visible.shape, 5), model.jitter_memory, dt, rng)
    doubt = wandering(people.visible.shape, model.score_memory, dt, rng)
    height = people.boxes[..., 3]
    odds = log_odds(height, people.visible, model) + model.score_std * doubt
    scores = np.where(people.visible >= model.least_visible, _shares(odds), np.nan)
    stds = _stds(model) * height[..., None]
    edges = np.concatenate([people.boxes[..., :2] - 0.5 * people.boxes[..., 2:]] * 2, axis=-1)
    edges[..., 2:] += people.boxes[..., 2:]
    pull = np.clip(model.pull + model.pull_std * noise[..., 4:], 0.0, 1.0)
    inwards = np.array([1.0, 1.0, -1.0, -1.0])
    jitter = np.hypot(stds, model.edge_std) * noise[..., :4]
    jitter[..., 1] *= np.abs(edges[..., 1]) > CUT
    jitter[..., 3] *= np.abs(edges[..., 3] - (camera.picture_size[1] - 1)) > CUT
    edges += pull * inwards * people.hidden + jitter
    size = np.maximum(edges[..., 2:] - edges[..., :2], SMALLEST)
    return np.concatenate([0.5 * (edges[..., :2] + edges[..., 2:]), size], axis=-1), scores


def _false_alarms(
    model: DetectorModel, camera: Camera, dt: float, watched: BoolArray, rng: np.random.Generator
) -> list[CentredDetections]:
    """The false alarms of every frame; each keeps its place in the picture while it lasts, but for jitter."""
    lasting = max(model.false_alarm_memory / dt, 1.0)
    before = int(np.ceil(5.0 * lasting))  # frames ahead of the first, so that it has its share
    count = int(rng.poisson(model.false_alarms / lasting * (len(watched) + before)))
    begins, lives = rng.integers(-before, len(watched), count), rng.geometric(1.0 / lasting, count)
    away = rng.uniform(NEAREST_ALARM, FARTHEST_ALARM, count)
    tall = np.maximum(rng.normal(ALARM_HEIGHT, ALARM_SPREAD, count), 0.5)
    column = rng.uniform(0.0, camera.picture_size[0], count)
    horizon = camera.horizon(column)
    of_a_metre = np.stack([column, horizon, np.ones(count)], axis=-1)  # boxes of 1 px, to know px per m at 1 m
    scale = camera.depth(camera.unproject(of_a_metre, np.ones(count))) / away
    row = horizon + scale * (camera.mount_height - 0.5 * tall)
    boxes = np.stack([column, row, model.aspect * scale * tall, scale * tall], axis=-1)
    scores = _shares(model.false_alarm_score + model.score_std * rng.standard_normal(count))
    alarm = np.repeat(np.arange(count), lives)
    frame = np.arange(len(alarm)) - np.repeat(np.cumsum(lives) - lives, lives) + begins[alarm]
    shaken = boxes[alarm] + _stds(model)[[0, 1, 0, 1]] * boxes[alarm, 3:] * rng.standard_normal((len(alarm), 4))
    shaken[:, 2:] = np.maximum(shaken[:, 2:], SMALLEST)
    there = (frame >= 0) & (frame < len(watched))
    there[there] = watched[frame[there]]
    order = np.flatnonzero(there)[np.argsort(frame[there], kind="stable")]
    edges = np.searchsorted(frame[order], np.arange(len(watched) + 1))
    groups = [order[first:last] for first, last in pairwise(edges)]
    return [CentredDetections(shaken[rows], scores[alarm[rows]]) for rows in groups]


def _stds(model: DetectorModel) -> FloatArray:
    """Standard deviations [4] of left, top, right and bottom edges, in box heights."""
    return np.array([model.side_std, model.top_std, model.side_std, model.bottom_std])


def _shares(odds: FloatArray) -> FloatArray:
    """Scores in [0, 1] of log-odds."""
    return 1.0 / (1.0 + np.exp(-odds))


VIDEO_RATE = 25.0
"""Frames per second of a usual camera's video, at which detectors and trackers run."""


def finer(sight: Sight, rate: float = VIDEO_RATE) -> tuple[Sight, int]:
    """The sight, interpolated to a higher frame rate.

    Parameters
    ----------
    sight : the surroundings of an observer in T frames.
    rate : least number of frames per second.

    Returns
    -------
    The sight in (T − 1)·n + 1 frames, of which every n-th is one of the T, unchanged; and n ≥ 1.
    """
    steps = max(ceil(sight.dt * rate - 1e-9), 1)
    if steps == 1:
        return sight, 1
    truth = sight.truth
    turns = np.diff(truth.poses[:, 2:], axis=0)
    ahead = np.concatenate([np.diff(truth.poses[:, :2], axis=0), wrap_angle(turns)], axis=1)
    nearest = (np.arange((len(truth.poses) - 1) * steps + 1) + steps // 2) // steps
    fine = Truth(
        poses=_curve(truth.poses, ahead, steps),
        positions=_curve(truth.positions, np.diff(truth.positions, axis=0), steps),
        heights=truth.heights,
    )
    return replace(
        sight, truth=fine, seen=sight.seen[nearest], watched=sight.watched[nearest], dt=sight.dt / steps
    ), steps


def _curve(values: FloatArray, ahead: FloatArray, steps: int) -> FloatArray:
    """``values`` [T, ...] interpolated by cubics at ``steps`` times per frame; ``ahead`` [T − 1, ...]: their changes.

    Where one end is NaN, the other is extrapolated at constant velocity for half a frame.
    """
    unknown = np.full((1, *values.shape[1:]), np.nan)
    before, after = np.concatenate([unknown, ahead]), np.concatenate([ahead, unknown])
    before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
    speed = np.nan_to_num(0.5 * (before + after))
    s = (np.arange(steps) / steps).reshape(1, -1, *[1] * (values.ndim - 1))
    start, way, leaving, arriving = values[:-1, None], ahead[:, None], speed[:-1, None], speed[1:, None]
    cubic = start + s**2 * (3.0 - 2.0 * s) * way + s * (1.0 - s) * ((1.0 - s) * leaving - s * arriving)
    onwards = np.where(s < 0.5, start + s * leaving, values[1:, None] - (1.0 - s) * arriving)
    between = np.where(np.isnan(way), onwards, cubic)
    return np.concatenate([between.reshape(len(way) * steps, *values.shape[1:]), values[-1:]])


@dataclass(frozen=True, kw_only=True)
class Film:
    """What a detector may see, in the frames of a video.

    Parameters
    ----------
    sight : the scene at the rate of the video.
    every : frames of the video per frame of the dataset; least lengths of tracks count the latter.
    boxes : [T, P, 3] (u, v, l) in px of whole people; NaN = absent, or not in the picture.
    showing : their visible parts.
    """

    sight: Sight
    every: int
    boxes: FloatArray
    showing: Showing


def track_video(film: Film, settings: TrackingSettings, outline: Outline, rng: np.random.Generator) -> Observations:
    """Detect and track people in a video, with the camera's rotation compensated.

    Returns the tracks in the dataset's frames, with the scores of their detections as visible fractions.

    Parameters
    ----------
    film : the video.
    settings : settings of detector and tracker.
    outline : outline of people, as in the film.
    rng : the sequence's random numbers.
    """
    sight, showing = film.sight, film.showing
    camera, period = sight.camera, sight.camera.period
    turns = estimated_turns(sight.truth.poses[:, 2], camera, settings.tracker.turn_std, rng)
    there = showing.visible >= settings.detector.least_visible
    boxes = np.where(there[..., None], film.boxes, np.nan)
    whole = rectangles(boxes, settings.detector.aspect)
    centred = np.concatenate([boxes[..., :2], whole[..., 2:]], axis=-1)
    visible = np.where(np.isnan(boxes[..., 2]), np.nan, showing.visible)
    seen = Visible(centred, _hidden_edges(boxes, showing, outline, period), visible)
    tracker = Tracker(settings.tracker, sight.dt, period)
    detected = detect(seen, settings.detector, camera, sight.dt, sight.watched, rng)
    found = [
        tracker.step(detections, partial(carried, rotation=turn, camera=camera))
        for turn, detections in zip(turns, detected, strict=True)
    ]
    tracks, scores = _dense(found[:: film.every], settings.tracker.least_boxes)
    tracks[..., 0] = camera.wrap_column(tracks[..., 0])
    persons = match_tracks(from_centres(tracks), whole[:: film.every], sight.people, camera, staying=True)
    return Observations(boxes=tracks[..., [0, 1, 3]], visible=scores, persons=persons)


def _hidden_edges(boxes: FloatArray, showing: Showing, outline: Outline, period: float | None) -> FloatArray:
    """[T, P, 4] distances in px of left, top, right and bottom edges of the visible part from those of the outline."""
    aside = shorter_way(showing.boxes[..., 0] - boxes[..., 0], period)
    down = showing.boxes[..., 1] - boxes[..., 1]
    length, reach = boxes[..., 2], outline.half[-1] * boxes[..., 2]
    narrow, short = 0.5 * showing.widths, 0.5 * showing.boxes[..., 2]
    edges = [reach + aside - narrow, 0.5 * length + down - short, reach - aside - narrow, 0.5 * length - down - short]
    return np.clip(np.nan_to_num(np.stack(edges, axis=-1)), 0.0, None)


def _dense(found: list[Found], least: int) -> tuple[FloatArray, FloatArray]:
    """Boxes [T, K, 4] (centre, width, height) and scores [T, K] of the tracks of ``least`` boxes, in order of birth."""
    frame = np.repeat(np.arange(len(found)), [len(part.ids) for part in found])
    ids = np.concatenate([part.ids for part in found])
    _, column, count = np.unique(ids, return_inverse=True, return_counts=True)
    new = np.cumsum(count >= least) - 1
    kept = count[column] >= least
    shape = (len(found), int(np.sum(count >= least)))
    boxes, scores = np.full((*shape, 4), np.nan), np.full(shape, np.nan)
    where = frame[kept], new[column[kept]]
    boxes[where] = np.concatenate([part.boxes for part in found])[kept]
    scores[where] = np.concatenate([part.scores for part in found])[kept]
    boxes[..., 2:] = np.maximum(boxes[..., 2:], SMALLEST)
    return boxes, scores
