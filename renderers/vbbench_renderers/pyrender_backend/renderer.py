"""Backend ``pyrender``: off-screen through EGL or OSMesa; ids and depth come from the segmentation pass.

Depth and ids of the colour pass would be mixed from several samples at silhouettes.
"""

from typing import Any

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers.pyrender_backend.loading import device_name, load_pyrender, open_off_screen
from vbbench_renderers.pyrender_backend.stage import Stage
from vbbench_renderers.views import assemble


class PyrenderRenderer:
    """Draws a scene with pyrender; a `vbbench.pictures.rendering.Renderer`.

    Parameters
    ----------
    scene : its people are drawn.
    seed : of looks and surroundings.
    surroundings : draw façades, trees and furniture; otherwise ground and sky only.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        self._scene = scene
        self._screen: Any = open_off_screen(64, 64)
        self._device = device_name()
        self._stage = Stage(scene, seed, surroundings)

    @property
    def device(self) -> str:
        """See `vbbench.pictures.rendering.Renderer`."""
        return self._device

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer`."""
        if self._screen is None:
            raise VbbenchError("this renderer was closed")
        pose = np.asarray(pose, np.float64)
        without = None if observer is None else self._scene.column_of(observer)
        self._stage.set_people(frame, pose, camera.focal, without)
        return self._shoot(camera, pose) if camera.intrinsics is not None else assemble(camera, pose, self._shoot)

    def close(self) -> None:
        """Give back the context."""
        if self._screen is not None:
            self._screen.delete()
            self._screen = None

    def _shoot(self, camera: Camera, pose: FloatArray) -> Picture:
        """What a pinhole sees."""
        self._screen.viewport_width, self._screen.viewport_height = camera.picture_size
        self._stage.set_camera(camera, pose)
        scene, flags = self._stage.scene, load_pyrender().RenderFlags
        rgb, _ = self._screen.render(scene, flags=flags.NONE)
        codes, depth = self._screen.render(scene, flags=flags.SEG, seg_node_map=self._stage.codes)
        rows = codes.astype(np.int32) @ np.array([65536, 256, 1], np.int32)
        empty = depth == 0.0
        depth = np.where(empty, np.inf, depth).astype(np.float32)
        ids = np.append(NOBODY, self._scene.people).astype(np.int32)[rows]
        return Picture(rgb=self._stage.with_sky(rgb, empty, camera, pose), depth=depth, ids=ids)
