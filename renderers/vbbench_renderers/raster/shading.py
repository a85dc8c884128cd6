"""Colours of what the z-buffer found, once a pixel: patterns, textures, sun, sky light, highlights and haze."""

import math
from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from vbbench.arrays import FloatArray
from vbbench_renderers.drawing import CHECKS_PER_M, RINGS_PER_M, STRIPES_ROUND, Pattern
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.compiled import kernel, parallel_kernel
from vbbench_renderers.raster.filling import STRIP, cross
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.raster.placing import Placed
from vbbench_renderers.raster.rays import Rays
from vbbench_renderers.raster.textures import Textures, read_texture

RINGS, STRIPES, CHECKS, LOWER_HALF = (
    int(pattern) for pattern in (Pattern.RINGS, Pattern.STRIPES, Pattern.CHECKS, Pattern.LOWER_HALF)
)
SHINE = 24.0
"""Exponent of the highlight (Blinn 1977)."""
SRGB_STEPS = 4096


class Looks(NamedTuple):
    """How N limbs look; see `Limbs`.

    Parameters
    ----------
    colour, second_colour : [N, 3].
    pattern, gloss : [N].
    normal : [N, 3, 3] from normals of the limb's frame to normals in the world, of any length.
    """

    colour: Float32
    second_colour: Float32
    pattern: Int32
    gloss: Float32
    normal: Float32


class Light(NamedTuple):
    """A `Sky` as the kernels read it, and the table from linear light to sRGB bytes.

    Parameters
    ----------
    sun : [3] unit vector towards the sun.
    sun_colour, zenith, horizon, ground_glow : [3].
    haze_distance : m.
    srgb : [SRGB_STEPS + 1] byte of a linear value in 0 … 1.
    """

    sun: FloatArray
    sun_colour: FloatArray
    zenith: FloatArray
    horizon: FloatArray
    ground_glow: FloatArray
    haze_distance: float
    srgb: NDArray[np.uint8]


@parallel_kernel
def shade(
    parts: Parts,
    mesh: Int32,
    looks: Looks,
    placed: Placed,
    rays: Rays,
    eye: FloatArray,
    light: Light,
    textures: Textures,
    nearness: Float32,
    limbs: Int32,
    faces: Int32,
    sunlit: Float32,
    colours: NDArray[np.uint8],
) -> None:
    """Write ``colours`` [W, H, 3], sRGB, of what `fill` found; ``eye`` [3, 4] is from the world to the eye."""
    width = len(rays.side)
    for strip in prange((width + STRIP - 1) // STRIP):
        for column in range(strip * STRIP, min(width, (strip + 1) * STRIP)):
            _shade_column(
                parts, mesh, looks, placed, rays, eye, light, textures, nearness, limbs, faces, sunlit, colours, column
            )


@kernel
def _shade_column(
    parts: Parts,
    mesh: Int32,
    looks: Looks,
    placed: Placed,
    rays: Rays,
    eye: FloatArray,
    light: Light,
    textures: Textures,
    nearness: Float32,
    limbs: Int32,
    faces: Int32,
    sunlit: Float32,
    colours: NDArray[np.uint8],
    column: int,
) -> None:
    """One column; what a triangle has for all of its pixels is kept from row to row."""
    x, z = rays.side[column], rays.ahead[column]
    flat = x * x + z * z
    ray_x, ray_y = eye[0, 0] * x + eye[2, 0] * z, eye[0, 1] * x + eye[2, 1] * z
    old_limb, old_face = -1, -1
    a = b = c = layer = 0
    e0 = e1 = e2 = (0.0, 0.0, 0.0)
    for row in range(rays.height):
        up = (rays.horizon - row) / rays.focal
        stretch = math.sqrt(flat + up * up)
        if nearness[column, row] == 0.0:
            _write(colours, column, row, sky_colour(light, ray_x / stretch, ray_y / stretch, up / stretch), light.srgb)
            continue
        limb, face = limbs[column, row], faces[column, row]
        if limb != old_limb or face != old_face:
            old_limb, old_face = limb, face
            part = mesh[limb]
            shift = placed.first[limb] - parts.first_vertex[part]
            face += parts.first_triangle[part]
            a, b, c = parts.triangles[face, 0], parts.triangles[face, 1], parts.triangles[face, 2]
            layer = parts.layers[face]
            e0 = cross(placed.points, b + shift, c + shift)
            e1 = cross(placed.points, c + shift, a + shift)
            e2 = cross(placed.points, a + shift, b + shift)
        w0 = e0[0] * x + e0[1] * up + e0[2] * z
        w1 = e1[0] * x + e1[1] * up + e1[2] * z
        w2 = e2[0] * x + e2[1] * up + e2[2] * z
        total = w0 + w1 + w2
        w0, w1, w2 = w0 / total, w1 / total, w2 / total
        red, green, blue = blend(parts.colours, a, b, c, w0, w1, w2)
        if looks.pattern[limb] != 0 and patterned(looks.pattern[limb], blend(parts.vertices, a, b, c, w0, w1, w2)):
            dye = looks.second_colour[limb]
        else:
            dye = looks.colour[limb]
        red, green, blue = red * dye[0], green * dye[1], blue * dye[2]
        nx, ny, nz = _turned(looks.normal[limb], blend(parts.normals, a, b, c, w0, w1, w2))
        distance = stretch / nearness[column, row]
        vx, vy, vz = -ray_x / stretch, -ray_y / stretch, -up / stretch
        if layer >= 0:
            facing = max(0.02, abs(nx * vx + ny * vy + nz * vz))
            texel = (
                distance / (rays.focal * math.sqrt(facing)) * parts.grain[old_face + parts.first_triangle[mesh[limb]]]
            )
            level = int(min(max(math.log2(texel * textures.size[0] + 1e-9) + 0.5, 0.0), len(textures.size) - 1.0))
            u = w0 * parts.uv[a, 0] + w1 * parts.uv[b, 0] + w2 * parts.uv[c, 0]
            v = w0 * parts.uv[a, 1] + w1 * parts.uv[b, 1] + w2 * parts.uv[c, 1]
            texture = read_texture(textures, layer, u, v, level)
            red, green, blue = red * texture[0], green * texture[1], blue * texture[2]
        sun = max(0.0, nx * light.sun[0] + ny * light.sun[1] + nz * light.sun[2]) * sunlit[column, row]
        shine = 0.0
        if looks.gloss[limb] > 0.0 and sun > 0.0:
            hx, hy, hz = light.sun[0] + vx, light.sun[1] + vy, light.sun[2] + vz
            half = (nx * hx + ny * hy + nz * hz) / math.sqrt(hx * hx + hy * hy + hz * hz)
            shine = looks.gloss[limb] * sun * max(0.0, half) ** SHINE
        clear = math.exp(-distance / light.haze_distance)
        sky = 0.5 + 0.5 * nz
        result = (
            _lit(light, 0, red, sun, shine, sky, clear),
            _lit(light, 1, green, sun, shine, sky, clear),
            _lit(light, 2, blue, sun, shine, sky, clear),
        )
        _write(colours, column, row, result, light.srgb)


@kernel
def _lit(light: Light, band: int, albedo: float, sun: float, shine: float, sky: float, clear: float) -> float:
    """One colour band of a lit surface, seen through the haze."""
    ambient = sky * 0.5 * (light.zenith[band] + light.horizon[band]) + (1.0 - sky) * light.ground_glow[band]
    colour = albedo * (light.sun_colour[band] * sun + ambient) + light.sun_colour[band] * shine
    return float(clear * colour + (1.0 - clear) * light.horizon[band])


@kernel
def blend(values: Float32, a: int, b: int, c: int, w0: float, w1: float, w2: float) -> tuple[float, float, float]:
    """Three numbers of the corners, weighted."""
    return (
        w0 * values[a, 0] + w1 * values[b, 0] + w2 * values[c, 0],
        w0 * values[a, 1] + w1 * values[b, 1] + w2 * values[c, 1],
        w0 * values[a, 2] + w1 * values[b, 2] + w2 * values[c, 2],
    )


@kernel
def _turned(turn: Float32, normal: tuple[float, float, float]) -> tuple[float, float, float]:
    x = turn[0, 0] * normal[0] + turn[0, 1] * normal[1] + turn[0, 2] * normal[2]
    y = turn[1, 0] * normal[0] + turn[1, 1] * normal[1] + turn[1, 2] * normal[2]
    z = turn[2, 0] * normal[0] + turn[2, 1] * normal[1] + turn[2, 2] * normal[2]
    length = math.sqrt(x * x + y * y + z * z) + 1e-20
    return x / length, y / length, z / length


@kernel
def patterned(pattern: int, point: tuple[float, float, float]) -> bool:
    """Whether a limb shows its second colour at a point of its frame; see `Pattern`."""
    if pattern == RINGS:
        return _odd(RINGS_PER_M * point[2])
    if pattern == STRIPES:
        return _odd(STRIPES_ROUND * math.atan2(point[1], point[0]) / (2.0 * math.pi))
    if pattern == CHECKS:
        return _odd(CHECKS_PER_M * point[0]) != _odd(CHECKS_PER_M * point[2])
    return pattern == LOWER_HALF and point[2] < 0.0


@kernel
def _odd(value: float) -> bool:
    return value - math.floor(value) < 0.5


@kernel
def sky_colour(light: Light, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The sky in a direction, with the sun and its glow; below the horizon as on it."""
    mix = math.sqrt(max(z, 0.0))
    glow = max(0.0, x * light.sun[0] + y * light.sun[1] + z * light.sun[2])
    glow = 0.15 * glow**64 + (4.0 if glow > 0.9998 else 0.0)
    return (
        light.horizon[0] + mix * (light.zenith[0] - light.horizon[0]) + glow * light.sun_colour[0],
        light.horizon[1] + mix * (light.zenith[1] - light.horizon[1]) + glow * light.sun_colour[1],
        light.horizon[2] + mix * (light.zenith[2] - light.horizon[2]) + glow * light.sun_colour[2],
    )


@kernel
def _write(
    colours: NDArray[np.uint8], column: int, row: int, colour: tuple[float, float, float], srgb: NDArray[np.uint8]
) -> None:
    for band in range(3):
        colours[column, row, band] = srgb[int(min(max(colour[band], 0.0), 1.0) * SRGB_STEPS + 0.5)]
