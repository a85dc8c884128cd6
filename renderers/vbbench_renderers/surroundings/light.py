"""Light and air, and the shade that houses throw on the ground, which is painted into its colours."""

import numpy as np

from vbbench.arrays import FloatArray
from vbbench_renderers.drawing import Sky
from vbbench_renderers.surroundings.layout import Plot

IN_SHADE = np.array([0.46, 0.51, 0.58])
"""Light that is left where the sun does not reach, of what is there where it does, linear RGB."""


def late_morning(sun: FloatArray) -> Sky:
    """A fine day; `sun` [3] points towards the sun."""
    return Sky(
        sun_direction=np.asarray(sun, dtype=np.float32),
        sun_colour=np.array([1.02, 0.92, 0.76], np.float32),
        zenith=np.array([0.17, 0.33, 0.66], np.float32),
        horizon=np.array([0.66, 0.76, 0.88], np.float32),
        ground_glow=np.array([0.20, 0.185, 0.165], np.float32),
        haze_distance=260.0,
    )


def wall_shade(points: FloatArray, plots: tuple[Plot, ...]) -> FloatArray:
    """[N] less light from the sky near the foot of houses: ambient occlusion at ground points [N, 2]."""
    shade = np.ones(len(points))
    for plot in plots:
        rectangle = plot.footprint
        outside = np.maximum(np.maximum(rectangle[:2] - points, points - rectangle[2:]), 0.0)
        shade *= 1.0 - 0.38 * np.exp(-np.linalg.norm(outside, axis=1) / 0.9)
    return np.maximum(shade, 0.35)


def sunlit(points: FloatArray, plots: tuple[Plot, ...], sun: FloatArray) -> FloatArray:
    """[N] part of the sun's disc, widened to make the edges soft, that shines on ground points [N, 2]."""
    azimuth, level = np.arctan2(sun[1], sun[0]), np.hypot(sun[0], sun[1])
    turns = np.radians([-4.0, -2.0, 0.0, 2.0, 4.0])
    shares = [_unblocked(points, plots, np.array([np.cos(azimuth + t), np.sin(azimuth + t)]), sun[2] / level)
              for t in turns]  # fmt: skip
    return np.asarray(np.mean(shares, axis=0))


def _unblocked(points: FloatArray, plots: tuple[Plot, ...], towards: FloatArray, slope: float) -> FloatArray:
    free = np.ones(len(points))
    for plot in plots:
        rectangle = plot.footprint
        first, second = (rectangle[:2] - points) / towards, (rectangle[2:] - points) / towards
        enter = np.minimum(first, second).max(axis=1)
        leave = np.maximum(first, second).min(axis=1)
        over = slope * np.maximum(enter, 0.0) - plot.height
        hit = (enter < leave) & (leave > 0.0)
        free = np.where(hit, np.minimum(free, np.clip(0.5 + over / 1.0, 0.0, 1.0)), free)
    return free
