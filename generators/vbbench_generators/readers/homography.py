"""Homographies from image to ground plane."""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.geometry import FloatArray
from vbbench_generators.readers.textfile import read_numbers


def read_homography(path: Path) -> FloatArray:
    """Read a [3, 3] homography: three rows of three numbers.

    Raises
    ------
    FileError
        If the shape differs, a number is bad, or the matrix is singular.
    """
    matrix, lines = read_numbers(path, ("h1", "h2", "h3"))
    if len(matrix) != 3:
        raise FileError(path, f"a homography has 3 rows of 3 numbers, not {len(matrix)}", int(lines[-1]))
    largest = np.abs(matrix).max()
    if not largest or np.linalg.matrix_rank(matrix / largest) < 3:
        raise FileError(path, "the homography is singular: it maps the image onto a line or a point")
    return matrix


def to_ground(points: FloatArray, homography: FloatArray) -> FloatArray:
    """Image points [N, 2] in px to the ground plane [N, 2] in m; not finite for points on the horizon."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mapped = points @ homography[:, :2].T + homography[:, 2]
        ground: FloatArray = mapped[:, :2] / mapped[:, 2:]
    return ground
