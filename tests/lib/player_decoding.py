"""The player's data read back, number by number, as plainly as it can be done."""

import base64
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray

METRE, PIXEL, RADIAN = 1e-3, 0.1, 1e-4


def numbers(text: str) -> Iterator[int]:
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text), wbits=-15), np.uint8)
    yield from planes.reshape(4, -1).T.copy().view("<u4").ravel().tolist()


def decode_clip(values: dict[str, Any]) -> dict[str, Any]:
    stream, shape = numbers(values["data"]), (values["frames"], len(values["tracks"]))
    poses, positions = read_places(stream, shape)
    boxes = np.stack([read_column(stream, shape, PIXEL) for _ in range(3)], axis=-1)
    given = ~np.isnan(read_column(stream, shape, 1.0))
    assert next(stream, None) is None
    found = {"given": given, "poses": poses, "positions": positions, "boxes": boxes}
    return {**found, "known": ~np.isnan(positions[..., 0]), "observed": ~np.isnan(boxes[..., 0])}


def decode_estimate(values: dict[str, Any], clip: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
    stream = numbers(values["data"])
    found = read_places(stream, clip["observed"].shape)
    assert next(stream, None) is None
    return found


def read_places(stream: Iterator[int], shape: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Poses [T, 3] and positions [T, K, 2]."""
    poses = [read_column(stream, (shape[0], 1), quantum) for quantum in (METRE, METRE, RADIAN)]
    positions = [read_column(stream, shape, METRE) for _ in range(2)]
    return np.column_stack(poses), np.stack(positions, axis=-1)


def read_column(stream: Iterator[int], shape: tuple[int, int], quantum: float) -> FloatArray:
    values, last = np.full(shape, np.nan), 0
    for k in range(shape[1]):
        for t in range(shape[0]):
            number = next(stream) - 1
            if number >= 0:
                last += (number >> 1) ^ -(number & 1)
                values[t, k] = last * quantum
    return values
