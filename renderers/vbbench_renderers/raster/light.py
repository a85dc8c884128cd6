"""How bright a surface is: sun, sky, ground, highlight and haze; and the sky itself."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_renderers.drawing import Sky
from vbbench_renderers.raster.textures import linear_to_srgb
from vbbench_renderers.rays import Rays

SRGB_STEPS = 4096
Colour = tuple[float, float, float]


class Light(NamedTuple):
    """A `Sky` as the kernels read it; see there."""

    sun: Colour
    sun_colour: Colour
    zenith: Colour
    horizon: Colour
    ground_glow: Colour
    haze_distance: float


def light_table(sky: Sky) -> FloatArray:
    """[6, 3] the fields of `Light`, row by row, because threads receive arrays."""
    haze = np.full(3, sky.haze_distance)
    return np.array([sky.sun_direction, sky.sun_colour, sky.zenith, sky.horizon, sky.ground_glow, haze], np.float64)


@kernel
def light_of(table: FloatArray) -> Light:
    """The light of a `light_table`."""
    return Light(
        (table[0, 0], table[0, 1], table[0, 2]),
        (table[1, 0], table[1, 1], table[1, 2]),
        (table[2, 0], table[2, 1], table[2, 2]),
        (table[3, 0], table[3, 1], table[3, 2]),
        (table[4, 0], table[4, 1], table[4, 2]),
        table[5, 0],
    )


def srgb_table() -> NDArray[np.uint8]:
    """[SRGB_STEPS + 1] sRGB bytes of linear values in 0 … 1."""
    values = linear_to_srgb(np.linspace(0.0, 1.0, SRGB_STEPS + 1, dtype=np.float32))
    return np.asarray(np.round(255.0 * values), np.uint8)


@kernel
def encode(value: float, table: NDArray[np.uint8]) -> int:
    """The sRGB byte of a linear value."""
    return table[int(min(max(value, 0.0), 1.0) * SRGB_STEPS + 0.5)]  # type: ignore[no-any-return]


@kernel
def lit(light: Light, albedo: Colour, normal: Colour, towards: Colour, gloss: float, sun: float, sky: float) -> Colour:
    """Light that leaves a surface.

    Parameters
    ----------
    albedo : linear RGB.
    normal, towards : unit vectors; to the eye.
    gloss : strength of highlight and rim.
    sun : share of the sun that reaches the point.
    sky : share of the sky that the point sees.
    """
    facing = max(0.0, _dot(normal, light.sun)) * sun
    above, direct = 0.5 + 0.5 * normal[2], facing * (0.5 + 0.5 * sky)
    mirrored = glare = 0.0
    if gloss > 0.0:
        half = (towards[0] + light.sun[0], towards[1] + light.sun[1], towards[2] + light.sun[2])
        shine = max(0.0, _dot(normal, half) / math.sqrt(_dot(half, half) + 1e-12))
        mirrored = gloss * 0.6 * facing * shine**32
        rim = 1.0 - max(0.0, _dot(normal, towards))
        glare = gloss * 0.35 * rim**4
    return (
        _band(light, 0, albedo[0], above, sky, direct, mirrored, glare),
        _band(light, 1, albedo[1], above, sky, direct, mirrored, glare),
        _band(light, 2, albedo[2], above, sky, direct, mirrored, glare),
    )


@kernel
def _band(
    light: Light, band: int, albedo: float, above: float, sky: float, direct: float, mirrored: float, glare: float
) -> float:
    heaven = 0.4 * light.horizon[band] + 0.6 * light.zenith[band]
    ambient = (above * heaven + (1.0 - above) * light.ground_glow[band]) * sky
    return albedo * (ambient + light.sun_colour[band] * direct) + light.sun_colour[band] * mirrored + glare * ambient


@kernel
def through_air(light: Light, colour: Colour, distance: float) -> Colour:
    """A colour seen from a distance in m; exp(−distance / haze) is taken as a 16th power, to 0.001 within one haze."""
    step = distance / (16.0 * light.haze_distance)
    clear = 1.0 / (1.0 + step + 0.5 * step * step)
    clear *= clear
    clear *= clear
    clear *= clear
    clear *= clear
    return (
        clear * colour[0] + (1.0 - clear) * light.horizon[0],
        clear * colour[1] + (1.0 - clear) * light.horizon[1],
        clear * colour[2] + (1.0 - clear) * light.horizon[2],
    )


@kernel
def sky_colour(light: Light, x: float, y: float, z: float) -> Colour:
    """The sky in a direction, with the sun and its glow; below the horizon it is as on the horizon."""
    mix = math.sqrt(max(z, 0.0))
    along = max(0.0, x * light.sun[0] + y * light.sun[1] + z * light.sun[2])
    edge = min(max((along - 0.99955) / 0.00025, 0.0), 1.0)
    near = along**8
    glow = 0.04 * near + 0.12 * near**4 + 2.0 * edge * edge * (3.0 - 2.0 * edge)
    return (
        light.horizon[0] + mix * (light.zenith[0] - light.horizon[0]) + glow * light.sun_colour[0],
        light.horizon[1] + mix * (light.zenith[1] - light.horizon[1]) + glow * light.sun_colour[1],
        light.horizon[2] + mix * (light.zenith[2] - light.horizon[2]) + glow * light.sun_colour[2],
    )


@kernel
def _dot(a: Colour, b: Colour) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def sky_picture(table: FloatArray, srgb: NDArray[np.uint8], rays: Rays, eye: FloatArray) -> NDArray[np.uint8]:
    """[H, W, 3] sRGB picture of only the sky; ``table`` is a `light_table`."""
    light, width = light_of(table), len(rays.side)
    picture = np.empty((rays.height, width, 3), np.uint8)
    for row in range(rays.height):
        for column in range(width):
            x, up, z = rays.side[column], (rays.horizon - row) / rays.focal, rays.ahead[column]
            length = math.sqrt(x * x + up * up + z * z)
            east = (eye[0, 0] * x + eye[2, 0] * z + eye[1, 0] * up) / length
            north = (eye[0, 1] * x + eye[2, 1] * z + eye[1, 1] * up) / length
            high = (eye[0, 2] * x + eye[2, 2] * z + eye[1, 2] * up) / length
            colour = sky_colour(light, east, north, high)
            for band in range(3):
                picture[row, column, band] = encode(colour[band], srgb)
    return picture
