"""Writes small ONNX networks by hand: protobuf messages of a few fields, no package needed."""

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

FLOAT, INT64 = 1, 7
"""Types of tensors in onnx.proto3."""


def _varint(value: int) -> bytes:
    found = b""
    while value >= 0x80:
        found += bytes([value & 0x7F | 0x80])
        value >>= 7
    return found + bytes([value])


def _field(number: int, value: bytes | str | int) -> bytes:
    if isinstance(value, int):
        return _varint(number << 3) + _varint(value)
    data = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | 2) + _varint(len(data)) + data


def _tensor(name: str, values: ArrayLike, kind: int = FLOAT) -> bytes:
    array = np.asarray(values, "<f4" if kind == FLOAT else "<i8")
    dims = b"".join(_field(1, size) for size in array.shape)
    return dims + _field(2, kind) + _field(8, name) + _field(9, array.tobytes())


def _node(kind: str, inputs: Sequence[str], output: str) -> bytes:
    return b"".join(_field(1, name) for name in inputs) + _field(2, output) + _field(4, kind)


def _value(name: str, shape: Sequence[int | str]) -> bytes:
    dims = b"".join(_field(1, _field(1, size) if isinstance(size, int) else _field(2, size)) for size in shape)
    return _field(1, name) + _field(2, _field(1, _field(1, FLOAT) + _field(2, dims)))


def write_network(
    path: Path,
    constant: ArrayLike,
    slope: ArrayLike | None = None,
    side: int | str = 64,
    names: dict[int, str] | None = None,
    shape: Sequence[int | str] | None = None,
) -> Path:
    """A network whose output is ``constant`` [1, A, B] + ``slope`` [1, A, B, 3] times the mean colour (RGB, 0 to 1).

    It takes pictures [1, 3, side, side]; or says that it takes ``shape``.
    """
    bias = np.asarray(constant, np.float32)
    weights = np.zeros((bias.size, 3)) if slope is None else np.asarray(slope).reshape(bias.size, 3)
    nodes = [
        _node("GlobalAveragePool", ["images"], "mean"),
        _node("Conv", ["mean", "weights", "bias"], "all"),
        _node("Reshape", ["all", "shape"], "output0"),
    ]
    tensors = [
        _tensor("weights", weights.reshape(bias.size, 3, 1, 1)),
        _tensor("bias", bias.reshape(-1)),
        _tensor("shape", bias.shape, INT64),
    ]
    graph = b"".join(_field(1, node) for node in nodes) + _field(2, "made")
    graph += b"".join(_field(5, tensor) for tensor in tensors)
    graph += _field(11, _value("images", shape or (1, 3, side, side))) + _field(12, _value("output0", bias.shape))
    model = _field(1, 8) + _field(7, graph) + _field(8, _field(1, "") + _field(2, 12))
    model += struct.pack("<Bf", 15 << 3 | 5, 1.0)  # a field that nobody knows
    if names is not None:
        model += _field(14, _field(1, "names") + _field(2, repr(names)))
    path.write_bytes(model)
    return path
