"""The player's data read back, number by number, as plainly as it can be done."""

import base64
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from vbbench.geometry import BoolArray, FloatArray

METRE, PIXEL, RADIAN = 1e-3, 0.1, 1e-4


def numbers(text: str) -> Iterator[int]:
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text), wbits=-15), np.uint8)
    yield from planes.reshape(4, -1).T.copy().view("<u4").ravel().tolist()


def decode_clip(values: dict[str, Any]) -> dict[str, Any]:
    stream, frames, tracks = numbers(values["data"]), values["frames"], len(values["tracks"])
    pose = read_columns(stream, (frames, 1), 2, 3)
    places = read_columns(stream, (frames, tracks), 2, 2)
    boxes = read_columns(stream, (frames, tracks), 2, 3)
    [given] = read_columns(stream, (frames, tracks), 2, 1)
    assert next(stream, None) is None
    return {
        "known": ~np.isnan(places[0]),
        "observed": ~np.isnan(boxes[0]),
        "given": ~np.isnan(given),
        "poses": np.column_stack(pose) * [METRE, METRE, RADIAN] * values["coarse"],
        "positions": np.stack(places, axis=-1) * METRE * values["coarse"],
        "boxes": np.stack(boxes, axis=-1) * PIXEL * values["coarse"],
    }


def decode_estimate(values: dict[str, Any], clip: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
    stream, (frames, tracks) = numbers(values["data"]), clip["observed"].shape
    poses = np.column_stack(read_columns(stream, (frames, 1), values["order"], 3))
    places = read_columns(stream, (frames, tracks), values["order"], 2)
    assert next(stream, None) is None
    return (
        poses * [METRE, METRE, RADIAN] * values["coarse"] + clip["poses"],
        np.stack(places, axis=-1) * METRE * values["coarse"] + np.nan_to_num(clip["positions"]),
    )


def read_columns(stream: Iterator[int], shape: tuple[int, int], order: int, count: int) -> list[FloatArray]:
    """Columns of which the first says, by noughts, where all of them have no value."""
    found = [read_column(stream, shape, order, None)]
    return found + [read_column(stream, shape, order, ~np.isnan(found[0])) for _ in range(count - 1)]


def read_column(stream: Iterator[int], shape: tuple[int, int], order: int, there: BoolArray | None) -> FloatArray:
    values, first = np.full(shape, np.nan), 0
    for k in range(shape[1]):
        past: list[int] = []
        for t in range(shape[0]):
            number = next(stream) - 1 if there is None or there[t, k] else -1
            if number < 0:
                continue
            read = (number >> 1) ^ -(number & 1)
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
