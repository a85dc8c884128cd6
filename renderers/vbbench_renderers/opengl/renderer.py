"""Backend ``moderngl``: one indirect draw for all limbs, one for everything that stands still, one for the sky."""

from functools import partial
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers.drawing import Limbs
from vbbench_renderers.opengl import light
from vbbench_renderers.opengl.context import device_name, open_context
from vbbench_renderers.opengl.packing import lens
from vbbench_renderers.opengl.probing import find_device
from vbbench_renderers.opengl.stage import Stage
from vbbench_renderers.opengl.targets import Targets
from vbbench_renderers.people import Walkers
from vbbench_renderers.rays import NEAR, tilt_of
from vbbench_renderers.surroundings import surroundings_of
from vbbench_renderers.views import assemble, drawn_natively

if TYPE_CHECKING:
    import moderngl


class OpenGLRenderer:
    """Draws a scene through EGL; see `vbbench.pictures.rendering.Renderer`.

    Parameters
    ----------
    scene : who walks where.
    seed : of looks and surroundings.
    surroundings : False for bare ground and sky.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        find_device()  # a broken driver must not take this process down
        self._scene = scene
        self._walkers = Walkers(scene, seed)
        around = surroundings_of(scene, seed, plain=not surroundings)
        self._ids = np.append(scene.people, NOBODY).astype(np.int32)  # the last is column −1
        self._sky = around.sky
        self._context: moderngl.Context | None = open_context()
        self._device = device_name(self._context)
        with self._context:
            self._stage = Stage(self._context, self._walkers, around)
        self._targets: dict[tuple[int, int], Targets] = {}

    @property
    def device(self) -> str:
        """GL_RENDERER, and that it is software where it is."""
        return self._device

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer.render`."""
        if self._context is None:
            raise VbbenchError("this renderer was closed")
        pose = np.asarray(pose, dtype=np.float64)
        without = None if observer is None else self._scene.column_of(observer)
        drawn = self._walkers.limbs(frame, pose[:2], camera.focal, without=without)
        here = self._scene.present[frame].copy()
        if without is not None:
            here[without] = False
        shoot = partial(self._shoot, self._context, drawn, self._scene.positions[frame][here])
        return shoot(camera, pose) if drawn_natively(camera) else assemble(camera, pose, shoot)

    def _shoot(
        self,
        context: "moderngl.Context",
        drawn: list[tuple[int, Limbs]],
        bodies: FloatArray,
        camera: Camera,
        pose: FloatArray,
    ) -> Picture:
        """What a pinhole or an upright cylinder sees of limbs, by level of detail, of people who are at ``bodies``."""
        size = camera.picture_size
        with context:
            if size not in self._targets:
                self._targets[size] = Targets(context, size, self._stage.fine_place)
            targets = self._targets[size]
            self._stage.draw(targets, self._frame(camera, size, pose), drawn, camera, pose, bodies)
            colours, truth = targets.read(self._stage.compose)
        columns = truth[..., 0].astype(np.int32)
        rgb = cv2.cvtColor(colours, cv2.COLOR_RGBA2RGB).astype(np.uint8, copy=False)
        return Picture(rgb=rgb, depth=truth[..., 1].copy(), ids=self._ids[columns])

    def close(self) -> None:
        """Give back the context and all it holds."""
        if self._context is None:
            return
        self._context.release()  # and all that was made in it
        self._context = None
        del self._stage, self._targets

    def _frame(self, camera: Camera, size: tuple[int, int], pose: FloatArray) -> dict[str, Any]:
        sky, tilt = self._sky, tilt_of(camera)
        return {
            "eye": (*pose[:2], camera.mount_height, NEAR),
            "heading": (np.cos(pose[2]), np.sin(pose[2]), 0.0, 0.0),
            "lens": lens(camera, size),
            "tilt_right": (*tilt[0], 0.0),
            "tilt_down": (*tilt[1], 0.0),
            "tilt_forward": (*tilt[2], 0.0),
            "sun_direction": (*sky.sun_direction, sky.haze_distance),
            "sun_colour": (*sky.sun_colour, 0.0),
            "zenith": (*sky.zenith, 0.0),
            "horizon": (*sky.horizon, 0.0),
            "ground_glow": (*sky.ground_glow, 0.0),
            "window": light.people_window(pose, camera.cylinder is None),
        }
