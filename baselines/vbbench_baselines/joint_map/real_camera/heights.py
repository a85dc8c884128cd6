"""How tall people are as boxes show them: most stand, some sit, some are children.

ln of a height η has the density (1 − w) N(μ, σ²) + w N(μ + s, σ_s²). With the probability π that somebody of this
height is a short one, −ln of it is touched at η from above by a parabola (Dempster, Laird and Rubin 1977), which the
descent takes for a normal law of the precision and the mean

    p = (1 − π)/σ² + π/σ_s²,   ((1 − π) μ/σ² + π (μ + s)/σ_s²)/p.

On a chair an adult of 1.72 m is 1.2 m high, bent, to 1.34 m, upright; so tall are children of six to ten.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel

SHORTER, SHORTER_STD = -0.33, 0.12
"""s and σ_s."""

SHORT_SHARE = 0.05
"""w."""


def is_short(height: FloatArray, mean: float) -> BoolArray:
    """Which ln ``height`` [...] are nearer to that of somebody short than to the ``mean``."""
    return np.asarray(height < mean + 0.5 * SHORTER)


class HeightLaw(NamedTuple):
    """−ln of the density at a height, up to a constant, and mean and standard deviation of the law that bounds it."""

    deviance: float
    mean: float
    std: float


@kernel
def height_law(height: float, mean: float, std: float) -> HeightLaw:
    """Of ln ``height``, where people who stand have ``mean`` and ``std``."""
    tall = -0.5 * ((height - mean) / std) ** 2
    short = -0.5 * ((height - mean - SHORTER) / SHORTER_STD) ** 2
    short += np.log(SHORT_SHARE / (1.0 - SHORT_SHARE) * std / SHORTER_STD)
    likelier = max(tall, short)
    total = likelier + np.log(np.exp(tall - likelier) + np.exp(short - likelier))
    by_tall, by_short = np.exp(tall - total) / std**2, np.exp(short - total) / SHORTER_STD**2
    precision = by_tall + by_short
    return HeightLaw(-total, mean + by_short * SHORTER / precision, 1.0 / np.sqrt(precision))
