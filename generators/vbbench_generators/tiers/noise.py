"""Noise of boxes, and how finely they are written.

Boxes are rounded to fractions of a pixel that are exact in binary, so that large datasets compress. A float64 of a
panorama has some 40 bits behind the thousandth of a pixel, and they are random: no compressor saves them. Multiples of
2^−b px leave them zero, and the byte streams of zeros cost nothing.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import Within, check_ranges
from vbbench_generators import _core

SHORTEST_BOX = 1.0
"""No box gets shorter than this, in px, by noise."""


def add_pixel_noise(boxes: FloatArray, camera: Camera, pixel_std: float, rng: np.random.Generator) -> FloatArray:
    """Gaussian noise of ``pixel_std`` px on the column, top and bottom of boxes [T, K, 3] (u, v, l) in px."""
    column, top, bottom = pixel_std * rng.standard_normal((3, *boxes.shape[:-1]))
    u = camera.wrap_column(boxes[..., 0] + column)
    v = boxes[..., 1] + 0.5 * (top + bottom)
    length = np.maximum(boxes[..., 2] + bottom - top, SHORTEST_BOX)
    return np.stack([u, v, length], axis=-1)


def wandering(shape: tuple[int, ...], memory: float, dt: float, rng: np.random.Generator) -> FloatArray:
    """Standard normal numbers of any shape, correlated over time t in s, the first axis, with e^(−t/``memory``).

    An Ornstein–Uhlenbeck process; ``memory`` and ``dt``, the time from one row to the next, are in s.
    """
    numbers = rng.standard_normal(shape)
    kept = np.exp(-dt / memory)
    _core.link_rows(numbers.reshape(len(numbers), numbers.size // max(len(numbers), 1)), kept, np.sqrt(1.0 - kept**2))
    return numbers


Bits = Annotated[int, Within(0, 32)]


@dataclass(frozen=True, kw_only=True)
class Precision:
    """How finely boxes are written (table ``[precision]`` of a recipe).

    The error is uniform over half a step to either side. At a distance r the panorama's l = f·h/r px then gives r to
    2^−(b_l + 1)/l of it, and u gives the direction to 2^−b_u·π/W rad. Solvers do not get this: with 10, 10 and 12 bits
    a place at 40 m is off by 0.5 mm at most, less than people sway from one frame to the next.

    Parameters
    ----------
    u_bits, v_bits, l_bits : binary digits behind the point of the centre column, centre row and height in px.
    """

    u_bits: Bits
    v_bits: Bits
    l_bits: Bits

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def steps(self) -> tuple[float, float, float]:
        """What u, v and l are multiples of, in px."""
        return 2.0**-self.u_bits, 2.0**-self.v_bits, 2.0**-self.l_bits

    def rounded(self, boxes: FloatArray, camera: Camera) -> FloatArray:
        """Boxes [..., 3] (u, v, l) in px to the nearest multiples; a column stays in the picture, a height above 0."""
        steps = np.array(self.steps)
        near: FloatArray = np.rint(boxes / steps) * steps
        near[..., 0] = camera.wrap_column(near[..., 0])
        np.maximum(near[..., 2], steps[2], out=near[..., 2])
        return near
