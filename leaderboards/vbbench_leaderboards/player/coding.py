"""Whole numbers as short text: differences, zig-zag, bytes of seven bits, deflated, base64.

The page's ``assets/data.js`` reads what is written here; tests hold the two against one another.
"""

import base64
import zlib
from collections.abc import Iterable

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray

LARGEST = 100_000_000
"""Quanta beyond which a number is cut off, so that the page can count in 32 bits; 100 km in mm."""

_MOST_BYTES = 5
_LEVEL = 9


def quantise(values: FloatArray, quantum: float | FloatArray) -> IntArray:
    """Whole multiples of ``quantum`` nearest to the values, cut off at `LARGEST`; NaN becomes 0."""
    steps = np.rint(np.nan_to_num(values / quantum, nan=0.0, posinf=LARGEST, neginf=-LARGEST))
    return np.clip(steps, -LARGEST, LARGEST).astype(np.int64)


def differences(values: IntArray, present: BoolArray, order: int) -> IntArray:
    """The [T, K, A] values where they are ``present`` [T, K], as [A, N] differences in time, a track after the other.

    Order 0 leaves them as they are. Order 1 takes from each value the one before of the same track, and from a track's
    first value the first of the track before. Order 2 does so once more within a track, from its third value on.
    """
    row = values.transpose(1, 0, 2)[present.T].T
    if order == 0:
        return row
    rank = np.cumsum(present, axis=0).T[present.T]
    begins = np.flatnonzero(rank == 1)
    result = row.copy()
    result[:, 1:] -= row[:, :-1]
    result[:, begins[1:]] = row[:, begins[1:]] - row[:, begins[:-1]]
    if order == 2:
        later = np.flatnonzero(rank > 2)
        result[:, later] -= result[:, later - 1]
    return result


def flags(mask: BoolArray) -> IntArray:
    """[T, K] flags as the lengths of runs, a track after the other, unset ones first; their number stands before."""
    row = np.concatenate([[False], mask.T.ravel(), [False]])
    changes = np.flatnonzero(row[1:] != row[:-1])
    return np.append(len(changes), np.diff(changes, prepend=0))


def pack(columns: Iterable[IntArray]) -> str:
    """Whole numbers on end, column after column, as base64."""
    coder = zlib.compressobj(_LEVEL, wbits=-15)
    data = coder.compress(_varints(np.concatenate([column.ravel() for column in columns]))) + coder.flush()
    return base64.b64encode(data).decode("ascii")


def _varints(numbers: IntArray) -> bytes:
    """Zig-zag numbers as bytes of seven bits, low ones first, the top bit set where more follow."""
    zigzag = (numbers << 1) ^ (numbers >> 63)
    limbs = (zigzag[:, None] >> np.arange(0, 7 * _MOST_BYTES, 7)) & 127
    follows = zigzag[:, None] >= 1 << np.arange(7, 7 * (_MOST_BYTES + 1), 7)
    kept = np.column_stack([np.ones(len(numbers), bool), follows[:, :-1]])
    data: bytes = (limbs | 128 * follows).astype(np.uint8)[kept].tobytes()
    return data
