"""Backend ``raster``: pictures on processors alone."""

from numba import get_num_threads

from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench_renderers.raster.drawer import Drawer


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
        return f"processor, {get_num_threads()} threads (numba)"

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer`."""
        without = None if observer is None else self._scene.column_of(observer)
        return self._drawer.draw(frame, camera, pose, self._scene, without)

    def close(self) -> None:
        """Nothing is held."""
