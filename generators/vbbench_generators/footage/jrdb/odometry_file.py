"""The robot's way as JSON, by its wheels: ``{"odometry": {"000000.pcd": {"position": …, "orientation": …}}}``."""

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
    entries = read_frames(path, "odometry", "poses")
    rows = {frame_of(path, name, ".pcd", "odometry"): _pose(path, name, one) for name, one in sorted(entries.items())}
    kept = [row for row, frame in enumerate(clouds.frames.tolist()) if frame in rows]
    if len(kept) < 2:
        raise FileError(path, f"has poses of {len(kept)} of the point clouds in {clouds.path.name}; two are wanted")
    table = np.array([rows[int(clouds.frames[row])] for row in kept])
    x, y, z, w = (table[:, 3:] / np.linalg.norm(table[:, 3:], axis=1, keepdims=True)).T
    if float(np.median(1.0 - 2.0 * (x * x + y * y))) < np.cos(_LEVEL):
        raise FileError(path, "the robot is not upright: positions and orientations must have z upwards, w last")
    yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    return clouds.times[kept], np.column_stack([table[:, :2], yaw])


def _pose(path: Path, name: str, entry: Any) -> list[float]:
    """x, y, z of the position, and x, y, z, w of the orientation."""
    try:
        numbers = [float(entry["position"][axis]) for axis in "xyz"]
        numbers += [float(entry["orientation"][axis]) for axis in "xyzw"]
    except (KeyError, TypeError, ValueError, OverflowError):
        wanted = "'position' with numbers x, y, z and 'orientation' with x, y, z, w"
        raise FileError(path, f"{name} is {quoted(entry)}, not an object of {wanted}") from None
    if not np.abs(numbers).max() <= _LONGEST:
        raise FileError(path, f"{name}: {max(numbers, key=abs):g} is no number of m; positions are in m")
    if not 0.9 < (length := float(np.linalg.norm(numbers[3:]))) < 1.1:
        raise FileError(path, f"{name}: the orientation's x, y, z, w have length {length:.3g}, not 1")
    return numbers
