"""An equidistant fisheye: all that it takes to bring a camera model of one's own."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.camera import CentralCamera, Focal, MountHeight, Size, Tilt
from vbbench.geometry import FloatArray


@dataclass(frozen=True, kw_only=True)
class Fisheye(CentralCamera):
    """As many px from the middle of the picture as the direction is away from the optical axis, times ``focal``."""

    kind: ClassVar[str] = "fisheye"
    width: Size = 1280
    height: Size = 960
    focal: Focal = 400.0
    mount_height: MountHeight = 1.6
    pitch: Tilt = 0.0
    roll: Tilt = 0.0

    @property
    def picture_size(self) -> tuple[int, int]:
        """The picture's borders cut the circle that the lens shows."""
        return self.width, self.height

    def pixels(self, directions: FloatArray) -> FloatArray:
        """Straight behind has no pixel."""
        right, down, forward = np.moveaxis(directions, -1, 0)
        away = np.hypot(right, down)
        angle = np.arctan2(away, forward)
        ratio = np.where(away > 0.0, angle / np.maximum(away, 1e-300), 1.0 / np.maximum(forward, 1e-300))
        ratio = np.where(angle < np.pi, self.focal * ratio, np.nan)
        return np.stack([0.5 * self.width + ratio * right, 0.5 * self.height + ratio * down], axis=-1)

    def directions(self, pixels: FloatArray) -> FloatArray:
        """Unit vectors."""
        across, down = (
            (pixels[..., 0] - 0.5 * self.width) / self.focal,
            (pixels[..., 1] - 0.5 * self.height) / self.focal,
        )
        angle = np.hypot(across, down)
        share = np.sinc(angle / np.pi)
        return np.stack([share * across, share * down, np.cos(angle)], axis=-1)
