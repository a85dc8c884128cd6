"""Columns of numbers as text that is small: the compressed blocks of result files and dataset records.

A block is a JSON object: ``columns`` (names), ``rows`` (how many), ``encoding`` (how to read it) and ``data``.
"""

import base64
import binascii
import hashlib
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError
from vbbench.geometry import FloatArray, IntArray

ENCODING = (
    "base64 of zlib of little-endian float32, column after column, NaN = none; "
    "first the lowest byte of every number, then every second, third and highest byte"
)

_WIDTH = 4
_LARGEST = 1 << 28
"""Bytes that a block may unfold to: no board is larger, and a small file must not fill the memory."""

_LARGEST_COUNT = 10**9
"""The largest number of anything that the schemas know."""

Block = dict[str, Any]


def encode(columns: Mapping[str, Any]) -> Block:
    """The block of columns [N]; numbers are rounded to float32."""
    table = np.array(list(columns.values()), dtype="<f4")
    planes = np.frombuffer(table.tobytes(), np.uint8).reshape(-1, _WIDTH).T
    data = base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    return {"columns": list(columns), "rows": table.shape[1], "encoding": ENCODING, "data": data}


def decode(block: Block) -> dict[str, FloatArray]:
    """Columns by name, as `encode` took them.

    Raises
    ------
    ValueError
        If the data is damaged, or does not hold as many numbers as it says.
    """
    table = np.frombuffer(_planes(block), np.uint8).reshape(_WIDTH, -1).T.copy().view("<f4")
    columns = table.reshape(len(block["columns"]), block["rows"]).astype(np.float64)
    return dict(zip(block["columns"], columns, strict=True))


def whole_columns(
    columns: Mapping[str, FloatArray], names: Iterable[str], path: Path, place: str
) -> dict[str, IntArray]:
    """The columns of those names as whole numbers.

    Raises
    ------
    FileError
        If one holds anything but whole numbers from 0 on; ``place`` says where in the file ``path`` they stand.
    """
    for name in names:
        values = columns[name]
        if not ((values >= 0) & (values == np.floor(values)) & (values <= _LARGEST_COUNT)).all():
            raise FileError(path, f"{place}: {name} must be whole numbers, from 0 to {_LARGEST_COUNT}")
    return {name: columns[name].astype(np.int64) for name in names}


def fingerprint(block: Block) -> Block:
    """The block with the SHA-256 of its unfolded bytes for its data: the same with any version of zlib."""
    return {**block, "data": hashlib.sha256(_planes(block)).hexdigest()}


def _planes(block: Block) -> bytes:
    size = len(block["columns"]) * block["rows"] * _WIDTH
    if size > _LARGEST:
        raise ValueError(f"{block['rows']} rows are more than any board has")
    try:
        unfold = zlib.decompressobj()
        planes = unfold.decompress(base64.b64decode(block["data"], validate=True), size + 1)
    except (binascii.Error, zlib.error) as error:
        raise ValueError(f"is damaged ({error})") from error
    if len(planes) != size or not unfold.eof or unfold.unused_data:
        raise ValueError(f"does not hold {len(block['columns'])} columns of {block['rows']} numbers")
    return planes
