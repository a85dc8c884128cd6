"""The size of a head in the picture: a plane over it, and how round heads are.

The plane is s = a + b·ν + c·x, with x = u − cx and ν = v − cy in px. A head of size D at depth Z along the optical axis
has s = f·D/Z. A camera tilted down by θ, H above the ground, sees a head's centre at height h where
H − h = Z·sin θ + Z·(ν/f)·cos θ. Together, s = D·(f·sin θ + ν·cos θ)/(H − h): linear in ν. Roll turns the picture, and
makes c differ from 0.

A lens draws balls longer off its axis, and discs that face the camera not. The picture of a ball is wider by
√(1 + x²/f²) and higher by √(1 + ν²/f²) than f·D/Z, so boxes left and right are wider than high, and boxes above and
below higher than wide. The ratio of the sides shows how strong that effect is; it depends neither on the horizon nor
on the noise of sizes, if both sides are equally noisy.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_generators.lifting.heads import Heads
from vbbench_generators.lifting.settings import BoxSize


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


_CUT = 0.5


def box_sizes(boxes: FloatArray, kind: BoxSize) -> FloatArray:
    """What counts as the size in px of head ``boxes`` [N, 4]."""
    width, height = boxes[:, 2], boxes[:, 3]
    return {"mean": np.sqrt(width * height), "width": width, "height": height}[kind]


def roundness(heads: Heads, boxes: FloatArray, focal: float) -> float:
    """How much of a ball's lengthening boxes show: 0 discs, 1 balls.

    A least-squares slope of the logarithm of width over height; a track of n boxes counts √n, odd boxes are removed.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px of the ``heads``.
    focal : in px.
    """
    ratio = np.log(boxes[:, 2] / boxes[:, 3])
    ratio = ratio - np.median(ratio)
    fair = np.abs(ratio) < _CUT
    ball = 0.5 * (np.log1p((heads.x / focal) ** 2) - np.log1p((heads.nu / focal) ** 2))
    _, number, count = np.unique(heads.track, return_inverse=True, return_counts=True)
    weight = fair / np.sqrt(count[number])
    centred = ball - np.average(ball, weights=weight)
    spread = float((weight * centred**2).sum())
    return float(np.clip((weight * centred * ratio).sum() / spread, 0.0, 1.0)) if spread > 0.0 else 0.0


def lengthening(heads: Heads, focal: float, kind: BoxSize) -> FloatArray:
    """By what factor [N] a ball's size in the picture, of this ``kind``, is larger than f·D/Z."""
    across, down = 0.5 * np.log1p((heads.x / focal) ** 2), 0.5 * np.log1p((heads.nu / focal) ** 2)
    return np.exp({"mean": (across + down) / 2.0, "width": across, "height": down}[kind])
