"""Backend ``raster``, without a GPU: exact rays, a z-buffer and deferred shading, on all cores, in C++."""

from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers import _core
from vbbench_renderers.meshes import (
    Float32,
    Int32,
    Limbs,
    Mesh,
    Parts,
    Sky,
    Surroundings,
    join_parts,
    linear_to_srgb,
    split_mesh,
    srgb_to_linear,
)
from vbbench_renderers.people import Walkers
from vbbench_renderers.surroundings import surroundings_of
from vbbench_renderers.views import Rays, assemble, camera_rays, drawn_natively, eye_transform

SHADOW_HALF_WIDTH, SHADOW_AHEAD = 16.0, 12.0
"""Half the width (m) of the square in which people cast shadows, and how far it is ahead of a camera that looks in one
way."""
LARGEST_SHADOW_HALF_WIDTH = 80.0
"""The largest half width (m) of the same square for objects that do not move."""
FOOT_HEIGHT = 0.3
"""Limbs centred below this height (m) darken the ground under them."""
SHADOW_TEXELS, FIXED_SHADOW_TEXELS = 1024, 2048
"""Width of the shadow maps of people and of objects that do not move."""
SRGB_STEPS = 4096


class RasterRenderer:
    """A `vbbench.pictures.rendering.Renderer` that casts exact rays. The picture does not depend on the threads.

    Parameters
    ----------
    scene : its people are drawn.
    seed : of looks and surroundings.
    surroundings : draw houses, trees and lamps; otherwise ground and sky only.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        self._scene = scene
        self._drawer = Drawer(Walkers(scene, seed), surroundings_of(scene, seed, plain=not surroundings))

    @property
    def device(self) -> str:
        """See `vbbench.pictures.rendering.Renderer`."""
        return f"processor, {_core.available_threads()} threads"

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer`."""
        without = None if observer is None else self._scene.column_of(observer)
        shoot = partial(self._drawer.draw, frame, camera.focal, self._scene, without)
        return shoot(camera, pose) if drawn_natively(camera) else assemble(camera, pose, shoot)

    def close(self) -> None:
        """Nothing is held."""


class People(Protocol):
    """The people who are drawn: `vbbench_renderers.people.Walkers`."""

    meshes: tuple[Mesh, ...]
    """Limb meshes of all levels of detail, the finest level first."""
    levels: int

    def limbs(self, frame: int, eye: FloatArray, focal: float, *, without: int | None = None) -> Limbs:
        """Limbs of a frame, as a camera at ``eye`` [2] sees them, except of the person in column ``without``."""


class Drawer:
    """Draws people and surroundings from any source."""

    def __init__(self, people: People, surroundings: Surroundings) -> None:
        pieces = split_mesh(surroundings.mesh)
        self._people = people
        self._parts = join_parts([*people.meshes, *pieces])
        self._light, self._table = light_table(surroundings.sky), srgb_table()
        self._textures = build_textures(surroundings.textures)
        self._static = _static_limbs(len(people.meshes), len(pieces))
        self._static_shadows = self._draw_static_shadows(surroundings.mesh.vertices)

    def draw(
        self, frame: int, focal: float, scene: Scene, without: int | None, camera: Camera, pose: FloatArray
    ) -> Picture:
        """The picture of a frame by a pinhole or an upright cylinder, without the person in column ``without``.

        A focal length of ``focal`` px decides people's level of detail.
        """
        rays, eye = camera_rays(camera), eye_transform(camera, pose)
        people = self._people.limbs(frame, np.asarray(pose[:2], np.float64), focal, without=without)
        limbs = Limbs(**{k: np.concatenate([getattr(people, k), v]) for k, v in vars(self._static).items()})
        ids = np.append(scene.people, NOBODY)[limbs.person]
        rgb, depth, owners = place(self._parts, limbs, limbs.pattern < 0, eye, rays).draw(
            self._order(limbs, eye),
            looks_of(limbs),
            eye,
            self._light,
            self._textures,
            self._people_shadows(people, pose, rays.closed),
            self._static_shadows,
            self._table,
            np.append(ids, NOBODY - 1).astype(np.int32),
        )
        return Picture(rgb=rgb, depth=depth, ids=owners)

    def _people_shadows(self, people: Limbs, pose: FloatArray, around: bool) -> "ShadowMap":
        """Shadows near the camera, or near a point ahead of a camera that looks in one direction."""
        heading = np.array([np.cos(pose[2]), np.sin(pose[2])])
        centre = np.asarray(pose[:2], np.float64) + (0.0 if around else SHADOW_AHEAD) * heading
        chosen = people.of(np.abs(people.transform[:, :2, 3] - centre).max(axis=1) < SHADOW_HALF_WIDTH + 2.0)
        levels, kinds = self._people.levels, len(self._people.meshes) // self._people.levels
        coarse = chosen.mesh % kinds + (levels - 1) * kinds
        shadows = draw_map(self._parts, chosen, coarse, self._light[0], centre, SHADOW_HALF_WIDTH, SHADOW_TEXELS)
        darken_contacts(shadows, chosen)
        return shadows

    def _draw_static_shadows(self, vertices: Float32) -> "ShadowMap":
        low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
        half = min(float((high - low).max()) / 2, LARGEST_SHADOW_HALF_WIDTH)
        sun, centre = self._light[0], 0.5 * (low + high)
        return draw_map(self._parts, self._static, self._static.mesh, sun, centre, half, FIXED_SHADOW_TEXELS)

    def _order(self, limbs: Limbs, eye: FloatArray) -> Int32:
        """Near limbs first."""
        centres = self._parts.spheres[limbs.mesh, :3, None]
        places = (limbs.transform[:, :, :3] @ centres)[..., 0] + limbs.transform[:, :, 3]
        away = np.linalg.norm(places @ eye[:, :3].T + eye[:, 3], axis=1)
        return np.argsort(away, kind="stable").astype(np.int32)


def _static_limbs(first: int, count: int) -> Limbs:
    white, number = np.ones((count, 3), np.float32), np.zeros(count, np.int32)
    return Limbs(
        mesh=np.arange(first, first + count, dtype=np.int32),
        transform=np.tile(np.eye(3, 4, dtype=np.float32), (count, 1, 1)),
        colour=white,
        second_colour=white,
        pattern=number - 1,  # seen from both sides
        gloss=np.zeros(count, np.float32),
        person=number + NOBODY,
    )


def place(parts: Parts, limbs: Limbs, both: BoolArray, eye: FloatArray, rays: Rays) -> _core.Frame:
    """Limbs in eye coordinates, with the columns that they may cover.

    Parameters
    ----------
    parts : meshes.
    limbs : of these meshes.
    both : [N] whether triangles are drawn from behind, too.
    eye : [3, 4] from the world to eye coordinates.
    rays : of the camera.
    """
    joined = np.matmul(eye[:, :3], limbs.transform.astype(np.float64))
    joined[:, :, 3] += eye[:, 3]
    side = np.where(both, 0, -np.sign(np.linalg.det(joined[:, :, :3]))).astype(np.int32)  # the eye's are left-handed
    return _core.Frame(parts.core, limbs.mesh, joined, side, rays, _core.available_threads())


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


def looks_of(limbs: Limbs) -> Looks:
    """Looks of limbs. Normals turn with the cofactors of A, so that they stay normal however A shears."""
    a, b, c = limbs.transform[:, :, 0], limbs.transform[:, :, 1], limbs.transform[:, :, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    outward = np.sign(np.einsum("ni,ni->n", a, cofactors[:, :, 0]))[:, None, None]
    normal = np.ascontiguousarray(cofactors * outward, np.float32)
    return Looks(limbs.colour, limbs.second_colour, limbs.pattern, limbs.gloss, normal)


def light_table(sky: Sky) -> FloatArray:
    """[6, 3] the direction and colour of the sun, zenith, horizon, the glow of the ground, and the haze's distance."""
    haze = np.full(3, sky.haze_distance)
    return np.array([sky.sun_direction, sky.sun_colour, sky.zenith, sky.horizon, sky.ground_glow, haze], np.float64)


class Textures(NamedTuple):
    """L layers of S x S texels at every size S, S/2 … 1.

    Parameters
    ----------
    texels : [sum of L S²] colours of 3 bytes, sRGB; size after size, layer after layer, row after row.
    first : [levels] where each size begins.
    size : [levels] S of each.
    linear : [256] linear value of an sRGB byte.
    """

    texels: NDArray[np.uint8]
    first: IntArray
    size: IntArray
    linear: Float32


def build_textures(layers: NDArray[np.uint8]) -> Textures:
    """Layers [L, S, S, 3] with their smaller sizes, each a mean of 2 x 2 texels in linear light."""
    linear = srgb_to_linear(np.arange(256, dtype=np.float32) / 255.0)
    levels = [layers]
    while levels[-1].shape[1] > 1:
        half = levels[-1].shape[1] // 2
        fine = linear[levels[-1][:, : 2 * half, : 2 * half]]
        mean = fine.reshape(len(layers), half, 2, half, 2, 3).mean(axis=(2, 4), dtype=np.float32)
        levels.append(np.round(255.0 * linear_to_srgb(mean)).astype(np.uint8))
    first = np.cumsum([0, *(level.size // 3 for level in levels[:-1])])
    size = np.array([level.shape[1] for level in levels])
    return Textures(np.concatenate([level.reshape(-1, 3) for level in levels]), first, size, linear)


def srgb_table() -> NDArray[np.uint8]:
    """[SRGB_STEPS + 1] sRGB bytes of linear values in 0 … 1."""
    values = linear_to_srgb(np.linspace(0.0, 1.0, SRGB_STEPS + 1, dtype=np.float32))
    return np.asarray(np.round(255.0 * values), np.uint8)


class ShadowMap(NamedTuple):
    """Heights along the sun's rays.

    A point is entered where the sun's ray through it meets the ground, with its height; a texel keeps the greatest
    height, and what lies deeper on the same ray is in the shade.

    Parameters
    ----------
    heights : [S, S] in m; row is y, column is x.
    highest : [S / 16, S / 16] of each block of texels.
    open : [S, S] share of the sky that the ground sees, 0 … 1.
    x, y : the ground point at the outer corner of texel (0, 0), in m.
    scale : texels a metre.
    slope_x, slope_y : ground metres a metre of height, away from the sun.
    """

    heights: Float32
    highest: Float32
    open: Float32
    x: float
    y: float
    scale: float
    slope_x: float
    slope_y: float


def draw_map(
    parts: Parts, limbs: Limbs, mesh: Int32, sun: FloatArray, centre: FloatArray, half: float, texels: int
) -> ShadowMap:
    """The map of some limbs around a ground point.

    Parameters
    ----------
    parts : meshes.
    limbs : what throws shadows.
    mesh : [N] which meshes throw the limbs' shadows: coarse ones will do.
    sun : [3] towards the sun.
    centre : [2] middle of the map; taken to whole texels, so that shadows do not crawl.
    half : half the width of the map in m.
    texels : S.
    """
    scale = texels / (2.0 * half)
    x, y = np.round(np.asarray(centre) * scale) / scale - half
    shear = np.array([[1.0, 0.0, -sun[0] / sun[2]], [0.0, 1.0, -sun[1] / sun[2]], [0.0, 0.0, 1.0]])
    joined = np.matmul(shear, limbs.transform.astype(np.float64))
    joined[:, 0, 3] -= x
    joined[:, 1, 3] -= y
    joined[:, :2] *= scale
    heights, highest = _core.shadow_heights(parts.core, mesh, joined, texels, _core.available_threads())
    openness = np.ones((texels // 4, texels // 4), np.float32)
    return ShadowMap(heights, highest, openness, float(x), float(y), scale, float(shear[0, 2]), float(shear[1, 2]))


def darken_contacts(shadows: ShadowMap, limbs: Limbs) -> None:
    """Spots in ``shadows.open``: one under each foot, a wide one under each body."""
    if len(limbs.person):
        centres = limbs.transform[:, :, 3]
        feet = centres[centres[:, 2] < FOOT_HEIGHT]
        starts = np.flatnonzero(np.diff(limbs.person, prepend=-1))
        bodies = np.add.reduceat(centres, starts) / np.diff(starts, append=len(centres))[:, None]
        near = np.column_stack((feet[:, :2], np.full(len(feet), 0.22), 0.55 - feet[:, 2]))
        wide = np.column_stack((bodies[:, :2], np.full(len(bodies), 0.6), np.full(len(bodies), 0.45)))
        _core.stain(np.concatenate([near, wide]), shadows.x, shadows.y, shadows.scale / 4, shadows.open)
