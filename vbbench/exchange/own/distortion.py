"""Lens distortion of OpenCV's two models, and its removal from boxes.

``opencv`` (Brown and Conrady): with r² = x² + y² of a direction's (right, down) per forward,

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶)/(1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²),
    y' = y (…)/(…) + p1 (r² + 2 y²) + 2 p2 x y;

``fisheye`` (Kannala and Brandt): (x', y') = (x, y) θ'/r, θ = atan r, θ' = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸). In
both u = fx x' + cx and v = fy y' + cy.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, TypeVar

import numpy as np

from vbbench.errors import suggestion
from vbbench.exchange.box_rows import BoxRows
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import Within, check_ranges

Boxes = TypeVar("Boxes", bound=BoxRows)
Coefficient = Annotated[float, Within(-1e3, 1e3)]
WIDEST = np.radians(80.0)
"""Directions farther from the optical axis have no place on a pinhole's picture that is of any use."""
ON_THE_WAY = np.linspace(0.1, 1.0, 10)
"""Shares of the way from the optical axis to a point on which the model must not fold the picture over."""
ROUNDS, EXACT, STEP = 50, 1e-10, 1e-7
"""Newton steps, and the largest error of an inverse, per forward; step by which derivatives are taken."""

LENSES = {
    **dict.fromkeys(("opencv", "plumb_bob", "radtan", "radial-tangential", "brown_conrady"), "opencv"),
    **dict.fromkeys(("rational", "rational_polynomial", "full_opencv"), "opencv"),
    **dict.fromkeys(("fisheye", "equidistant", "equi", "opencv_fisheye"), "fisheye"),
    **dict.fromkeys(("kannala_brandt", "kannala_brandt4", "kannala_brandt8"), "fisheye"),
    **dict.fromkeys(("none", "undistorted"), "none"),
}
"""Lens models by the names of OpenCV, ROS, Kalibr, COLMAP and SLAM programs, and the model of `Distortion`."""
COEFFICIENTS = {"opencv": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"), "fisheye": ("k1", "k2", "k3", "k4")}
"""The order of a list of coefficients."""
COUNTS = {"opencv": (4, 5, 8, 12, 14), "fisheye": (4, 5)}
"""How many numbers such lists have; those beyond the names are 0 or refused."""
WHICH = 'model = "opencv" (plumb_bob, radtan: k1 k2 p1 p2 k3) or model = "fisheye" (equidistant: k1 k2 k3 k4)'


def plain_name(name: object) -> str:
    """A name without case and punctuation, for the comparison of names from several programs."""
    return "".join(letter for letter in str(name).lower() if letter.isalnum())


def lens_model(name: object) -> str:
    """The model of `Distortion` that a program calls ``name``, or ``none``; raises ValueError if there is none."""
    found = {plain_name(known): model for known, model in LENSES.items()}.get(plain_name(name))
    if found is None:
        raise ValueError(f"no lens model is called '{name}'; {suggestion(str(name), LENSES)}")
    return found


def distortion_keys(table: Mapping[str, Any], which: str = WHICH) -> dict[str, Any] | None:
    """The keys of a `Distortion`, its ``model`` and coefficients, by their own names; ``None`` without distortion.

    Raises ValueError if the model is unknown, or not stated while coefficients fit two models.

    A ``table`` ``[distortion]`` has ``model`` by any of its names, coefficients by theirs or in a list; ``which`` is
    how a file states its lens model, for the error message.
    """
    named = dict(table)
    name, values = named.pop("model", None), named.pop("coefficients", ())
    model = None if name is None else lens_model(name)
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise ValueError("[distortion]: coefficients is a list in [ ]")
    if len(values) and named:
        raise ValueError(f"[distortion]: coefficients and {next(iter(named))} exclude each other; keep one of them")
    if model is None and (len(values) == 4 or (named and set(named) <= set(COEFFICIENTS["fisheye"]))):
        found = ", ".join(named) or "four coefficients"
        raise ValueError(f"[distortion]: {found} may be of two lens models; write {which}")
    if model == "none":
        return None
    model = model or "opencv"
    names = COEFFICIENTS[model]
    if len(values) and len(values) not in COUNTS[model]:
        order = f"{', '.join(map(str, COUNTS[model]))} ({' '.join(names)} ...)"
        raise ValueError(f"{len(values)} coefficients; lists of lens model '{model}' have {order}: write them by name")
    if any(values[len(names) :]):
        raise ValueError(f"lens model '{model}' has {' '.join(names)} here; the numbers after them must be 0")
    named |= zip(names, values, strict=False)
    return {"model": model, **named} if model == "fisheye" or any(named.values()) else None


@dataclass(frozen=True, kw_only=True)
class Distortion:
    """The table ``[distortion]`` of a camera file; coefficients are OpenCV's and 0 by default."""

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
            raise ValueError(f"[distortion]: OpenCV's fisheye model has k1 to k4 only, not {unknown[0]}; remove it")

    def bend(self, straight: FloatArray) -> FloatArray:
        """Distorted points of the undistorted ones [..., 2] (right, down per forward), in the same units."""
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
        right = x * radial + 2.0 * self.p1 * x * y + self.p2 * (square + 2.0 * x * x)
        down = y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y
        return np.stack([right, down], axis=-1)

    def straighten(self, bent: FloatArray) -> FloatArray:
        """The inverse of `bend`, by Newton's method; NaN for points without one, or too far from the optical axis."""
        points = bent.copy()
        if self.model == "fisheye":
            away = np.linalg.norm(bent, axis=-1, keepdims=True)
            points = bent * np.tan(np.minimum(away, WIDEST)) / np.maximum(away, 1e-300)
        with np.errstate(all="ignore"):
            for _ in range(ROUNDS):
                off = self.bend(points) - bent
                if not (np.abs(off) > EXACT).any():
                    break
                (a, b), (c, d) = np.moveaxis(self._jacobian(points), (-2, -1), (0, 1))
                x, y = np.moveaxis(off, -1, 0)  # inverses of 2 x 2, so that singular ones do not stop the others
                points = points - np.stack([d * x - b * y, a * y - c * x], axis=-1) / (a * d - b * c)[..., None]
            exact = (np.abs(self.bend(points) - bent) <= 100.0 * EXACT).all(axis=-1)
            ways = np.stack([self._jacobian(share * points) for share in ON_THE_WAY])
            upright = (np.linalg.det(ways) > 0.0) & (np.trace(ways, axis1=-2, axis2=-1) > 0.0)  # as every lens is
            near = np.linalg.norm(points, axis=-1) <= np.tan(WIDEST)
        return np.where((exact & upright.all(axis=0) & near)[..., None], points, np.nan)

    def _jacobian(self, points: FloatArray) -> FloatArray:
        """[..., 2, 2] the Jacobian of `bend`."""
        columns = [
            (self.bend(points + STEP * axis) - self.bend(points - STEP * axis)) / (2 * STEP) for axis in np.eye(2)
        ]
        return np.stack(columns, axis=-1)


def straight_rows(rows: Boxes, distortion: Distortion | None, intrinsics: FloatArray | None) -> tuple[Boxes, int]:
    """The boxes as a pinhole camera sees them, and the number of removed ones, which no pinhole camera sees."""
    if distortion is None or intrinsics is None:
        return rows, 0
    boxes = straighten_boxes(rows.boxes, distortion, intrinsics)
    kept = np.asarray(np.isfinite(boxes).all(axis=1) & (boxes[:, 2:] > 0.0).all(axis=1))
    return replace(rows, boxes=boxes).select(kept), int((~kept).sum())


def straighten_boxes(boxes: FloatArray, distortion: Distortion, intrinsics: FloatArray) -> FloatArray:
    """Undistorted boxes [N, 4] (left, top, width, height) in px, for a pinhole of the same ``intrinsics``, or NaN.

    The middle of each edge is mapped, and gives the new edge: head and feet of a standing person are at the middles of
    the upper and lower edge.
    """
    left, top, width, height = boxes.T
    across, down = left + 0.5 * width, top + 0.5 * height
    edges = (left, down), (left + width, down), (across, top), (across, top + height)
    middles = np.stack([np.stack(edge, axis=-1) for edge in edges])
    scale, centre = intrinsics[[0, 1], [0, 1]], intrinsics[:2, 2]
    straight = distortion.straighten((middles - centre) / scale) * scale + centre
    new_left, right, new_top, bottom = straight[0, :, 0], straight[1, :, 0], straight[2, :, 1], straight[3, :, 1]
    return np.stack([new_left, new_top, right - new_left, bottom - new_top], axis=-1)
