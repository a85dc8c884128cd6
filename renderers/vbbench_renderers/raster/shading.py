"""Colours of the surfaces in the z-buffer, once per pixel."""

import math
from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel, parallel_kernel
from vbbench_renderers.drawing import CHECKS_PER_M, RINGS_PER_M, STRIPES_ROUND, Limbs, Pattern
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.filling import STRIP, cross
from vbbench_renderers.raster.light import Colour, encode, light_of, lit, sky_colour, through_air
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.raster.placing import Placed
from vbbench_renderers.raster.shadows import ShadowMap, smooth_value, sun_share
from vbbench_renderers.raster.textures import Textures, read_texture
from vbbench_renderers.rays import Rays

RINGS, STRIPES, CHECKS, LOWER_HALF = (
    int(pattern) for pattern in (Pattern.RINGS, Pattern.STRIPES, Pattern.CHECKS, Pattern.LOWER_HALF)
)
OVER_GROUND = 1.0 / 3.0
"""Height in m up to which contact shadows reach."""


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


class Seen(NamedTuple):
    """What `vbbench_renderers.raster.filling.fill` found; see there."""

    nearness: Float32
    limbs: Int32
    faces: Int32


def looks_of(limbs: Limbs) -> Looks:
    """Looks of limbs. Normals turn with the cofactors of A, so that they stay normal however A shears."""
    a, b, c = limbs.transform[:, :, 0], limbs.transform[:, :, 1], limbs.transform[:, :, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    outward = np.sign(np.einsum("ni,ni->n", a, cofactors[:, :, 0]))[:, None, None]
    normal = np.ascontiguousarray(cofactors * outward, np.float32)
    return Looks(limbs.colour, limbs.second_colour, limbs.pattern, limbs.gloss, normal)


@parallel_kernel
def shade(
    parts: Parts,
    mesh: Int32,
    looks: Looks,
    placed: Placed,
    rays: Rays,
    eye: FloatArray,
    sky_light: FloatArray,
    textures: Textures,
    people: ShadowMap,
    static: ShadowMap,
    seen: Seen,
    table: NDArray[np.uint8],
    colours: NDArray[np.uint8],
) -> None:
    """Write ``colours`` [W, H, 3], sRGB; ``table`` is `srgb_table`.

    ``eye`` [3, 4] is from the world to the eye, ``sky_light`` a `light_table`; ``people`` and ``static`` throw shadows.
    """
    width = len(rays.side)
    for strip in prange((width + STRIP - 1) // STRIP):
        for column in range(strip * STRIP, min(width, (strip + 1) * STRIP)):
            _shade_column(
                parts, mesh, looks, placed, rays, eye, sky_light, textures, people, static, seen, table, colours, column
            )


@kernel
def _shade_column(
    parts: Parts,
    mesh: Int32,
    looks: Looks,
    placed: Placed,
    rays: Rays,
    eye: FloatArray,
    sky_light: FloatArray,
    textures: Textures,
    people: ShadowMap,
    static: ShadowMap,
    seen: Seen,
    table: NDArray[np.uint8],
    colours: NDArray[np.uint8],
    column: int,
) -> None:
    """One column; values that are the same for all pixels of a triangle are kept from row to row."""
    nearness, limbs, faces, points = seen.nearness, seen.limbs, seen.faces, placed.points
    light = light_of(sky_light)
    x, z = rays.side[column], rays.ahead[column]
    flat = x * x + z * z
    flat_x, flat_y = eye[0, 0] * x + eye[2, 0] * z, eye[0, 1] * x + eye[2, 1] * z
    flat_z = eye[0, 2] * x + eye[2, 2] * z
    eye_x = -(eye[0, 0] * eye[0, 3] + eye[1, 0] * eye[1, 3] + eye[2, 0] * eye[2, 3])
    eye_y = -(eye[0, 1] * eye[0, 3] + eye[1, 1] * eye[1, 3] + eye[2, 1] * eye[2, 3])
    eye_z = -(eye[0, 2] * eye[0, 3] + eye[1, 2] * eye[1, 3] + eye[2, 2] * eye[2, 3])
    old_limb, old_face, a, b, c, face = -1, -1, 0, 0, 0, 0
    e0 = e1 = e2 = (0.0, 0.0, 0.0)
    for row in range(rays.height):
        up = (rays.horizon - row) / rays.focal
        stretch = math.sqrt(flat + up * up)
        ray_x, ray_y, ray_z = flat_x + eye[1, 0] * up, flat_y + eye[1, 1] * up, flat_z + eye[1, 2] * up
        towards = (-ray_x / stretch, -ray_y / stretch, -ray_z / stretch)
        if nearness[column, row] == 0.0:
            colour = sky_colour(light, -towards[0], -towards[1], -towards[2])
        else:
            limb = limbs[column, row]
            if limb != old_limb or faces[column, row] != old_face:
                old_limb, old_face = limb, faces[column, row]
                part = mesh[limb]
                shift = placed.first[limb] - parts.first_vertex[part]
                face = old_face + parts.first_triangle[part]
                a, b, c = parts.triangles[face, 0], parts.triangles[face, 1], parts.triangles[face, 2]
                e0 = cross(points, b + shift, c + shift)
                e1 = cross(points, c + shift, a + shift)
                e2 = cross(points, a + shift, b + shift)
            w0 = e0[0] * x + e0[1] * up + e0[2] * z
            w1 = e1[0] * x + e1[1] * up + e1[2] * z
            w2 = e2[0] * x + e2[1] * up + e2[2] * z
            total = w0 + w1 + w2
            w0, w1, w2 = w0 / total, w1 / total, w2 / total
            depth = 1.0 / nearness[column, row]
            normal = _blend(parts.normals, a, b, c, w0, w1, w2)  # surroundings are too flat to need more
            if looks.pattern[limb] >= 0:
                normal = _turned(looks.normal, limb, normal)
            facing = normal[0] * towards[0] + normal[1] * towards[1] + normal[2] * towards[2]
            if facing < 0.0 and looks.pattern[limb] < 0:
                normal = (-normal[0], -normal[1], -normal[2])
            dye = looks.colour[limb, 0], looks.colour[limb, 1], looks.colour[limb, 2]
            if looks.pattern[limb] > 0:
                dye = dye_of(looks, limb, parts.vertices, a, b, c, w0, w1, w2)
            albedo = _blend(parts.colours, a, b, c, w0, w1, w2)
            albedo = (albedo[0] * dye[0], albedo[1] * dye[1], albedo[2] * dye[2])
            if parts.layers[face] >= 0:
                spread = depth * stretch * parts.grain[face] / (rays.focal * math.sqrt(max(abs(facing), 0.02)))
                u = w0 * parts.uv[a, 0] + w1 * parts.uv[b, 0] + w2 * parts.uv[c, 0]
                v = w0 * parts.uv[a, 1] + w1 * parts.uv[b, 1] + w2 * parts.uv[c, 1]
                paint = read_texture(textures, parts.layers[face], u, v, spread)
                albedo = (albedo[0] * paint[0], albedo[1] * paint[1], albedo[2] * paint[2])
            world = (eye_x + depth * ray_x, eye_y + depth * ray_y, eye_z + depth * ray_z)
            sun = 0.0
            if normal[0] * light.sun[0] + normal[1] * light.sun[1] + normal[2] * light.sun[2] > 0.0:
                sun = _sun_at(people, world, normal, 0.03, 0.03)
                if sun > 0.0:
                    sun *= _sun_at(static, world, normal, 2.0 / static.scale, 0.06)
            sky = _sky_at(people.open, world, people.x, people.y, 0.25 * people.scale)
            colour = lit(light, albedo, normal, towards, looks.gloss[limb], sun, sky)
            colour = through_air(light, colour, depth * stretch)
        colours[column, row, 0] = encode(colour[0], table)
        colours[column, row, 1] = encode(colour[1], table)
        colours[column, row, 2] = encode(colour[2], table)


@kernel
def _sun_at(shadows: ShadowMap, point: Colour, normal: Colour, lift: float, slack: float) -> float:
    """Share of the sun at a point, looked up ``lift`` m above its surface and ``slack`` m higher along the ray."""
    height = point[2] + lift * normal[2]
    u = (point[0] + lift * normal[0] + shadows.slope_x * height - shadows.x) * shadows.scale
    v = (point[1] + lift * normal[1] + shadows.slope_y * height - shadows.y) * shadows.scale
    return sun_share(shadows.heights, u, v, height + slack)


@kernel
def _sky_at(openness: Float32, point: Colour, x: float, y: float, scale: float) -> float:
    """Share of the sky that a point sees past the feet next to it."""
    if point[2] >= OVER_GROUND:
        return 1.0
    share = smooth_value(openness, (point[0] - x) * scale, (point[1] - y) * scale)
    return share + (1.0 - share) * min(max(point[2] / OVER_GROUND, 0.0), 1.0)


@kernel
def _blend(values: Float32, a: int, b: int, c: int, w0: float, w1: float, w2: float) -> Colour:
    """Three numbers of the corners, weighted."""
    return (
        w0 * values[a, 0] + w1 * values[b, 0] + w2 * values[c, 0],
        w0 * values[a, 1] + w1 * values[b, 1] + w2 * values[c, 1],
        w0 * values[a, 2] + w1 * values[b, 2] + w2 * values[c, 2],
    )


@kernel
def _turned(turn: Float32, limb: int, normal: Colour) -> Colour:
    x = turn[limb, 0, 0] * normal[0] + turn[limb, 0, 1] * normal[1] + turn[limb, 0, 2] * normal[2]
    y = turn[limb, 1, 0] * normal[0] + turn[limb, 1, 1] * normal[1] + turn[limb, 1, 2] * normal[2]
    z = turn[limb, 2, 0] * normal[0] + turn[limb, 2, 1] * normal[1] + turn[limb, 2, 2] * normal[2]
    length = math.sqrt(x * x + y * y + z * z) + 1e-20
    return x / length, y / length, z / length


@kernel
def dye_of(
    looks: Looks, limb: int, vertices: Float32, a: int, b: int, c: int, w0: float, w1: float, w2: float
) -> Colour:
    """The dye of a limb at a point of the triangle (a, b, c), by its weights."""
    if looks.pattern[limb] > 0 and _patterned(looks.pattern[limb], _blend(vertices, a, b, c, w0, w1, w2)):
        dye = looks.second_colour
    else:
        dye = looks.colour
    return dye[limb, 0], dye[limb, 1], dye[limb, 2]


@kernel
def _patterned(pattern: int, point: Colour) -> bool:
    """Whether a limb shows its second colour at a point of its frame; see `Pattern`."""
    if pattern == RINGS:
        return _low(RINGS_PER_M * point[2])
    if pattern == STRIPES:
        return _low(STRIPES_ROUND * math.atan2(point[1], point[0]) / (2.0 * math.pi))
    if pattern == CHECKS:
        return _low(CHECKS_PER_M * point[0]) != _low(CHECKS_PER_M * point[2])
    return pattern == LOWER_HALF and point[2] < 0.0


@kernel
def _low(value: float) -> bool:
    return value - math.floor(value) < 0.5
