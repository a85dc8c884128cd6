"""The data of the player: a sequence, its truth and a solver's estimate, as short text."""

import base64
import zlib
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from vbbench.camera import Camera, camera_to_dict
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.geometry import (
    BoolArray,
    FloatArray,
    IntArray,
    relative_to_world,
    world_to_relative,
    wrap_angle,
)
from vbbench.pictures.people_colours import person_slots
from vbbench.sequence import Sequence, Truth

POSE, METRE, PIXEL = np.array([1e-3, 1e-3, 1e-4]), 1e-3, 0.1
"""Quanta of poses (m, m, rad), of places (m) and of boxes (px)."""

COARSE = (1, 2, 5, 10)
"""How many quanta are taken at a time: the fewest with which a file keeps to its size."""

CLIP_SIZE, ESTIMATE_SIZE = 21_000, 12_000
"""Bytes of text for a sequence and for a solver: with three solvers under 60 kB."""

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

    Where people's places are known relative to the camera only, the camera stands at the origin of truth and estimates.
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
