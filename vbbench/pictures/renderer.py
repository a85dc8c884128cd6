"""What a renderer must offer: pictures of a scene, off-screen. It registers under ``vbbench.renderers``."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench.geometry import FloatArray, frozen_array
from vbbench.scene import Scene

NOBODY = -1
"""The id of pixels that show no person."""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """One rendered frame; row 0 is the top.

    Parameters
    ----------
    rgb : [H, W, 3] uint8, sRGB.
    depth : [H, W] float32 in m: along the optical axis for a pinhole (`Camera.intrinsics`), horizontal range for other
        cameras; infinite in the sky.
    ids : [H, W] int32 person id, `NOBODY` where no person shows.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    ids: NDArray[np.int32]

    def __post_init__(self) -> None:
        size = np.shape(self.ids)
        object.__setattr__(self, "rgb", frozen_array("rgb", self.rgb, (*size, 3), np.uint8))
        object.__setattr__(self, "depth", frozen_array("depth", self.depth, size, np.float32))
        object.__setattr__(self, "ids", frozen_array("ids", self.ids, size, np.int32))


class Renderer(Protocol):
    """Draws the frames of one scene."""

    @property
    def device(self) -> str:
        """What does the drawing, for the log: a GPU, or a processor."""

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """The picture of a scene frame.

        Parameters
        ----------
        frame : frame of the scene.
        camera : its picture has `Camera.picture_size`.
        pose : [3] (x, y, yaw) in m and rad.
        observer : id of the person who carries the camera, who is not drawn.

        Raises
        ------
        VbbenchError
            If the scene has no such frame or observer, or the camera cannot be rendered.
        """

    def close(self) -> None:
        """Give back what the device holds."""


class RendererFactory(Protocol):
    """What an entry point of ``vbbench.renderers`` names."""

    def __call__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> Renderer:
        """A renderer of one scene; looks and surroundings follow from the seed.

        Raises
        ------
        VbbenchError
            If this machine cannot do it; the message says what to install.
        """
