"""The pinhole camera, and the panorama that sees all around."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.camera.central import NEAREST, CentralCamera, Focal, MountHeight, PrincipalPoint, Size, Tilt
from vbbench.geometry import FloatArray


@dataclass(frozen=True, kw_only=True)
class PerspectiveCamera(CentralCamera):
    """Pinhole camera: u = cx + f·right/forward, v = cy + f_v·(h0 − h/2)/forward, l = f_v·h/forward where it is level.

    Parameters
    ----------
    width, height : image size in px.
    focal : focal length f in px.
    cx, cy : principal point in px.
    mount_height : h0 in m.
    pitch, roll : tilt in rad, up and clockwise positive.
    vertical_focal : f_v in px where pixels are not square.
    """

    kind: ClassVar[str] = "perspective"
    width: Size = 1280
    height: Size = 720
    focal: Focal = 640.0
    cx: PrincipalPoint = 640.0
    cy: PrincipalPoint = 360.0
    mount_height: MountHeight = 1.6
    pitch: Tilt = 0.0
    roll: Tilt = 0.0
    vertical_focal: Focal | None = None

    @property
    def picture_size(self) -> tuple[int, int]:
        """See `Camera.picture_size`."""
        return self.width, self.height

    @property
    def view(self) -> tuple[float, float]:
        """See `Camera.view`; without roll and pitch."""
        return float(-np.arctan(self.cx / self.focal)), float(np.arctan((self.width - self.cx) / self.focal))

    @property
    def intrinsics(self) -> FloatArray:
        """See `Camera.intrinsics`."""
        return np.array([[self.focal, 0.0, self.cx], [0.0, self.rows_focal, self.cy], [0.0, 0.0, 1.0]])

    @property
    def rows_focal(self) -> float:
        """The vertical focal length f_v in px."""
        return self.focal if self.vertical_focal is None else self.vertical_focal

    def pixels(self, directions: FloatArray) -> FloatArray:
        """See `Camera.pixels`; NaN behind the camera."""
        right, down, forward = np.moveaxis(directions, -1, 0)
        forward = np.where(forward > 0.0, forward, np.nan)
        return np.stack([self.cx + self.focal * right / forward, self.cy + self.rows_focal * down / forward], axis=-1)

    def directions(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.directions`."""
        right = (pixels[..., 0] - self.cx) / self.focal
        down = (pixels[..., 1] - self.cy) / self.rows_focal
        return np.stack([right, down, np.ones_like(right)], axis=-1)

    def project_unbounded(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project_unbounded`; in closed form where the camera is level."""
        if not self.level:
            return super().project_unbounded(relative, heights)
        depth = self.depth(relative)
        scale = self.rows_focal / depth
        u = self.cx + self.focal / depth * relative[..., 0]
        v = self.cy + scale * (self.mount_height - 0.5 * heights)
        return np.stack([u, v, scale * heights], axis=-1)

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.unproject`: forward = f_v·h/l, right = (u − cx)·forward/f where the camera is level."""
        if not self.level:
            return super().unproject(observations, heights)
        forward = self.rows_focal * heights / observations[..., 2]
        return np.stack([(observations[..., 0] - self.cx) * forward / self.focal, forward], axis=-1)

    def depth(self, relative: FloatArray) -> FloatArray:
        """Distance straight ahead, NaN behind the camera."""
        forward = relative[..., 1]
        return np.where(forward > NEAREST, forward, np.nan)

    def horizon(self, u: FloatArray) -> FloatArray:
        """See `Camera.horizon`; a straight line."""
        if self.level:
            return np.full(np.shape(u), self.cy)
        right, down, forward = self.to_camera(np.array([0.0, 1.0, 0.0]))
        rows: FloatArray = self.cy - self.rows_focal * ((np.asarray(u) - self.cx) / self.focal * right + forward) / down
        return rows


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
        boxes = np.empty((*np.broadcast_shapes(scale.shape, np.shape(heights)), 3))
        np.add(np.where(u < self.width, u, 0.0), 0.0 * scale, out=boxes[..., 0])  # column W is 0; NaN where scale is
        np.add(self.cy, scale * (self.mount_height - 0.5 * heights), out=boxes[..., 1])
        np.multiply(scale, heights, out=boxes[..., 2])
        return boxes

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
