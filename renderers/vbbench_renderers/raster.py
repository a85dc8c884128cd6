"""Backend ``raster``, without a GPU: exact rays, a z-buffer and deferred shading, on all cores, in C++."""

from collections.abc import Sequence
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
    Sky,
    Surroundings,
    linear_to_srgb,
    split_mesh,
    srgb_to_linear,
)
from vbbench_renderers.people import Walkers
from vbbench_renderers.surroundings import surroundings_of
from vbbench_renderers.views import assemble, camera_rays, eye_transform

SHADOW_HALF_WIDTH, SHADOW_AHEAD = 16.0, 12.0
"""Half the width (m) of the square in which people cast shadows, and how far it is ahead of a camera that looks in one
way."""
LARGEST_SHADOW_HALF_WIDTH = 80.0
"""The largest half width (m) of the same square for objects that do not move."""
FOOT_HEIGHT = 0.3
"""Limbs centred below this height (m) darken the ground under them."""
SHADOW_TEXELS, FIXED_SHADOW_TEXELS = 1024, 2048
"""Width of the shadow maps of people and of objects that do not move."""
SRGB = np.asarray(np.round(255.0 * linear_to_srgb(np.linspace(0.0, 1.0, 4097, dtype=np.float32))), np.uint8)
"""sRGB bytes of linear values in 0 … 1."""
LINEAR = srgb_to_linear(np.arange(256, dtype=np.float32) / 255.0)
"""Linear values of sRGB bytes."""


class People(Protocol):
    """The people who are drawn: `vbbench_renderers.people.Walkers`."""

    meshes: tuple[Mesh, ...]
    """Limb meshes of all levels of detail, the finest level first."""
    levels: int

    def limbs(self, frame: int, eye: FloatArray, focal: float, *, without: int | None = None) -> Limbs:
        """Limbs of a frame, as a camera at ``eye`` [2] sees them, except of the person in column ``without``."""


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


class Placement(NamedTuple):
    """N limbs in front of a camera.

    Parameters
    ----------
    joined : [N, 3, 4] float64, from the limb's frame to eye coordinates.
    side : [N] the side of the triangles that is drawn: 1, −1 where they are clockwise, 0 for both.
    order : [N] in which limbs are drawn; fastest when near ones come first.
    normal : [N, 3, 3] from normals of the limb's frame to normals in the world, of any length.
    owners : [N + 1] id of each limb's person, `vbbench.sequence.NOBODY` for surroundings, less for the sky.
    eye : [3, 4] float64, from the world to eye coordinates.
    """

    joined: FloatArray
    side: Int32
    order: Int32
    normal: Float32
    owners: Int32
    eye: FloatArray


class Shadows(NamedTuple):
    """What limbs keep from the sun and, where they are on the ground, from the sky.

    Parameters
    ----------
    heights : [S, S] in m, the greatest of a texel. A point is entered where the sun's ray through it meets the ground,
        with its height; what lies deeper on the same ray is in the shade.
    open : [S/4, S/4] share of the sky that the ground sees.
    ground : [5] x, y in m at the outer corner of texel (0, 0), texels a metre, and ground metres (x, y) a metre of
        height, away from the sun.
    """

    heights: Float32
    open: Float32
    ground: FloatArray

    def stain(self, spots: FloatArray) -> None:
        """Darken the ground under spots [N, 4]: place and radius in m, and how dark the middle is."""
        scale, size = 0.25 * self.ground[2], len(self.open)
        x, y, radius, dark = spots.T[..., None, None]
        u, v, radius = (x - self.ground[0]) * scale, (y - self.ground[1]) * scale, radius * scale
        reach = np.arange(-np.ceil(radius.max()), np.ceil(radius.max()) + 1.0)
        column, row = np.floor(u) + reach, np.floor(v) + reach[:, None]
        fall = np.maximum(0.0, 1.0 - ((column + 0.5 - u) ** 2 + (row + 0.5 - v) ** 2) / radius**2)
        inside = (fall > 0.0) & (column >= 0.0) & (column < size) & (row >= 0.0) & (row < size)
        texels = tuple(np.broadcast_to(place, fall.shape)[inside].astype(np.int64) for place in (row, column))
        np.multiply.at(self.open, texels, (1.0 - dark * fall * fall)[inside])


class Scenery(NamedTuple):
    """What light limbs are seen in: `light_table`, textures of `halved_sizes`, and what throws shadows.

    Linear values become bytes by the ``table``; bytes of textures become values by ``linear``.
    """

    light: FloatArray
    textures: list[NDArray[np.uint8]]
    people: Shadows
    fixed: Shadows
    table: NDArray[np.uint8] = SRGB
    linear: Float32 = LINEAR


def middles_of(meshes: Sequence[Mesh]) -> Float32:
    """[M, 3] the middle of the box around each mesh."""
    return np.array([(mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2 for mesh in meshes])


def place(middles: Float32, limbs: Limbs, both: BoolArray, eye: FloatArray, owners: IntArray) -> Placement:
    """Limbs in front of a camera; ``both`` [N] whether triangles are drawn from behind, too.

    ``middles`` [M, 3] are of the meshes; ``eye`` and ``owners`` are as in `Placement`.
    """
    joined = np.matmul(eye[:, :3], limbs.transform.astype(np.float64))
    joined[:, :, 3] += eye[:, 3]
    side = np.where(both, 0, -np.sign(np.linalg.det(joined[:, :, :3]))).astype(np.int32)  # the eye's are left-handed
    places = (limbs.transform[:, :, :3] @ middles[limbs.mesh, :, None])[..., 0] + limbs.transform[:, :, 3]
    away = np.linalg.norm(places @ eye[:, :3].T + eye[:, 3], axis=1)
    order = np.argsort(away, kind="stable").astype(np.int32)
    return Placement(joined, side, order, normals_of(limbs), owners.astype(np.int32), eye)


def normals_of(limbs: Limbs) -> Float32:
    """[N, 3, 3] as in `Placement`. Normals turn with the cofactors of A, so that they stay normal however A shears."""
    a, b, c = limbs.transform[:, :, 0], limbs.transform[:, :, 1], limbs.transform[:, :, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    outward = np.sign(np.einsum("ni,ni->n", a, cofactors[:, :, 0]))[:, None, None]
    return np.ascontiguousarray(cofactors * outward, np.float32)


def light_table(sky: Sky) -> FloatArray:
    """[6, 3] the direction and colour of the sun, zenith, horizon, the glow of the ground, and the haze's distance."""
    haze = np.full(3, sky.haze_distance)
    return np.array([sky.sun_direction, sky.sun_colour, sky.zenith, sky.horizon, sky.ground_glow, haze], np.float64)


def halved_sizes(layers: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """Layers [L, S, S, 3] at the sizes S, S/2 … 1, each a mean of 2 x 2 texels in linear light."""
    levels = [layers]
    while levels[-1].shape[1] > 1:
        half = levels[-1].shape[1] // 2
        fine = LINEAR[levels[-1][:, : 2 * half, : 2 * half]]
        mean = fine.reshape(len(layers), half, 2, half, 2, 3).mean(axis=(2, 4), dtype=np.float32)
        levels.append(np.round(255.0 * linear_to_srgb(mean)).astype(np.uint8))
    return levels


def draw_shadows(
    meshes: _core.Meshes, limbs: Limbs, mesh: Int32, sun: FloatArray, centre: FloatArray, half: float, texels: int
) -> Shadows:
    """The shadow map of some limbs around a ground point.

    Parameters
    ----------
    meshes : of the limbs.
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
    ground = np.array([x, y, scale, *shear[:2, 2]])
    heights = _core.cast_shadows(meshes, mesh, joined, texels, _core.available_threads())
    return Shadows(heights, np.ones((texels // 4, texels // 4), np.float32), ground)


def contact_spots(limbs: Limbs) -> FloatArray:
    """[N, 4] place and radius in m, and darkness, of spots on the ground: under each foot, and a wide one a body."""
    centres = limbs.transform[:, :, 3]
    feet = centres[centres[:, 2] < FOOT_HEIGHT]
    starts = np.flatnonzero(np.diff(limbs.person, prepend=-1))
    bodies = np.add.reduceat(centres, starts) / np.diff(starts, append=len(centres))[:, None]
    near = np.column_stack((feet[:, :2], np.full(len(feet), 0.22), 0.55 - feet[:, 2]))
    wide = np.column_stack((bodies[:, :2], np.full(len(bodies), 0.6), np.full(len(bodies), 0.45)))
    return np.concatenate([near, wide]).astype(np.float64)


class Drawer:
    """Draws any people in any surroundings; a `vbbench.pictures.rendering.Renderer`.

    Rays are exact, and the picture does not depend on the threads.
    """

    def __init__(self, scene: Scene, people: People, surroundings: Surroundings) -> None:
        pieces = split_mesh(surroundings.mesh)
        self._scene, self._people = scene, people
        meshes = [*people.meshes, *pieces]
        self._meshes, self._middles = _core.Meshes(meshes), middles_of(meshes)
        self._static = _static_limbs(len(people.meshes), len(pieces))
        self._light, self._textures = light_table(surroundings.sky), halved_sizes(surroundings.textures)
        self._static_shadows = self._draw_static_shadows(surroundings.mesh.vertices)

    @property
    def device(self) -> str:
        """See `vbbench.pictures.rendering.Renderer`."""
        return f"processor, {_core.available_threads()} threads"

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer`."""
        without = None if observer is None else self._scene.column_of(observer)
        shoot = partial(self._shoot, frame, camera.focal, without)
        natively = camera.intrinsics is not None or camera.cylinder is not None
        return shoot(camera, pose) if natively else assemble(camera, pose, shoot)

    def close(self) -> None:
        """Nothing is held."""

    def _shoot(self, frame: int, focal: float, without: int | None, camera: Camera, pose: FloatArray) -> Picture:
        """What a pinhole or an upright cylinder sees, but for the person in column ``without``.

        A focal length of ``focal`` px decides people's level of detail.
        """
        rays, eye = camera_rays(camera), eye_transform(camera, pose)
        people = self._people.limbs(frame, np.asarray(pose[:2], np.float64), focal, without=without)
        limbs = Limbs(**{k: np.concatenate([getattr(people, k), v]) for k, v in vars(self._static).items()})
        ids = np.append(self._scene.people, NOBODY)[limbs.person]
        shadows = self._people_shadows(people, pose, rays.closed)
        scenery = Scenery(self._light, self._textures, shadows, self._static_shadows)
        placement = place(self._middles, limbs, limbs.pattern < 0, eye, np.append(ids, NOBODY - 1))
        threads = _core.available_threads()
        rgb, depth, owners = _core.draw(self._meshes, limbs, placement, rays, scenery, threads)
        return Picture(rgb=rgb, depth=depth, ids=owners)

    def _people_shadows(self, people: Limbs, pose: FloatArray, around: bool) -> Shadows:
        """Shadows near the camera, or near a point ahead of a camera that looks in one direction."""
        heading = np.array([np.cos(pose[2]), np.sin(pose[2])])
        centre = np.asarray(pose[:2], np.float64) + (0.0 if around else SHADOW_AHEAD) * heading
        chosen = people.of(np.abs(people.transform[:, :2, 3] - centre).max(axis=1) < SHADOW_HALF_WIDTH + 2.0)
        levels, kinds = self._people.levels, len(self._people.meshes) // self._people.levels
        coarse = chosen.mesh % kinds + (levels - 1) * kinds
        shadows = draw_shadows(self._meshes, chosen, coarse, self._light[0], centre, SHADOW_HALF_WIDTH, SHADOW_TEXELS)
        if len(chosen.person):
            shadows.stain(contact_spots(chosen))
        return shadows

    def _draw_static_shadows(self, vertices: Float32) -> Shadows:
        low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
        half = min(float((high - low).max()) / 2, LARGEST_SHADOW_HALF_WIDTH)
        sun, centre = self._light[0], 0.5 * (low + high)
        return draw_shadows(self._meshes, self._static, self._static.mesh, sun, centre, half, FIXED_SHADOW_TEXELS)


class RasterRenderer(Drawer):
    """The `Drawer` of a scene's people.

    Parameters
    ----------
    scene : its people are drawn.
    seed : of looks and surroundings.
    surroundings : draw houses, trees and lamps; otherwise ground and sky only.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        super().__init__(scene, Walkers(scene, seed), surroundings_of(scene, seed, plain=not surroundings))
