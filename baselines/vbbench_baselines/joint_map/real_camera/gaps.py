"""Places of people in frames that do not show them, for a first guess."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.real_camera.joint import Seen


@kernel
def fill(places: FloatArray, frames: FloatArray, seen: Seen, numbers: FloatArray) -> None:
    """Where people may be whose places [T, K, 2] are not known yet: as they walked, or as high as their box says."""
    boxes = seen.boxes
    for k in range(places.shape[1]):
        known, first = -1, int(seen.first[k])
        for t in range(first, seen.last[k] + 1):
            if np.isnan(places[t, k, 0]):
                if not np.isnan(seen.given[t, k, 0]):
                    places[t, k, 0], places[t, k, 1] = seen.given[t, k, 0], seen.given[t, k, 1]
                elif t - 2 >= first and not np.isnan(places[t - 1, k, 0] + places[t - 2, k, 0]):
                    places[t, k, 0] = 2.0 * places[t - 1, k, 0] - places[t - 2, k, 0]
                    places[t, k, 1] = 2.0 * places[t - 1, k, 1] - places[t - 2, k, 1]
                elif not np.isnan(boxes.azimuth[t, k]):
                    reach = np.exp(numbers[k, 0]) / boxes.length[t, k] + numbers[k, 1]
                    side, ahead = reach * np.sin(boxes.azimuth[t, k]), reach * np.cos(boxes.azimuth[t, k])
                    sin, cos = np.sin(frames[t, 2]), np.cos(frames[t, 2])
                    places[t, k, 0] = frames[t, 0] + side * sin + ahead * cos
                    places[t, k, 1] = frames[t, 1] - side * cos + ahead * sin
            if not np.isnan(places[t, k, 0]):
                if known >= 0:
                    _bridge(places, k, known, t)
                known = t


@kernel
def _bridge(places: FloatArray, k: int, known: int, t: int) -> None:
    """Fill in the places [T, K, 2] of person ``k`` between two frames, straight from one to the other."""
    for missing in range(known + 1, t):
        share = (missing - known) / (t - known)
        for a in range(2):
            places[missing, k, a] = (1.0 - share) * places[known, k, a] + share * places[t, k, a]
