"""Light and air, and the shade at the foot of things, painted into colours; backends cast the sun's shadows."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.drawing import Sky
from vbbench_renderers.surroundings.layout import Plot


def late_morning(sun: FloatArray) -> Sky:
    """A fine day; `sun` [3] points towards the sun."""
    return Sky(
        sun_direction=np.asarray(sun, dtype=np.float32),
        sun_colour=np.array([1.35, 1.20, 0.97], np.float32),
        zenith=np.array([0.13, 0.28, 0.60], np.float32),
        horizon=np.array([0.60, 0.71, 0.84], np.float32),
        ground_glow=np.array([0.24, 0.22, 0.19], np.float32),
        haze_distance=400.0,
    )


def wall_shade(points: FloatArray, plots: tuple[Plot, ...]) -> FloatArray:
    """[N] less light from the sky near the foot of houses: ambient occlusion at ground points [N, 2]."""
    shade = np.ones(len(points))
    for plot in plots:
        rectangle = plot.footprint
        outside = np.maximum(np.maximum(rectangle[:2] - points, points - rectangle[2:]), 0.0)
        shade *= 1.0 - 0.38 * np.exp(-np.linalg.norm(outside, axis=1) / 0.9)
    return np.maximum(shade, 0.35)
