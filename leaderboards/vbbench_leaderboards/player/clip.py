"""A sequence, and what a solver says of it, as the page's player gets them.

Millimetres, tenths of a pixel and tenths of a milliradian, counted from a whole metre near the observer's start.
"""

from typing import Any

import numpy as np

from vbbench.arrays import BoolArray, FloatArray, IntArray
from vbbench.camera import Camera, camera_to_dict
from vbbench.estimate import Estimate
from vbbench.geometry import wrap_angle
from vbbench.sequence import Sequence, Truth
from vbbench_leaderboards.player.coding import differences, flags, pack, quantise

METRE, PIXEL, RADIAN = 1e-3, 0.1, 1e-4
"""Quanta of lengths (m), of boxes (px) and of angles (rad)."""

_SMOOTH = 2
"""People and boxes move evenly: their second differences are small."""

_ORDERS = (0, 1, 2)


def encode_clip(camera: Camera, dt: float, sequence: Sequence, truth: Truth) -> dict[str, Any]:
    """What is published of a sequence, and its truth.

    ``data`` holds, by `flags`: where the truth is known, who is observed, which positions `sequential` gives; then by
    `differences` of second order x, y, yaw of the observer, x, y of the people, u, v, l of the boxes.
    """
    known, observed = ~np.isnan(truth.positions[..., 0]), sequence.observed
    origin = _origin(truth)
    poses, positions = _path_quanta(truth.poses, truth.positions, origin)
    boxes = quantise(sequence.observations, PIXEL)
    always = np.ones((sequence.frames, 1), bool)
    columns = [flags(known), flags(observed), flags(~np.isnan(sequence.given.positions[..., 0]))]
    columns += _columns(poses[:, None], always, _SMOOTH)
    columns += _columns(positions, known, _SMOOTH) + _columns(boxes, observed, _SMOOTH)
    return {
        "sequence": sequence.index,
        "frames": sequence.frames,
        "first_frame": sequence.first_frame,
        "observer": sequence.observer,
        "dt": dt,
        "camera": camera_to_dict(camera),
        "tracks": sequence.tracks.tolist(),
        "origin": origin.tolist(),
        "data": pack(columns),
    }


def encode_estimate(sequence: Sequence, truth: Truth, estimate: Estimate) -> dict[str, Any]:
    """What a solver says, as its difference from the truth (from the origin where there is none).

    ``data`` holds by `flags` in which frames there is a pose, and where there is a position but no box or the other
    way round; then by `differences` of the ``order`` that is shortest x, y, yaw of the observer, x, y of the people.
    """
    posed = np.isfinite(estimate.poses.sum(axis=-1, keepdims=True))
    placed = np.isfinite(estimate.positions.sum(axis=-1))
    turned = truth.poses[:, 2] + wrap_angle(estimate.poses[:, 2] - truth.poses[:, 2])
    poses = np.column_stack([estimate.poses[:, :2], turned])
    own = _path_quanta(poses, estimate.positions, _origin(truth))
    true = _path_quanta(truth.poses, truth.positions, _origin(truth))
    candidates = [
        _columns((own[0] - true[0])[:, None], posed, order) + _columns(own[1] - true[1], placed, order)
        for order in _ORDERS
    ]
    order = int(np.argmin([_bits(columns) for columns in candidates]))
    masks = [flags(posed), flags(placed ^ sequence.observed)]
    return {"order": _ORDERS[order], "data": pack([*masks, *candidates[order]])}


def _origin(truth: Truth) -> FloatArray:
    """Whole metres near the start, so that places far from a map's origin are small numbers, too."""
    return np.rint(truth.poses[0, :2])


def _path_quanta(poses: FloatArray, positions: FloatArray, origin: FloatArray) -> tuple[IntArray, IntArray]:
    places = quantise(poses[:, :2] - origin, METRE)
    return np.column_stack([places, quantise(poses[:, 2], RADIAN)]), quantise(positions - origin, METRE)


def _columns(values: IntArray, present: BoolArray, order: int) -> list[IntArray]:
    return [differences(values[..., axis], present, order) for axis in range(values.shape[-1])]


def _bits(columns: list[IntArray]) -> float:
    """About how many bits the numbers need."""
    return float(sum(np.log2(1.0 + 2.0 * np.abs(column)).sum() for column in columns))
