"""Backend ``raster``: pictures on processors alone."""

import numpy as np
from numba import get_num_threads

from vbbench.arrays import FloatArray
from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.renderer import Picture
from vbbench.scene import Scene
from vbbench_renderers.raster.drawer import Drawer


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
