"""Which part of a picture that closes on itself is worth showing: the columns where people are.

Columns count on beyond the seam: with a turn of ``period`` px, column ``period`` + 10 is column 10 again.
"""

import numpy as np

from vbbench.geometry import FloatArray

_MARGIN = 0.03  # of a turn, on both sides of the people
_LEAST = 0.4  # of a turn: nearer than that nothing is gained, and left and right are forgotten
_MOST = 0.85  # of a turn, from which on all of it is shown


def window(left: FloatArray, width: FloatArray, period: float) -> tuple[float, float]:
    """The narrowest columns (low, high) that hold all boxes with left sides [N] and widths [N] in px.

    All of the turn, (0, period), where that omits little. ``low`` is in [0, period), ``high`` may be beyond it.
    """
    if not len(left):
        return 0.0, period
    order = np.argsort(np.mod(left, period), kind="stable")
    begin = np.mod(left, period)[order]
    end = begin + width[order]
    reach = np.maximum(np.maximum.accumulate(end), end.max() - period)
    gaps = np.append(begin[1:], begin[0] + period) - reach
    widest = int(gaps.argmax())
    seen = period - float(gaps[widest]) + 2.0 * _MARGIN * period
    if seen > _MOST * period:
        return 0.0, period
    middle = float(reach[widest] + gaps[widest]) - _MARGIN * period + 0.5 * seen
    seen = max(seen, _LEAST * period)
    low = float(np.mod(middle - 0.5 * seen, period))
    low = 0.0 if low >= period else low
    return low, low + seen


def unrolled(columns: FloatArray, low: float, period: float) -> FloatArray:
    """The same columns [...] within the turn that begins at ``low``."""
    return low + np.mod(columns - low, period)


def column_ticks(low: float, high: float, period: float, step: float) -> list[float]:
    """Where a window has ticks: at every multiple of ``step`` px and at the seam, except where two would touch."""
    marks = np.append(np.arange(0.0, period, step), period)
    if period - marks[-2] < 0.5 * step:
        marks = np.delete(marks, -2)
    every = np.unique(np.concatenate([marks, marks + period]))
    return [float(mark) for mark in every if low - 1e-9 <= mark <= high + 1e-9]
