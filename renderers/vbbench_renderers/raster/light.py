"""How bright a surface is: sun, sky, ground, highlight and haze; and the sky itself."""

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench_renderers.drawing import Sky
from vbbench_renderers.raster.textures import linear_to_srgb

SRGB_STEPS = 4096


def light_table(sky: Sky) -> FloatArray:
    """[6, 3] the direction and colour of the sun, zenith, horizon, the glow of the ground, and the haze's distance."""
    haze = np.full(3, sky.haze_distance)
    return np.array([sky.sun_direction, sky.sun_colour, sky.zenith, sky.horizon, sky.ground_glow, haze], np.float64)


def srgb_table() -> NDArray[np.uint8]:
    """[SRGB_STEPS + 1] sRGB bytes of linear values in 0 … 1."""
    values = linear_to_srgb(np.linspace(0.0, 1.0, SRGB_STEPS + 1, dtype=np.float32))
    return np.asarray(np.round(255.0 * values), np.uint8)
