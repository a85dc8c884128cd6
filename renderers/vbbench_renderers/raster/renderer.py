"""Backend ``raster``: pictures on processors alone."""

import numpy as np
from numba import get_num_threads

from vbbench.arrays import FloatArray
from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.renderer import NOBODY, Picture
from vbbench.scene import Scene
from vbbench_renderers.drawing import Limbs, Sky, Surroundings
from vbbench_renderers.mesh import Float32
from vbbench_renderers.raster.crowd import People, joined_library, joined_limbs
from vbbench_renderers.raster.filling import fill
from vbbench_renderers.raster.parts import join_parts, split_mesh
from vbbench_renderers.raster.placing import place
from vbbench_renderers.raster.rays import camera_rays, eye_transform
from vbbench_renderers.raster.shading import SRGB_STEPS, Light, Looks, shade
from vbbench_renderers.raster.textures import build_textures, linear_to_srgb


class RasterRenderer:
    """Draws a scene with exact rays; a `vbbench.renderer.Renderer`. The picture does not depend on the threads.

    Parameters
    ----------
    scene : its people are drawn.
    seed : of looks and surroundings.
    surroundings : draw façades, trees and furniture; otherwise ground and sky only.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        from vbbench_renderers.people import Walkers
        from vbbench_renderers.surroundings import build_surroundings, plain_surroundings

        area = walking_area(scene)
        around = build_surroundings(area, seed) if surroundings else plain_surroundings(area)
        self._scene = scene
        self._drawer = Drawer(Walkers(scene, seed), around)

    @property
    def device(self) -> str:
        """See `vbbench.renderer.Renderer`."""
        return f"processor, {get_num_threads()} threads (numba)"

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.renderer.Renderer`."""
        return self._drawer.draw(frame, camera, pose, self._scene, column_of(self._scene, observer))

    def close(self) -> None:
        """Nothing is held."""


def walking_area(scene: Scene) -> tuple[float, float, float, float]:
    """(x0, y0, x1, y1) in m around everybody's path; a small one around the origin if nobody comes."""
    places = scene.positions[scene.present]
    if len(places) == 0:
        return -1.0, -1.0, 1.0, 1.0
    (x0, y0), (x1, y1) = places.min(axis=0).tolist(), places.max(axis=0).tolist()
    return x0, y0, x1, y1


def column_of(scene: Scene, observer: int | None) -> int | None:
    """The scene's column of a person.

    Raises
    ------
    VbbenchError
        If nobody has this id.
    """
    if observer is None:
        return None
    column = int(np.searchsorted(scene.people, observer))
    if column == len(scene.people) or scene.people[column] != observer:
        raise VbbenchError(f"scene '{scene.name}' has no person {observer}")
    return column


class Drawer:
    """Draws people and surroundings, whoever made them."""

    def __init__(self, people: People, surroundings: Surroundings) -> None:
        library, pieces = joined_library(people), split_mesh(surroundings.mesh)
        self._people = people
        self._parts = join_parts([*library, *pieces])
        self._light = _light(surroundings.sky)
        self._textures = build_textures(surroundings.textures)
        self._static = _static_limbs(len(library), len(pieces))

    def draw(self, frame: int, camera: Camera, pose: FloatArray, scene: Scene, without: int | None) -> Picture:
        """The picture of a frame, without the person in column ``without``."""
        rays, eye = camera_rays(camera), eye_transform(camera, pose)
        people = joined_limbs(self._people, frame, np.asarray(pose[:2], np.float64), without)
        limbs = Limbs(**{k: np.concatenate([getattr(people, k), v]) for k, v in vars(self._static).items()})
        placed = place(self._parts, limbs.mesh, limbs.transform, eye, rays)
        shape = len(rays.side), rays.height
        nearness, seen, faces = np.empty(shape, np.float32), np.empty(shape, np.int32), np.empty(shape, np.int32)
        fill(self._parts, limbs.mesh, self._order(limbs, eye), placed, rays, nearness, seen, faces)
        colours = np.empty((*shape, 3), np.uint8)
        sunlit = np.ones(shape, np.float32)
        shade(
            self._parts,
            limbs.mesh,
            _looks(limbs),
            placed,
            rays,
            eye,
            self._light,
            self._textures,
            nearness,
            seen,
            faces,
            sunlit,
            colours,
        )
        sky = nearness == 0.0
        owner = np.append(scene.people, NOBODY)[limbs.person]
        ids = np.where(sky, NOBODY, owner[np.where(sky, 0, seen)])
        with np.errstate(divide="ignore"):
            depth = 1.0 / nearness
        return Picture(rgb=colours.transpose(1, 0, 2), depth=depth.T, ids=ids.T)

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
        pattern=number,
        gloss=np.zeros(count, np.float32),
        person=number + NOBODY,
    )


def _looks(limbs: Limbs) -> Looks:
    """Normals turn with the cofactors of A, so that they stay normal however A shears."""
    a, b, c = limbs.transform[:, :, 0], limbs.transform[:, :, 1], limbs.transform[:, :, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    outward = np.sign(np.einsum("ni,ni->n", a, cofactors[:, :, 0]))
    return Looks(
        limbs.colour, limbs.second_colour, limbs.pattern, limbs.gloss, _contiguous(cofactors * outward[:, None, None])
    )


def _contiguous(values: Float32) -> Float32:
    return np.ascontiguousarray(values, np.float32)


def _light(sky: Sky) -> Light:
    steps = np.linspace(0.0, 1.0, SRGB_STEPS + 1, dtype=np.float32)
    bands = (sky.sun_direction, sky.sun_colour, sky.zenith, sky.horizon, sky.ground_glow)
    sun, sun_colour, zenith, horizon, ground_glow = (np.asarray(band, np.float64) for band in bands)
    srgb = np.round(255.0 * linear_to_srgb(steps)).astype(np.uint8)
    return Light(sun, sun_colour, zenith, horizon, ground_glow, float(sky.haze_distance), srgb)
