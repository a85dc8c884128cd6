"""A camera model from outside vbbench, in one file: an equidistant fisheye, r = f·θ, with borders."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.camera import CentralCamera
from vbbench.geometry import FloatArray


@dataclass(frozen=True, kw_only=True)
class Fisheye(CentralCamera):
    """Square picture around the optical axis; nothing is shown straight behind."""

    kind: ClassVar[str] = "fisheye"
    width: int = 900
    focal: float = 280.0
    mount_height: float = 1.6
    pitch: float = 0.0
    roll: float = 0.0

    @property
    def picture_size(self) -> tuple[int, int]:
        return self.width, self.width

    def pixels(self, directions: FloatArray) -> FloatArray:
        right, down, forward = np.moveaxis(np.asarray(directions, float), -1, 0)
        off = np.hypot(right, down)
        angle = np.arctan2(off, forward)
        scale = self.focal * np.where(angle < 3.1, angle, np.nan) / np.maximum(off, 1e-12)
        return np.stack([right * scale, down * scale], axis=-1) + 0.5 * self.width

    def directions(self, pixels: FloatArray) -> FloatArray:
        right, down = np.moveaxis((np.asarray(pixels, float) - 0.5 * self.width) / self.focal, -1, 0)
        angle = np.hypot(right, down)
        shrunk = np.sinc(angle / np.pi)
        return np.stack([right * shrunk, down * shrunk, np.cos(angle)], axis=-1)
