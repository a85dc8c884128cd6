"""The player's data read back, number by number, as plainly as it can be done."""

import base64
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray

METRE, PIXEL, RADIAN = 1e-3, 0.1, 1e-4


def numbers(text: str) -> Iterator[int]:
    zigzag = shift = 0
    for byte in zlib.decompress(base64.b64decode(text), wbits=-15):
        zigzag |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            yield (zigzag >> 1) ^ -(zigzag & 1)
            zigzag = shift = 0


def decode_clip(values: dict[str, Any]) -> dict[str, Any]:
    stream, shape = numbers(values["data"]), (values["frames"], len(values["tracks"]))
    known, observed, given = (read_flags(stream, shape) for _ in range(3))
    always = np.ones((shape[0], 1), bool)
    pose = [read_column(stream, always, 2) for _ in "xyw"]
    places = [read_column(stream, known, 2) for _ in "xy"]
    boxes = [read_column(stream, observed, 2) for _ in "uvl"]
    assert next(stream, None) is None
    return {
        "known": known,
        "observed": observed,
        "given": given,
        "poses": np.column_stack(pose) * [METRE, METRE, RADIAN] * values["coarse"],
        "positions": np.stack(places, axis=-1) * METRE * values["coarse"],
        "boxes": np.stack(boxes, axis=-1) * PIXEL * values["coarse"],
    }


def decode_estimate(values: dict[str, Any], clip: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
    stream, shape = numbers(values["data"]), clip["observed"].shape
    posed, changed = read_flags(stream, (shape[0], 1)), read_flags(stream, shape)
    poses = np.column_stack([read_column(stream, posed, values["order"]) for _ in "xyw"])
    places = [read_column(stream, clip["observed"] ^ changed, values["order"]) for _ in "xy"]
    assert next(stream, None) is None
    return (
        poses * [METRE, METRE, RADIAN] * values["coarse"] + clip["poses"],
        np.stack(places, axis=-1) * METRE * values["coarse"] + np.nan_to_num(clip["positions"]),
    )


def decode_unboxed(values: dict[str, Any], shape: tuple[int, int]) -> tuple[IntArray, FloatArray, FloatArray]:
    """Reasons [T, K + M], boxes [T, K + M, 3] in px and positions [T, M, 2] in m, relative to the clip's origin."""
    stream, (frames, tracks) = numbers(values["data"]), shape
    told, boxed = (read_flags(stream, (frames, tracks + values["people"])) for _ in range(2))
    reasons = np.nan_to_num(read_column(stream, told, 1)).astype(np.int64)
    boxes = [read_column(stream, boxed, 2) for _ in "uvl"]
    places = [read_column(stream, told[:, tracks:], 2) for _ in "xy"]
    assert next(stream, None) is None
    coarse = values["coarse"]
    return reasons, np.stack(boxes, axis=-1) * PIXEL * coarse, np.stack(places, axis=-1) * METRE * coarse


def read_flags(stream: Iterator[int], shape: tuple[int, int]) -> BoolArray:
    row, lengths = np.zeros(shape[0] * shape[1], bool), [next(stream) for _ in range(next(stream))]
    ends = np.cumsum([0, *lengths])
    for start, stop in zip(ends[1:-1:2], ends[2::2], strict=True):
        row[start:stop] = True
    return row.reshape(shape[::-1]).T


def read_column(stream: Iterator[int], present: BoolArray, order: int) -> FloatArray:
    values, first = np.full(present.shape, np.nan), 0
    for k in range(present.shape[1]):
        past: list[int] = []
        for t in np.flatnonzero(present[:, k]):
            read = next(stream)
            if order == 0:
                value = read
            elif not past:
                value = first = first + read
            elif order == 1 or len(past) == 1:
                value = past[-1] + read
            else:
                value = 2 * past[-1] - past[-2] + read
            past.append(value)
            values[t, k] = value
    return values
