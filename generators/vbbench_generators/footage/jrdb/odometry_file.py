"""The robot's way as JSON, by its wheels: ``{"odometry": {"000000.pcd": {"position": …, "orientation": …}}}``."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.geometry import FloatArray
from vbbench_generators.footage.jrdb.labels import frame_of, read_frames
from vbbench_generators.footage.jrdb.stamps import Stamps

_LONGEST, _LEVEL = 1e5, 0.2
"""m that a robot may be from where its odometry began, and rad by which it may be off the level (median)."""


def read_odometry_file(path: Path, clouds: Stamps) -> tuple[FloatArray, FloatArray]:
    """Times [N] in s and poses [N, 3] (x, y, yaw) in m and rad, x forward and y left of the robot at yaw 0.

    Parameters
    ----------
    path : the file: a position x, y, z and an orientation x, y, z, w for each point cloud.
    clouds : when the point clouds were taken.

    Raises
    ------
    FileError
        If it is no such file, an orientation is no rotation, or the robot lies on its side.
    """
    rows = {frame_of(path, name, ".pcd", "odometry"): _pose(path, name, one) for name, one in _entries(path)}
    kept = [row for row, frame in enumerate(clouds.frames.tolist()) if frame in rows]
    if len(kept) < 2:
        raise FileError(path, f"has poses of {len(kept)} of the point clouds in {clouds.path.name}; two are wanted")
    table = np.array([rows[int(clouds.frames[row])] for row in kept])
    x, y, z, w = (table[:, 3:] / np.linalg.norm(table[:, 3:], axis=1, keepdims=True)).T
    upright = 1.0 - 2.0 * (x * x + y * y)
    if float(np.median(upright)) < math.cos(_LEVEL):
        raise FileError(path, "the robot is not upright: positions and orientations must have z upwards, w last")
    yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    return clouds.times[kept], np.column_stack([table[:, :2], yaw])


def _entries(path: Path) -> list[tuple[str, Any]]:
    return sorted(read_frames(path, "odometry", "poses").items())


def _pose(path: Path, name: str, entry: Any) -> list[float]:
    """x, y, z of the position, and x, y, z, w of the orientation."""
    numbers = []
    for key, axes in (("position", "xyz"), ("orientation", "xyzw")):
        values = entry.get(key) if isinstance(entry, dict) else None
        found = [values.get(axis) for axis in axes] if isinstance(values, dict) else []
        usable = [one for one in found if isinstance(one, (int, float)) and not isinstance(one, bool)]
        if len(usable) != len(axes) or not all(abs(one) <= _LONGEST for one in usable):
            wanted = ", ".join(axes)
            raise FileError(path, f"{name}: key '{key}' is {quoted(values)}, not an object with numbers {wanted}")
        numbers += usable
    if not 0.9 < math.hypot(*numbers[3:]) < 1.1:
        raise FileError(path, f"{name}: the orientation's x, y, z, w have length {math.hypot(*numbers[3:]):.3g}, not 1")
    return numbers
