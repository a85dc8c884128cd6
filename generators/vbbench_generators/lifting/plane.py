"""The size of a head as a plane over the picture: s = a + b·ν + c·x, with x = u − cx and ν = v − cy in px.

A head of size D at depth Z along the optical axis has s = f·D/Z. A camera tilted down by θ, H above the ground, sees a
head's centre at height h where H − h = Z·sin θ + Z·(ν/f)·cos θ. Together, s = D·(f·sin θ + ν·cos θ)/(H − h): linear
in ν. Roll turns the picture, and makes c differ from 0.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray


@dataclass(frozen=True, kw_only=True)
class SizePlane:
    """Sizes of heads in px.

    Parameters
    ----------
    a, b, c : size at the picture's centre in px, and its growth a px downwards and to the right.
    """

    a: float
    b: float
    c: float

    def at(self, x: FloatArray, nu: FloatArray) -> FloatArray:
        """Sizes [N] in px at ``x``, ``nu`` [N]; not positive on the horizon and above it."""
        return self.a + self.b * nu + self.c * x

    @property
    def slope(self) -> float:
        """How fast sizes grow towards the camera's foot."""
        return float(np.hypot(self.b, self.c))

    @property
    def roll(self) -> float:
        """Angle in rad by which the picture has to be turned clockwise for its horizon to be level."""
        return float(np.arctan2(self.c, self.b))

    @property
    def depth(self) -> float:
        """f·tan θ: distance in px from the picture's centre up to the horizon, once that is level."""
        return self.a / self.slope

    def levelled(self, x: FloatArray, nu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same points [N] in the picture turned level."""
        cos, sin = np.cos(self.roll), np.sin(self.roll)
        return x * cos - nu * sin, x * sin + nu * cos
