"""The camera of a 360° film: columns and rows are angles."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.camera.central import CentralCamera, Focal, MountHeight, PrincipalPoint, Size, Tilt
from vbbench.geometry import FloatArray


@dataclass(frozen=True, kw_only=True)
class EquirectangularCamera(CentralCamera):
    """Full sphere: φ = 2πu/W − π clockwise from forward, v = cy + f·θ, θ the angle below the horizon in rad.

    Parameters
    ----------
    width, height : picture size in px, W and H; a whole sphere has H = W/2.
    focal : f, px per rad of a column; W/2π makes square pixels.
    cy : row of the horizon in px, H/2 in a whole sphere.
    mount_height : h0 in m.
    pitch, roll : tilt in rad, up and clockwise positive.
    """

    kind: ClassVar[str] = "equirectangular"
    width: Size = 1440
    height: Size = 720
    focal: Focal = 1440 / (2.0 * np.pi)
    cy: PrincipalPoint = 360.0
    mount_height: MountHeight = 1.6
    pitch: Tilt = 0.0
    roll: Tilt = 0.0

    @property
    def picture_size(self) -> tuple[int, int]:
        """See `Camera.picture_size`."""
        return self.width, self.height

    @property
    def period(self) -> float:
        """The full circle."""
        return float(self.width)

    def pixels(self, directions: FloatArray) -> FloatArray:
        """See `Camera.pixels`; u is in [0, W)."""
        right, down, forward = np.moveaxis(directions, -1, 0)
        u = self.wrap_column((np.arctan2(right, forward) + np.pi) * (self.width / (2.0 * np.pi)))
        return np.stack([u, self.cy + self.focal * np.arctan2(down, np.hypot(right, forward))], axis=-1)

    def directions(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.directions`."""
        azimuth = pixels[..., 0] * (2.0 * np.pi / self.width) - np.pi
        below = (pixels[..., 1] - self.cy) / self.focal
        level = np.cos(below)
        return np.stack([level * np.sin(azimuth), np.sin(below), level * np.cos(azimuth)], axis=-1)
