"""The data of the player: a sequence, its truth, a solver's estimate and people without a box, as short text."""

import base64
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from vbbench.boxes import BOX_ASPECT, cut_to_picture, rectangles
from vbbench.camera import Camera, camera_to_dict
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.generation.footage import FOOTAGE
from vbbench.geometry import (
    BoolArray,
    FloatArray,
    IntArray,
    relative_to_world,
    shorter_way,
    world_to_relative,
    wrap_angle,
)
from vbbench.pictures.people_colours import person_slots
from vbbench.sequence import Sequence, Truth

CUT, HIDDEN = 0.6, 0.6
"""Who shows less than this share inside the picture is cut off; whose width is covered by more of it is hidden."""

_SAMPLES = np.linspace(-0.5, 0.5, 9)  # of a box's width, at which it may be covered
_FINDERS = ("detector", "tracking")
"""Keys of a dataset's definition by which boxes are detections, and not drawn around everybody."""


class Reason(IntEnum):
    """Why a person has no box; 0 is nobody, or a person with one. ``scripts/player-data.js`` has words."""

    OUTSIDE = 1
    CUT = 2
    HIDDEN = 3
    SMALL = 4
    MISSED = 5
    LEFT_OUT = 6


@dataclass(frozen=True, kw_only=True)
class Unboxed:
    """Who has no box: columns are the K tracks of the sequence, then M people while they have none of these.

    Parameters
    ----------
    reasons : [T, K + M] of `Reason`.
    boxes : [T, K + M, 3] (u, v, l) in px where a box would be; NaN outside the picture, and where there is a box.
    positions : [T, M, 2] in m of the M people while they have no box, as the player shows the truth.
    """

    reasons: IntArray
    boxes: FloatArray
    positions: FloatArray


def find_unboxed(dataset: Dataset, sequence: Sequence, truth: Truth) -> Unboxed | None:
    """Everybody of the scene without a box, with the first reason that holds; ``None`` where places are not known.

    Parameters
    ----------
    truth : the sequence's, as the player shows it.
    """
    if dataset.info.truth == "poses":
        return None
    people, places, heights = dataset.surroundings(sequence)
    if dataset.info.truth == "relative":
        places = relative_to_world(places, truth.poses)
    places[:, people == sequence.observer] = np.nan
    camera = dataset.camera(sequence)
    relative = world_to_relative(places, truth.poses)
    boxes = camera.project(relative, np.where(np.isfinite(heights), heights, dataset.info.height_mean))
    persons = dataset.track_persons(sequence)
    smallest = float(sequence.observations[sequence.observed, 2].min(initial=np.inf))
    without = np.isfinite(places[..., 0]) & ~_holds(persons, sequence.observed, people)
    found = any(name in dataset.info.definition for name in _FINDERS) or dataset.info.tier == FOOTAGE
    hides = found or bool(np.any(sequence.visible < 1.0))
    hidden = _hidden(boxes, camera.depth(relative), camera.period) if hides else np.zeros(without.shape)
    reasons = np.where(without, _reasons(boxes, hidden, camera, smallest, found), 0)
    return _by_track(people, persons, reasons, boxes, places)


def _holds(persons: IntArray, observed: BoolArray, people: IntArray) -> BoolArray:
    """[T, P] which of the ``people`` [P] a box shows, ``persons`` [T, K] being those behind the tracks."""
    return np.stack([np.isin(people, row[seen]) for row, seen in zip(persons, observed, strict=True)])


def _reasons(boxes: FloatArray, hidden: FloatArray, camera: Camera, smallest: float, found: bool) -> IntArray:
    """[T, P] why each of the boxes [T, P, 3] might be missing, were it not there, by the share of it that is hidden."""
    whole = rectangles(boxes)
    inside = cut_to_picture(whole, camera)
    share = np.prod(np.clip(inside[..., 2:], 0.0, None), axis=-1) / np.prod(whole[..., 2:], axis=-1)
    if camera.period is not None:  # a cylinder has no upper and lower border
        share = np.ones(share.shape)
    cases = [
        (np.isnan(boxes[..., 0]), Reason.OUTSIDE),
        (share < CUT, Reason.CUT),
        (hidden > HIDDEN, Reason.HIDDEN),
        ((boxes[..., 2] < smallest) & found, Reason.SMALL),
    ]
    other = Reason.MISSED if found else Reason.LEFT_OUT
    return np.select([case for case, _ in cases], [int(reason) for _, reason in cases], int(other))


def _hidden(boxes: FloatArray, depths: FloatArray, period: float | None) -> FloatArray:
    """[T, P] share of each box's width that nearer people stand before."""
    return np.stack([_covered(*moment, period) for moment in zip(boxes, depths, strict=True)])


def _covered(boxes: FloatArray, depths: FloatArray, period: float | None) -> FloatArray:
    """The same [P] of a frame."""
    half = 0.5 * BOX_ASPECT * boxes[:, 2]
    columns = boxes[:, :1] + 2.0 * half[:, None] * _SAMPLES
    across = np.abs(shorter_way(columns[:, :, None] - boxes[:, 0], period)) < half
    covered: FloatArray = (across & (depths < depths[:, None])[:, None]).any(axis=-1).mean(axis=-1)
    return covered


def _by_track(people: IntArray, persons: IntArray, reasons: IntArray, boxes: FloatArray, places: FloatArray) -> Unboxed:
    """Move everybody who is behind a track, of several the last, from the column of the person to that of the track."""
    frames, tracks = persons.shape
    boxes = np.where((reasons > 0)[..., None], boxes, np.nan)
    of_tracks, boxes_of_tracks = np.zeros((frames, tracks), np.int64), np.full((frames, tracks, 3), np.nan)
    frame = np.arange(frames)
    for track in reversed(range(tracks)):
        column = np.searchsorted(people, persons[:, track]).clip(max=len(people) - 1)
        moved = (people[column] == persons[:, track]) & (reasons[frame, column] > 0)
        of_tracks[moved, track] = reasons[frame, column][moved]
        boxes_of_tracks[moved, track] = boxes[frame, column][moved]
        reasons[frame[moved], column[moved]] = 0
    left = (reasons > 0).any(axis=0)
    kept = reasons[:, left]
    return Unboxed(
        reasons=np.hstack([of_tracks, kept]),
        boxes=np.hstack([boxes_of_tracks, np.where((kept > 0)[..., None], boxes[:, left], np.nan)]),
        positions=np.where((kept > 0)[..., None], places[:, left], np.nan),
    )


POSE, METRE, PIXEL = np.array([1e-3, 1e-3, 1e-4]), 1e-3, 0.1
"""Quanta of poses (m, m, rad), of places (m) and of boxes (px)."""

COARSE = (1, 2, 5, 10)
"""How many quanta are taken at a time: the fewest with which a file keeps to its size."""

CLIP_SIZE, ESTIMATE_SIZE, UNBOXED_SIZE = 21_000, 12_000, 12_000
"""Bytes of text for a sequence and for a solver: with three solvers under 60 kB. People without a box come later."""

_SMOOTH = 2
"""People and boxes move evenly: their second differences are small."""

_ORDERS = (0, 1, 2)

ABOVE, BELOW = 60.0, 190.0
"""Rows above and below the horizon that are shown of a picture that closes on itself, in px."""

HORIZON_POINTS = 33
"""At so many columns the row of the horizon stands where it is not level, from the left border to the right one."""

LARGEST = 100_000_000
"""Quanta beyond which a number is cut off, so that its differences fit into 32 bits; 100 km in mm."""


def encode_clip(camera: Camera, dt: float, sequence: Sequence, truth: Truth) -> dict[str, Any]:
    """What is published of a sequence, and its truth.

    ``data`` holds, by `series` of second order, x, y, yaw of the observer, x, y of the people where they are known,
    u, v, l of the boxes, and 0 where `sequential` gives a position.
    """

    def columns(coarse: int) -> list[IntArray]:
        poses, positions = _true_quanta(truth, coarse)
        boxes = quantise(sequence.observations, PIXEL * coarse)
        everywhere = [(poses[:, None], always), (positions, known), (boxes, sequence.observed)]
        return [series(values, present, _SMOOTH) for values, present in [*everywhere, (0 * positions[..., :1], given)]]

    known, always = ~np.isnan(truth.positions[..., 0]), np.ones((sequence.frames, 1), bool)
    given = ~np.isnan(sequence.given.positions[..., 0])
    return {
        "sequence": sequence.index,
        "frames": sequence.frames,
        "dt": dt,
        "camera": camera_to_dict(camera),
        "picture": picture_of(camera),
        "tracks": sequence.tracks.tolist(),
        "colours": person_slots(camera, sequence, truth).tolist(),
        "origin": _origin(truth)[:2].tolist(),
        **_packed(columns, CLIP_SIZE),
    }


def picture_of(camera: Camera) -> dict[str, Any]:
    """What the player draws of a camera, whatever its model.

    ``width``, and ``top`` and ``height`` of the rows that are shown, in px; ``round``, whether the picture closes on
    itself; ``horizon``, its rows at columns evenly from border to border; ``view``, the azimuths of left and right
    border in rad clockwise from forward, or None.
    """
    width, height = camera.picture_size
    horizon = camera.horizon(np.linspace(0.0, width, HORIZON_POINTS))
    if np.ptp(horizon) == 0.0:
        horizon = horizon[:2]
    top, bottom = 0.0, float(height)
    if camera.period is not None:
        top, bottom = float(horizon.min()) - ABOVE, float(horizon.max()) + BELOW
    return {
        "width": width,
        "top": top,
        "height": bottom - top,
        "round": camera.period is not None,
        "horizon": np.round(horizon, 2).tolist(),
        "view": camera.view,
    }


def shown_truth(dataset: Dataset, sequence: Sequence) -> Truth:
    """What the player shows as true.

    Where people's places are known from the camera only, that stands at the origin, in the truth as in every estimate.
    """
    if dataset.info.truth != "relative":
        return dataset.truth(sequence)
    poses, places = np.zeros((sequence.frames, 3)), dataset.relative_truth(sequence)
    heights = np.full(len(sequence.tracks), np.nan)
    return Truth(poses=poses, positions=relative_to_world(places, poses), heights=heights)


def shown_estimate(dataset: Dataset, estimate: Estimate) -> Estimate:
    """What the player shows of an answer; see `shown_truth`."""
    if dataset.info.truth != "relative":
        return estimate
    places = world_to_relative(estimate.positions, estimate.poses)
    return Estimate(
        poses=np.full(estimate.poses.shape, np.nan),
        positions=relative_to_world(places, np.zeros(estimate.poses.shape)),
    )


def encode_estimate(truth: Truth, estimate: Estimate, clip_coarse: int) -> dict[str, Any]:
    """A solver's estimate, as its difference from the truth in the clip (from the origin where there is none).

    ``data`` holds, by `series` of the ``order`` that is shortest, x, y, yaw of the observer, then x, y of the people.

    Parameters
    ----------
    clip_coarse : ``coarse`` of the sequence's own file.
    """
    posed = np.isfinite(estimate.poses.sum(axis=-1, keepdims=True))
    placed = np.isfinite(estimate.positions.sum(axis=-1))
    pose_error, error = _errors(truth, estimate, clip_coarse)

    def columns(coarse: int, order: int) -> list[IntArray]:
        poses, positions = _quanta(pose_error, error, coarse)
        return [series(poses[:, None], posed, order), series(positions, placed, order)]

    order = min(_ORDERS, key=lambda one: len(pack(columns(1, one))))
    return {"order": order, **_packed(lambda coarse: columns(coarse, order), ESTIMATE_SIZE)}


def encode_unboxed(truth: Truth, unboxed: Unboxed) -> dict[str, Any]:
    """Who has no box.

    ``data`` holds, by `series` of second order, the reasons, u, v, l of boxes that are not there, and x, y of the
    ``people`` who are in no track, as in the clip.
    """
    there, boxed = np.isfinite(unboxed.positions[..., 0]), np.isfinite(unboxed.boxes[..., 0])

    def columns(coarse: int) -> list[IntArray]:
        boxes = quantise(unboxed.boxes, PIXEL * coarse)
        places = quantise(unboxed.positions - _origin(truth)[:2], METRE * coarse)
        lacking = [(unboxed.reasons[..., None], unboxed.reasons > 0), (boxes, boxed), (places, there)]
        return [series(values, present, _SMOOTH) for values, present in lacking]

    return {"people": unboxed.positions.shape[1], **_packed(columns, UNBOXED_SIZE)}


def _errors(truth: Truth, estimate: Estimate, coarse: int) -> tuple[FloatArray, FloatArray]:
    """The estimate less the truth as the page reads it: [T, 3] and [T, K, 2]."""
    poses, positions = _true_quanta(truth, coarse)
    pose_error = estimate.poses - _origin(truth) - poses * (POSE * coarse)
    pose_error[:, 2] = wrap_angle(pose_error[:, 2])
    return pose_error, estimate.positions - _origin(truth)[:2] - positions * (METRE * coarse)


def _origin(truth: Truth) -> FloatArray:
    """A pose at whole metres near the start, so that places far from a map's origin are small numbers, too."""
    return np.append(np.rint(truth.poses[0, :2]), 0.0)


def _true_quanta(truth: Truth, coarse: int) -> tuple[IntArray, IntArray]:
    return _quanta(truth.poses - _origin(truth), truth.positions - _origin(truth)[:2], coarse)


def _quanta(poses: FloatArray, positions: FloatArray, coarse: int) -> tuple[IntArray, IntArray]:
    return quantise(poses, POSE * coarse), quantise(positions, METRE * coarse)


def _packed(columns: Callable[[int], list[IntArray]], size: int) -> dict[str, Any]:
    """The columns as text, as fine as ``size`` allows."""
    for coarse in COARSE:
        text = pack(columns(coarse))
        if len(text) <= size:
            break
    return {"coarse": coarse, "data": text}


def quantise(values: FloatArray, quantum: float | FloatArray) -> IntArray:
    """Whole multiples of ``quantum`` nearest to the values, cut off at `LARGEST`; NaN becomes 0."""
    steps = np.rint(np.nan_to_num(values / quantum, nan=0.0, posinf=LARGEST, neginf=-LARGEST))
    return np.clip(steps, -LARGEST, LARGEST).astype(np.int64)


def series(values: IntArray, present: BoolArray, order: int) -> IntArray:
    """The [T, K, A] values where they are ``present`` [T, K], as numbers from 1 on, a track after the other.

    Of the first column absent ones are 0, the others lack them. A number is one more than the zig-zag of a
    difference in time. Order 0 leaves values as they are. Order 1 takes from each the one before of the same track, and
    from a track's first value the first of the track before. Order 2 does so once more within a track, from its third
    value on.
    """
    row = values.transpose(1, 0, 2)[present.T].T
    result = row.copy()
    if order > 0:
        rank = np.cumsum(present, axis=0).T[present.T]
        begins, later = np.flatnonzero(rank == 1), np.flatnonzero(rank > 2)
        result[:, 1:] -= row[:, :-1]
        result[:, begins[1:]] = row[:, begins[1:]] - row[:, begins[:-1]]
        if order == 2:
            result[:, later] -= result[:, later - 1]
    result = ((result << 1) ^ (result >> 63)) + 1
    first = np.zeros(present.T.shape, np.int64)
    first[present.T] = result[0]
    return np.concatenate([first.ravel(), result[1:].ravel()])


def pack(columns: Iterable[IntArray]) -> str:
    """Numbers on end, column after column, as base64: the lowest byte of every number, then every second, and so on."""
    numbers = np.concatenate([column.ravel() for column in columns]).astype("<u4")
    coder = zlib.compressobj(9, wbits=-15)
    data = coder.compress(numbers.view(np.uint8).reshape(-1, 4).T.tobytes()) + coder.flush()
    return base64.b64encode(data).decode("ascii")
