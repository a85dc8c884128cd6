"""The data of the player: a sequence, its truth and a solver's estimate, as short text."""

import base64
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from vbbench.camera import Camera
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray, relative_to_world, world_to_relative
from vbbench.pictures.people_colours import person_slots
from vbbench.sequence import Sequence, Truth

METRE, RADIAN, PIXEL = 1e-3, 1e-4, 0.1
"""To which places (m), headings (rad) and boxes (px) are rounded."""

ABOVE, BELOW = 60.0, 190.0
"""Rows above and below the horizon that are shown of a picture that closes on itself, in px."""

HORIZON_POINTS = 33
"""At so many columns the row of the horizon stands where it is not level, from the left border to the right one."""

LARGEST = 100_000_000
"""Quanta beyond which a number is cut off, so that its changes fit into 32 bits; 100 km in mm."""


def encode_clip(camera: Camera, dt: float, sequence: Sequence, truth: Truth) -> dict[str, Any]:
    """What is published of a sequence, and its truth.

    ``data`` holds, as `pack` has it, x, y, yaw of the observer, x, y of the people where they are known, u, v, l of the
    boxes, and a number where `sequential` gives a position.
    """
    given = sequence.given.positions[..., 0]
    boxes = [pack(column, PIXEL) for column in np.moveaxis(sequence.observations, -1, 0)]
    columns = [*_places(truth.poses, truth.positions, truth), *boxes, pack(0.0 * given, 1.0)]
    return {
        "frames": sequence.frames,
        "dt": dt,
        "picture": picture_of(camera),
        "tracks": sequence.tracks.tolist(),
        "colours": person_slots(camera, sequence, truth).tolist(),
        "origin": _origin(truth).tolist(),
        "data": as_text(columns),
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


def encode_estimate(truth: Truth, estimate: Estimate) -> dict[str, Any]:
    """A solver's estimate: ``data`` holds x, y, yaw of the observer, then x, y of the people, as in `encode_clip`."""
    return {"data": as_text([*_places(estimate.poses, estimate.positions, truth)])}


def _places(poses: FloatArray, positions: FloatArray, truth: Truth) -> Iterator[IntArray]:
    origin = _origin(truth)
    for axis in (0, 1):
        yield pack(poses[:, None, axis] - origin[axis], METRE)
    yield pack(poses[:, None, 2], RADIAN)
    for axis in (0, 1):
        yield pack(positions[..., axis] - origin[axis], METRE)


def _origin(truth: Truth) -> FloatArray:
    """A place [2] at whole metres near the start, so that places far from a map's origin are small numbers, too."""
    return np.rint(truth.poses[0, :2])


def pack(values: FloatArray, quantum: float) -> IntArray:
    """Numbers [K * T] of the values [T, K], track after track: 0 where there is none that is finite.

    Elsewhere a number is one more than the zig-zag of the change since the last one, in quanta.
    """
    there = np.isfinite(values.T)
    steps = np.clip(np.rint(values.T[there] / quantum), -LARGEST, LARGEST).astype(np.int64)
    changes, numbers = np.diff(steps, prepend=0), np.zeros(there.shape, np.int64)
    numbers[there] = ((changes << 1) ^ (changes >> 63)) + 1
    return numbers.ravel()


def as_text(columns: list[IntArray]) -> str:
    """Numbers on end, column after column, as base64: the lowest byte of every number, then every second, and so on."""
    numbers = np.concatenate(columns).astype("<u4")
    coder = zlib.compressobj(9, wbits=-15)
    data = coder.compress(numbers.view(np.uint8).reshape(-1, 4).T.tobytes()) + coder.flush()
    return base64.b64encode(data).decode("ascii")
