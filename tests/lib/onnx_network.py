"""Writes small ONNX networks by hand: protobuf messages of a few fields, no package needed."""

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

FLOAT, UINT8, INT64, HALF = 1, 2, 7, 10
"""Types of tensors in onnx.proto3."""


def _varint(value: int) -> bytes:
    found, value = b"", value % 2**64  # negative numbers are those of two's complement
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
    array = np.asarray(values, {FLOAT: "<f4", INT64: "<i8", HALF: "<f2"}[kind])
    dims = b"".join(_field(1, size) for size in array.shape)
    return dims + _field(2, kind) + _field(8, name) + _field(9, array.tobytes())


def _node(kind: str, inputs: Sequence[str], output: str) -> bytes:
    return b"".join(_field(1, name) for name in inputs) + _field(2, output) + _field(4, kind)


def _cast(given: str, output: str) -> bytes:
    """A node that makes float32 of numbers."""
    return _node("Cast", [given], output) + _field(5, _field(1, "to") + _field(3, FLOAT) + _field(20, 2))


def _value(name: str, shape: Sequence[int | str], kind: int = FLOAT) -> bytes:
    dims = b"".join(_field(1, _field(1, size) if isinstance(size, int) else _field(2, size)) for size in shape)
    return _field(1, name) + _field(2, _field(1, _field(1, kind) + _field(2, dims)))


def write_network(
    path: Path,
    constant: ArrayLike | dict[str, ArrayLike],
    slope: ArrayLike | None = None,
    side: int | str = 64,
    names: dict[int, str] | None = None,
    shape: Sequence[int | str] | None = None,
    metadata: dict[str, str] | None = None,
    kind: int = FLOAT,
    more_inputs: Sequence[str] = (),
) -> Path:
    """A network whose output is ``constant`` [1, A, B] + ``slope`` [1, A, B, 3] times the mean colour of its input.

    Several outputs are given by their names. It takes pictures [1, 3, side, side] of numbers of ``kind``, or has an
    input of ``shape`` in its header; ``more_inputs`` [1, 2] of int64 are not used.
    """
    outputs = {name: np.asarray(one, np.float32) for name, one in _outputs(constant).items()}
    number = HALF if kind == HALF else FLOAT
    nodes, tensors = [_node("GlobalAveragePool", ["floats" if kind == UINT8 else "images"], "mean")], []
    if kind == UINT8:
        nodes.insert(0, _cast("images", "floats"))
    for name, bias in outputs.items():
        weights = np.zeros((bias.size, 3)) if slope is None else np.asarray(slope).reshape(bias.size, 3)
        nodes += [_node("Conv", ["mean", f"{name}_weights", f"{name}_bias"], f"{name}_all")]
        nodes += [_node("Reshape", [f"{name}_all", f"{name}_shape"], name)]
        tensors += [_tensor(f"{name}_weights", weights.reshape(bias.size, 3, 1, 1), number)]
        tensors += [_tensor(f"{name}_bias", bias.reshape(-1), number), _tensor(f"{name}_shape", bias.shape, INT64)]
    graph = b"".join(_field(1, node) for node in nodes) + _field(2, "made")
    graph += b"".join(_field(5, tensor) for tensor in tensors)
    graph += _field(11, _value("images", shape or (1, 3, side, side), kind))
    graph += b"".join(_field(11, _value(name, (1, 2), INT64)) for name in more_inputs)
    graph += b"".join(_field(12, _value(name, bias.shape, number)) for name, bias in outputs.items())
    model = _field(1, 8) + _field(7, graph) + _field(8, _field(1, "") + _field(2, 12))
    model += struct.pack("<Bf", 15 << 3 | 5, 1.0)  # a field that nobody knows
    known = {"names": repr(names)} if names is not None else {}
    for name, text in {**known, **(metadata or {})}.items():
        model += _field(14, _field(1, name) + _field(2, text))
    path.write_bytes(model)
    return path


def _outputs(constant: ArrayLike | dict[str, ArrayLike]) -> dict[str, ArrayLike]:
    return constant if isinstance(constant, dict) else {"output0": constant}
