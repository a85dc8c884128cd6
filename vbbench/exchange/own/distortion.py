"""Lens distortion of OpenCV's two models, removed from boxes: a pinhole sees straight what a lens bends.

``opencv`` (Brown and Conrady): with r² = x² + y² of a direction's (right, down) per forward,

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶)/(1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²),
    y' = y (…)/(…) + p1 (r² + 2 y²) + 2 p2 x y;

``fisheye`` (Kannala and Brandt): (x', y') = (x, y) θ'/r, θ = atan r, θ' = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸). In
both u = fx x' + cx and v = fy y' + cy.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.parsing.numbers import Within, check_ranges

Coefficient = Annotated[float, Within(-1e3, 1e3)]
WIDEST = np.radians(80.0)
"""Directions farther from the optical axis have no place on a pinhole's picture that is of any use."""
ON_THE_WAY = np.linspace(0.1, 1.0, 10)
"""Shares of the way from the optical axis to a point on which the model must not fold the picture over."""
ROUNDS, EXACT, STEP = 50, 1e-10, 1e-7
"""Newton steps, and the largest error of an inverse, per forward; step by which slopes are taken."""


@dataclass(frozen=True, kw_only=True)
class Distortion:
    """The table ``[distortion]`` of a camera file; coefficients are OpenCV's, those left out are 0."""

    model: Literal["opencv", "fisheye"] = "opencv"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    p1: Coefficient = 0.0
    p2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0
    k5: Coefficient = 0.0
    k6: Coefficient = 0.0

    def __post_init__(self) -> None:
        check_ranges(self)
        unknown = [name for name in ("p1", "p2", "k5", "k6") if self.model == "fisheye" and getattr(self, name)]
        if unknown:
            raise ValueError(f"[distortion]: OpenCV's fisheye model has k1 to k4 only, not {unknown[0]}; leave it out")

    def bend(self, straight: FloatArray) -> FloatArray:
        """Where the lens shows points [..., 2] (right, down per forward) of a pinhole's picture, in the same units."""
        x, y = np.moveaxis(straight, -1, 0)
        square = x * x + y * y
        if self.model == "fisheye":
            radius = np.sqrt(square)
            angle = np.arctan(radius)
            even = angle * angle
            bent = angle * (1.0 + even * (self.k1 + even * (self.k2 + even * (self.k3 + even * self.k4))))
            return straight * np.where(radius > 0.0, bent / np.maximum(radius, 1e-300), 1.0)[..., None]
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        radial = radial / (1.0 + square * (self.k4 + square * (self.k5 + square * self.k6)))
        return np.stack(
            [
                x * radial + 2.0 * self.p1 * x * y + self.p2 * (square + 2.0 * x * x),
                y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y,
            ],
            axis=-1,
        )

    def straighten(self, bent: FloatArray) -> FloatArray:
        """The way back, by Newton's method; NaN for what the lens shows nowhere, or too far from the optical axis."""
        points = bent.copy()
        if self.model == "fisheye":
            away = np.linalg.norm(bent, axis=-1, keepdims=True)
            points = bent * np.tan(np.minimum(away, WIDEST)) / np.maximum(away, 1e-300)
        with np.errstate(all="ignore"):
            for _ in range(ROUNDS):
                off = self.bend(points) - bent
                if not (np.abs(off) > EXACT).any():
                    break
                points = points - _solve(self._slopes(points), off)
            exact = (np.abs(self.bend(points) - bent) <= 100.0 * EXACT).all(axis=-1)
            unfolded = np.all([self._is_upright(share * points) for share in ON_THE_WAY], axis=0)
            near = np.linalg.norm(points, axis=-1) <= np.tan(WIDEST)
        return np.where((exact & unfolded & near)[..., None], points, np.nan)

    def _is_upright(self, points: FloatArray) -> BoolArray:
        """Whether the picture keeps its orientation in both directions at points [..., 2], as every lens's does."""
        slopes = self._slopes(points)
        upright: BoolArray = (np.linalg.det(slopes) > 0.0) & (np.trace(slopes, axis1=-2, axis2=-1) > 0.0)
        return upright

    def _slopes(self, points: FloatArray) -> FloatArray:
        """[..., 2, 2] the derivatives of `bend`."""
        columns = [
            (self.bend(points + STEP * axis) - self.bend(points - STEP * axis)) / (2 * STEP) for axis in np.eye(2)
        ]
        return np.stack(columns, axis=-1)


def _solve(slopes: FloatArray, off: FloatArray) -> FloatArray:
    """The Newton step of each point; by the formula for 2x2, as a singular one must not stop the others."""
    (a, b), (c, d) = np.moveaxis(slopes, (-2, -1), (0, 1))
    x, y = np.moveaxis(off, -1, 0)
    step: FloatArray = np.stack([d * x - b * y, a * y - c * x], axis=-1) / (a * d - b * c)[..., None]
    return step


def straighten_boxes(boxes: FloatArray, distortion: Distortion, intrinsics: FloatArray) -> FloatArray:
    """Boxes [N, 4] (left, top, width, height) in px as a pinhole of the same ``intrinsics`` [3, 3] sees them, or NaN.

    The middle of each edge is mapped, and the new box has its edges there: a person stands upright in the middle of the
    box, so that head and feet are at the middles of its upper and lower edge.
    """
    left, top, width, height = boxes.T
    across, down = left + 0.5 * width, top + 0.5 * height
    middles = np.stack(
        [
            np.stack(edge, axis=-1)
            for edge in ((left, down), (left + width, down), (across, top), (across, top + height))
        ]
    )
    scale, centre = intrinsics[[0, 1], [0, 1]], intrinsics[:2, 2]
    straight = distortion.straighten((middles - centre) / scale) * scale + centre
    new_left, right, new_top, bottom = straight[0, :, 0], straight[1, :, 0], straight[2, :, 1], straight[3, :, 1]
    return np.stack([new_left, new_top, right - new_left, bottom - new_top], axis=-1)
