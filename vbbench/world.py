"""Where a scene lies in a sequence's own world, so that no sequence has information on another."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from vbbench.geometry import FloatArray, wrap_angle


@dataclass(frozen=True, kw_only=True)
class World:
    """A point p of the scene is R(yaw)·p + (x, y) in the world of the sequence.

    Parameters
    ----------
    x, y, yaw : in m and rad, counter-clockwise; all 0: the sequence's world is its scene's.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def positions(self, of_scene: FloatArray) -> FloatArray:
        """Positions [..., 2] of the scene in the sequence's world, in m."""
        x, y = of_scene[..., 0], of_scene[..., 1]
        across, along = cos(self.yaw), sin(self.yaw)
        return np.stack([across * x - along * y + self.x, along * x + across * y + self.y], axis=-1)

    def poses(self, of_scene: FloatArray) -> FloatArray:
        """Poses [..., 3] (x, y, yaw) of the scene in the sequence's world, in m and rad."""
        yaw = wrap_angle(of_scene[..., 2] + self.yaw)
        return np.concatenate([self.positions(of_scene[..., :2]), yaw[..., None]], axis=-1)

    def poses_in_scene(self, poses: FloatArray) -> FloatArray:
        """The inverse of `poses`."""
        x, y = poses[..., 0] - self.x, poses[..., 1] - self.y
        across, along = cos(self.yaw), sin(self.yaw)
        return np.stack([across * x + along * y, across * y - along * x, wrap_angle(poses[..., 2] - self.yaw)], axis=-1)
