"""The header of an ONNX file: the size of the pictures that it takes, and the names of its classes.

ONNX is a protobuf message. Only the few fields that are needed are read, by their numbers in onnx.proto3; the weights
are skipped.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vbbench.errors import FileError

_GRAPH, _METADATA = 7, 14
"""Fields of ModelProto."""
_INITIALIZER, _INPUT = 5, 11
"""Fields of GraphProto."""
_TENSOR_NAME = 8
_IR_VERSION = b"\x08"
"""The first byte of every ONNX file: the key of ModelProto's first field."""
_VARINT, _EIGHT_BYTES, _LENGTH, _FOUR_BYTES = 0, 1, 2, 5


@dataclass(frozen=True, kw_only=True)
class OnnxHeader:
    """The inputs of a network, and its metadata.

    Parameters
    ----------
    inputs : names of the inputs.
    shape : of the first input; ``None`` for a dimension that may be anything.
    number_type : of the first input's numbers, as onnx.proto3 numbers them: 1 float32, 2 uint8, 10 float16.
    metadata : such as ``names``, the classes.
    """

    inputs: tuple[str, ...]
    shape: tuple[int | None, ...]
    number_type: int
    metadata: dict[str, str]

    def class_names(self) -> dict[int, str]:
        """The names of the classes by number, as Ultralytics' exporter writes them; none if there are none."""
        try:
            return {int(number): str(name) for number, name in dict(self.value("names")).items()}
        except (ValueError, TypeError):
            return {}

    def value(self, name: str) -> Any:
        """An entry of the metadata that is written as Python has it; ``None`` if there is none."""
        try:
            return ast.literal_eval(self.metadata.get(name, "None"))
        except (ValueError, TypeError, SyntaxError, RecursionError, MemoryError):
            return None


def read_onnx_header(path: Path) -> OnnxHeader:
    """Read the header of an ONNX file.

    Raises
    ------
    FileError
        If the file is missing or is none.
    """
    try:
        model = memoryview(path.read_bytes())
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror}); name an ONNX file") from None
    try:
        fields = list(_fields(model))
        graph = list(_fields(next(value for number, value in fields if number == _GRAPH)))
        weights = {_text(one, _TENSOR_NAME) for number, one in graph if number == _INITIALIZER}
        inputs = [one for number, one in graph if number == _INPUT and _text(one, 1) not in weights]
        shape = tuple(_dimension(one) for one in _path(inputs[0], 2, 1, 2, 1))
        number_type = _varint(_path(inputs[0], 2, 1, 1)[0], 0)[0]
        metadata = {_text(one, 1): _text(one, 2) for number, one in fields if number == _METADATA}
    except (IndexError, StopIteration, ValueError) as error:
        if model[:1] == _IR_VERSION:
            raise FileError(path, "is an ONNX file that is damaged or ends early; copy or export it again") from error
        raise FileError(path, "is not an ONNX network; export yours with format=onnx") from error
    names = tuple(_text(one, 1) for one in inputs)
    return OnnxHeader(inputs=names, shape=shape, number_type=number_type, metadata=metadata)


def _fields(message: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Number and bytes of every field of a message; those of a varint are its own."""
    place = 0
    while place < len(message):
        key, place = _varint(message, place)
        kind, start = key & 7, place
        if kind == _VARINT:
            _, place = _varint(message, place)
        elif kind == _LENGTH:
            size, start = _varint(message, place)
            place = start + size
        elif kind in (_EIGHT_BYTES, _FOUR_BYTES):
            place += 8 if kind == _EIGHT_BYTES else 4
        else:
            raise ValueError(f"field of kind {kind}")
        if place > len(message):
            raise ValueError("cut short")
        yield key >> 3, message[start:place]


def _varint(message: memoryview, place: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = message[place]
        value |= (byte & 0x7F) << shift
        place, shift = place + 1, shift + 7
        if byte < 0x80:
            return value, place


def _path(message: memoryview, *numbers: int) -> list[memoryview]:
    """All messages that a path of field numbers leads to."""
    found = [message]
    for number in numbers:
        found = [value for one in found for field, value in _fields(one) if field == number]
    return found


def _text(message: memoryview, number: int) -> str:
    """A field that is text; empty if it is missing."""
    found = _path(message, number)
    return bytes(found[0]).decode("utf-8") if found else ""


def _dimension(message: memoryview) -> int | None:
    """A dimension; ``None`` if it has only a name, or is not positive."""
    found = _path(message, 1)
    size = _varint(found[0], 0)[0] if found else 0
    return size if 0 < size < 2**31 else None
