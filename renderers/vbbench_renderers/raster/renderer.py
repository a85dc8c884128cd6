"""Backend ``raster``, without a GPU: exact rays, a z-buffer and deferred shading, on all cores, in C++."""

from functools import partial

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers import _core
from vbbench_renderers.drawing import (
    FIXED_SHADOW_TEXELS,
    LARGEST_SHADOW_HALF_WIDTH,
    SHADOW_AHEAD,
    SHADOW_HALF_WIDTH,
    SHADOW_TEXELS,
    Limbs,
    Surroundings,
)
from vbbench_renderers.mesh import Float32
from vbbench_renderers.raster.crowd import People, joined_library, joined_limbs
from vbbench_renderers.raster.light import light_table, srgb_table
from vbbench_renderers.raster.looks import looks_of
from vbbench_renderers.raster.parts import join_parts, split_mesh
from vbbench_renderers.raster.placing import place
from vbbench_renderers.raster.shadows import ShadowMap, darken_contacts, draw_map
from vbbench_renderers.raster.textures import build_textures
from vbbench_renderers.rays import camera_rays, eye_transform
from vbbench_renderers.views import assemble, drawn_natively


class RasterRenderer:
    """A `vbbench.pictures.rendering.Renderer` that casts exact rays. The picture does not depend on the threads.

    Parameters
    ----------
    scene : its people are drawn.
    seed : of looks and surroundings.
    surroundings : draw façades, trees and furniture; otherwise ground and sky only.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        from vbbench_renderers.people import Walkers
        from vbbench_renderers.surroundings import surroundings_of

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


class Drawer:
    """Draws people and surroundings from any source."""

    def __init__(self, people: People, surroundings: Surroundings) -> None:
        library, pieces = joined_library(people), split_mesh(surroundings.mesh)
        self._people = people
        self._parts = join_parts([*library, *pieces])
        self._light, self._table = light_table(surroundings.sky), srgb_table()
        self._textures = build_textures(surroundings.textures)
        self._static = _static_limbs(len(library), len(pieces))
        self._meshes = len(people.library(0))
        self._static_shadows = self._draw_static_shadows(surroundings.mesh.vertices)

    def draw(
        self, frame: int, focal: float, scene: Scene, without: int | None, camera: Camera, pose: FloatArray
    ) -> Picture:
        """The picture of a frame by a pinhole or an upright cylinder, without the person in column ``without``.

        A focal length of ``focal`` px decides people's level of detail.
        """
        rays, eye = camera_rays(camera), eye_transform(camera, pose)
        people = joined_limbs(self._people, frame, np.asarray(pose[:2], np.float64), focal, without)
        limbs = Limbs(**{k: np.concatenate([getattr(people, k), v]) for k, v in vars(self._static).items()})
        frame_of_limbs = place(self._parts, limbs.mesh, limbs.transform, limbs.pattern < 0, eye, rays)
        ids = np.append(scene.people, NOBODY)[limbs.person]
        rgb, depth, owners = frame_of_limbs.draw(
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

    def _people_shadows(self, people: Limbs, pose: FloatArray, around: bool) -> ShadowMap:
        """Shadows near the camera, or near a point ahead of a camera that looks in one direction."""
        heading = np.array([np.cos(pose[2]), np.sin(pose[2])])
        centre = np.asarray(pose[:2], np.float64) + (0.0 if around else SHADOW_AHEAD) * heading
        near = np.abs(people.transform[:, :2, 3] - centre).max(axis=1, initial=0.0) < SHADOW_HALF_WIDTH + 2.0
        chosen = Limbs(**{name: values[near] for name, values in vars(people).items()})
        coarse = chosen.mesh % self._meshes + (self._people.levels - 1) * self._meshes
        sun = self._light[0]
        shadows = draw_map(self._parts, chosen, coarse, sun, centre, SHADOW_HALF_WIDTH, SHADOW_TEXELS)
        darken_contacts(shadows, chosen)
        return shadows

    def _draw_static_shadows(self, vertices: Float32) -> ShadowMap:
        low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
        half = min(float((high - low).max()) / 2, LARGEST_SHADOW_HALF_WIDTH)
        sun, centre = self._light[0], 0.5 * (low + high)
        return draw_map(self._parts, self._static, self._static.mesh, sun, centre, half, FIXED_SHADOW_TEXELS)

    def _order(self, limbs: Limbs, eye: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
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
