"""From visible parts of people to tracks, with the person behind each."""

from dataclasses import dataclass, replace
from functools import partial
from math import ceil

import numpy as np

from vbbench.boxes import rectangles
from vbbench.camera import Camera
from vbbench.exchange.matching import match_tracks
from vbbench.generation.tier import Sight
from vbbench.geometry import BoolArray, FloatArray, IntArray, shorter_way, wrap_angle
from vbbench.sequence import Truth
from vbbench_generators.tiers.noise import Outline, Showing
from vbbench_generators.tiers.tracking.detector import SMALLEST, Visible, carried, detect, estimated_turns
from vbbench_generators.tiers.tracking.settings import TrackingSettings
from vbbench_generators.tiers.tracking.tracker import Found, Tracker, from_centres

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


@dataclass(frozen=True)
class Tracked:
    """The tracks of a sequence, and the people behind them.

    Parameters
    ----------
    boxes : [T, K, 3] (u, v, l) in px of each track, NaN = not seen.
    scores : [T, K] scores of their detections, NaN = not seen.
    persons : [T, K] the person behind each track, −1 = not seen, or a false alarm.
    """

    boxes: FloatArray
    scores: FloatArray
    persons: IntArray


def track_people(
    boxes: FloatArray,
    showing: Showing,
    people: IntArray,
    camera: Camera,
    dt: float,
    watched: BoolArray,
    settings: TrackingSettings,
    outline: Outline,
    rng: np.random.Generator,
    *,
    turns: FloatArray | None = None,
    every: int = 1,
) -> Tracked:
    """Detect and track people in every frame, and report some frames.

    Parameters
    ----------
    boxes : [T, P, 3] (u, v, l) in px of whole people; NaN = absent, or not in the picture.
    showing : their visible parts.
    people : [P] their ids.
    camera, dt : the camera, and seconds per frame.
    watched : [T] frames in which there may be detections.
    settings : settings of detector and tracker.
    outline : outline of people, as in ``showing``.
    rng : the sequence's random numbers.
    turns : [T, 3, 3] rotations since the frame before, which the tracker compensates, see `estimated_turns`; ``None``:
        no compensation.
    every : step from the first frame of the frames that are returned; least lengths of tracks count these frames.

    Returns
    -------
    The tracks in these frames.
    """
    period = camera.period
    there = showing.visible >= settings.detector.least_visible
    boxes = np.where(there[..., None], boxes, np.nan)
    whole = rectangles(boxes, settings.detector.aspect)
    centred = np.concatenate([boxes[..., :2], whole[..., 2:]], axis=-1)
    visible = np.where(np.isnan(boxes[..., 2]), np.nan, showing.visible)
    seen = Visible(centred, _hidden_edges(boxes, showing, outline, period), visible)
    tracker = Tracker(settings.tracker, dt, period)
    found = []
    for frame, detections in enumerate(detect(seen, settings.detector, camera, dt, watched, rng)):
        moved = None if turns is None else partial(carried, rotation=turns[frame], camera=camera)
        found.append(tracker.step(detections, moved))
    tracks, scores = _dense(found[::every], settings.tracker.least_boxes)
    tracks[..., 0] = camera.wrap_column(tracks[..., 0])
    persons = match_tracks(from_centres(tracks), whole[::every], people, camera, staying=True)
    return Tracked(tracks[..., [0, 1, 3]], scores, persons)


def track_video(
    sight: Sight,
    every: int,
    boxes: FloatArray,
    showing: Showing,
    settings: TrackingSettings,
    outline: Outline,
    rng: np.random.Generator,
) -> Tracked:
    """`track_people` for a sight at the rate of a video, with the camera's rotation compensated."""
    camera = sight.camera
    turns = estimated_turns(sight.truth.poses[:, 2], camera, settings.tracker.turn_std, rng)
    where = (sight.people, camera, sight.dt, sight.watched)
    return track_people(boxes, showing, *where, settings, outline, rng, turns=turns, every=every)


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
