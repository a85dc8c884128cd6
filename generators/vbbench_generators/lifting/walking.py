"""How fast a lifted crowd walks: the check of its scale."""

import numpy as np

from vbbench_generators.lifting.camera import GroundCamera
from vbbench_generators.lifting.segments import cut_segments
from vbbench_generators.lifting.tracks import Heads

_SLOWEST = 0.3
"""Who is slower than this share of the upper quartile stands."""


def walking_speed(heads: Heads, camera: GroundCamera, window: float) -> float | None:
    """Median speed of walkers in m/s, from windows of ``window`` s; ``None`` if there are no such windows."""
    segments = cut_segments(heads.x, heads.nu, heads.frame, heads.track, dt=heads.dt, window=window)
    if not len(segments):
        return None
    way = camera.to_ground(*segments.end.T) - camera.to_ground(*segments.begin.T)
    speed = np.hypot(way[:, 0], way[:, 1]) / segments.duration
    median = float(np.median(speed[speed >= _SLOWEST * np.quantile(speed, 0.75)]))
    return median if median > 0.0 else None
