"""``calib/NNNN.txt``: projection of KITTI's camera 2, extrinsics of its GPS/IMU, and the size of the pictures."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError
from vbbench.exchange.text_tables import read_content
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import finite_number

MOUNT_HEIGHT = 1.65
"""Height of the cameras above the ground in m (Geiger et al. 2013, figure 3)."""

SIZES = {
    721.5377: (1242, 375),
    707.0493: (1224, 370),
    718.3351: (1238, 374),
    707.0912: (1226, 370),
    718.8560: (1241, 376),
}
"""Focal length of the rectified pictures in px → their width and height, of the five days of recording: 2011-09-26,
-28, -29, -30, and 2011-10-03."""

_SAME_FOCAL = 1e-3
_KEYS = {
    "P2": ("P2",),
    "R_rect": ("R_rect", "R0_rect"),
    "Tr_velo_cam": ("Tr_velo_cam", "Tr_velo_to_cam"),
    "Tr_imu_velo": ("Tr_imu_velo", "Tr_imu_to_velo"),
}
"""What is read, and what versions of the download call it."""
_TOLERANCE = 1e-2
"""How far a rotation's rows may be from orthonormal."""
_FOCAL_RANGE = (0.3, 5.0)
"""Focal lengths of cameras on cars, in widths of their pictures: 120° to 11° across."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Calibration of the sensors.

    Parameters
    ----------
    projection : [3, 4] P2, from rectified coordinates of camera 0 (right, down, forward) to pixels of camera 2.
    imu_to_camera : [4, 4] from the GPS/IMU (forward, left, up) to rectified coordinates of camera 0.
    """

    path: Path
    projection: FloatArray
    imu_to_camera: FloatArray

    @property
    def offset(self) -> FloatArray:
        """Translation [3] in m from coordinates of camera 0 to those of camera 2: t = K⁻¹ p₄."""
        return np.asarray(np.linalg.solve(self.projection[:, :3], self.projection[:, 3]), np.float64)

    @property
    def known_size(self) -> tuple[int, int] | None:
        """Width and height of the pictures by their focal length; ``None`` if it is none of KITTI's."""
        focal = self.projection[0, 0]
        return next((size for known, size in SIZES.items() if abs(focal - known) < _SAME_FOCAL), None)

    def camera(self, size: tuple[int, int]) -> PerspectiveCamera:
        """Camera 2, assumed level; ``size`` is that of its pictures in px."""
        (focal, _, cx, _), (_, vertical, cy, _), _ = self.projection.tolist()
        least, most = (width * size[0] for width in _FOCAL_RANGE)
        if not (least <= focal <= most and least <= vertical <= most):
            problem = f"P2 has focal lengths {focal:g} and {vertical:g} px, for pictures {size[0]} px wide"
            raise FileError(self.path, f"{problem}; a camera's is {least:.0f} to {most:.0f} px")
        return PerspectiveCamera(
            width=size[0],
            height=size[1],
            focal=focal,
            cx=cx,
            cy=cy,
            mount_height=MOUNT_HEIGHT,
            vertical_focal=None if vertical == focal else vertical,
        )

    def project(self, places: FloatArray) -> FloatArray:
        """Pixels [N, 2] of places [N, 3] in coordinates of camera 0; NaN behind the camera."""
        seen = places @ self.projection[:, :3].T + self.projection[:, 3]
        depth = np.where(seen[:, 2:] > 0.0, seen[:, 2:], np.nan)
        pixels: FloatArray = seen[:, :2] / depth
        return pixels


def read_calibration(path: Path) -> Calibration:
    """Read a calibration file."""
    text = read_content(path, "the calibration: P2, R_rect, Tr_velo_cam, Tr_imu_velo").decode(errors="replace")
    found = {}
    for line, words in enumerate((line.replace(":", " ").split() for line in text.splitlines()), 1):
        name = next((name for name, keys in _KEYS.items() if words and words[0] in keys), None)
        if name is not None:
            found[name] = _matrix(path, line, name, words[1:])
    missing = [name for name in _KEYS if name not in found]
    if missing:
        raise FileError(path, f"lacks {', '.join(missing)}; download the calibration of the tracking benchmark again")
    return Calibration(
        path=path,
        projection=found["P2"],
        imu_to_camera=_rigid(found["R_rect"]) @ _rigid(found["Tr_velo_cam"]) @ _rigid(found["Tr_imu_velo"]),
    )


def _matrix(path: Path, line: int, name: str, words: list[str]) -> FloatArray:
    columns = 3 if name == "R_rect" else 4
    if len(words) != 3 * columns:
        raise FileError(path, f"{name} has {len(words)} numbers, not {3 * columns} (3 rows of {columns})", line)
    matrix = np.array([finite_number(path, line, name, word) for word in words]).reshape(3, columns)
    if name == "P2" and not (matrix[0, 0] > 0.0 and matrix[1, 1] > 0.0):
        raise FileError(path, f"P2 has focal lengths {matrix[0, 0]:g} and {matrix[1, 1]:g} px; they are above 0", line)
    if name != "P2":
        skew = np.abs(matrix[:, :3] @ matrix[:, :3].T - np.eye(3)).max()
        if skew > _TOLERANCE or np.linalg.det(matrix[:, :3]) < 0.0:
            raise FileError(path, f"{name} is no rotation: its rows deviate from orthonormal ones by {skew:.2g}", line)
    return matrix


def _rigid(matrix: FloatArray) -> FloatArray:
    """A rotation [3, 3], or rotation and translation [3, 4], as a homogeneous matrix [4, 4]."""
    whole = np.eye(4)
    whole[:3, : matrix.shape[1]] = matrix
    return whole
