"""Where labels go so that none covers another; all lengths in points of the figure."""

import numpy as np
from scipy.optimize import isotonic_regression

from vbbench.geometry import FloatArray

_DIRECTIONS = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)], dtype=np.float64)


def text_extent(texts: list[str], size: float) -> FloatArray:
    """Width and height [N, 2] of digits set in the default font at ``size`` points."""
    return np.array([(0.65 * size * len(text), 0.8 * size) for text in texts]).reshape(-1, 2)


def spread(wanted: FloatArray, gap: float, low: float, high: float) -> FloatArray:
    """Places [N] nearest to ``wanted`` (least squares), in its order, ``gap`` apart and between ``low`` and ``high``.

    Where they do not all fit, the gap shrinks until they do.
    """
    if len(wanted) == 0:
        return wanted
    order = np.argsort(wanted, kind="stable")
    gap = min(gap, (high - low) / max(len(wanted) - 1, 1))
    ramp = gap * np.arange(len(wanted))
    places = np.empty_like(wanted)
    places[order] = np.clip(isotonic_regression(wanted[order] - ramp).x, low, high - ramp[-1]) + ramp
    return places


def beside(points: FloatArray, extents: FloatArray, obstacles: FloatArray, clearance: float) -> FloatArray:
    """Offsets [N, 2] from points [N, 2] to the centres of their labels; NaN where no free place was found.

    Labels are placed in order. Each avoids the labels before it and all obstacles [M, 2].
    """
    offsets = np.full(points.shape, np.nan)
    centres, halves = np.empty((0, 2)), np.empty((0, 2))
    for n, (point, extent) in enumerate(zip(points, extents, strict=True)):
        half = extent / 2.0
        for offset in _DIRECTIONS * (half + clearance):
            centre = point + offset
            free = not _overlap(centre, half, centres, halves) and not _overlap(centre, half, obstacles, clearance / 2)
            if free:
                offsets[n] = offset
                centres, halves = np.vstack([centres, centre]), np.vstack([halves, half])
                break
    return offsets


def _overlap(centre: FloatArray, half: FloatArray, centres: FloatArray, halves: FloatArray | float) -> bool:
    return bool(np.any(np.all(np.abs(centres - centre) < half + halves, axis=-1)))
