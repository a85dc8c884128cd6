"""The camera that sees all around."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.camera.central import CentralCamera, Focal, MountHeight, PrincipalPoint, Size, Tilt
from vbbench.geometry import FloatArray


@dataclass(frozen=True, kw_only=True)
class PanoramaCamera(CentralCamera):
    """360° cylinder: φ = 2πu/W − π clockwise from forward, v = cy + f·(h0 − h/2)/r, l = f·h/r, z = r(sin φ, cos φ).

    The cylinder has no upper or lower border: everybody around is observed, at any distance.

    Parameters
    ----------
    width : W, px around the full circle.
    focal : vertical focal length f in px; W/2π makes square pixels.
    cy : row of the horizon in px.
    mount_height : h0 in m.
    pitch, roll : tilt in rad, up and clockwise positive.
    """

    kind: ClassVar[str] = "panorama"
    width: Size = 1440
    focal: Focal = 1440 / (2.0 * np.pi)
    cy: PrincipalPoint = 240.0
    mount_height: MountHeight = 1.6
    pitch: Tilt = 0.0
    roll: Tilt = 0.0

    @property
    def picture_size(self) -> tuple[int, int]:
        """See `Camera.picture_size`; it is as high below the horizon as above it."""
        return self.width, round(2 * self.cy)

    @property
    def period(self) -> float:
        """The full circle."""
        return float(self.width)

    @property
    def cylinder(self) -> FloatArray | None:
        """See `Camera.cylinder`."""
        return np.array([self.focal, self.cy]) if self.level else None

    def pixels(self, directions: FloatArray) -> FloatArray:
        """See `Camera.pixels`; u is in [0, W)."""
        right, down, forward = np.moveaxis(directions, -1, 0)
        u = self.wrap_column((np.arctan2(right, forward) + np.pi) * (self.width / (2.0 * np.pi)))
        return np.stack([u, self.cy + self.focal * down / np.hypot(right, forward)], axis=-1)

    def directions(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.directions`."""
        azimuth = pixels[..., 0] * (2.0 * np.pi / self.width) - np.pi
        return np.stack([np.sin(azimuth), (pixels[..., 1] - self.cy) / self.focal, np.cos(azimuth)], axis=-1)

    def project_unbounded(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project_unbounded`; in closed form where the camera is level; u is in [0, W)."""
        if not self.level:
            return super().project_unbounded(relative, heights)
        scale = self.focal / self.depth(relative)
        azimuth = np.arctan2(relative[..., 0], relative[..., 1])
        u = (azimuth + np.pi) * (self.width / (2.0 * np.pi))
        u = np.where(u < self.width, u, 0.0) + 0.0 * scale  # column W is column 0; NaN where the scale is
        v = self.cy + scale * (self.mount_height - 0.5 * heights)
        return np.stack([u, v, scale * heights], axis=-1)

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.unproject`: r = f·h/l where the camera is level."""
        if not self.level:
            return super().unproject(observations, heights)
        azimuth = observations[..., 0] * (2.0 * np.pi / self.width) - np.pi
        reach = self.focal * heights / observations[..., 2]
        relative = np.empty((*reach.shape, 2))
        np.multiply(reach, np.sin(azimuth), out=relative[..., 0])
        np.multiply(reach, np.cos(azimuth), out=relative[..., 1])
        return relative

    def horizon(self, u: FloatArray) -> FloatArray:
        """See `Camera.horizon`."""
        if self.level:
            return np.full(np.shape(u), self.cy)
        azimuth = np.asarray(u) * (2.0 * np.pi / self.width) - np.pi
        right, down, forward = self.to_camera(np.array([0.0, 1.0, 0.0]))
        rows: FloatArray = self.cy - self.focal * (np.sin(azimuth) * right + np.cos(azimuth) * forward) / down
        return rows
