"""The extension module: sources in ``renderers/cpp``, built by ``CMakeLists.txt``.

Arrays are in C order, of float32 and int32, or float64, int64 and uint8 where it says so. Anything else is a
`VbbenchError`.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Float32, Int32, Parts
from vbbench_renderers.raster import Looks, ShadowMap, Textures
from vbbench_renderers.views import Rays

NEAR: Final[float]

def available_threads() -> int:
    """How many threads this process may run at the same time."""

class Meshes:
    """Meshes whose indices are checked once; the arrays are those of ``parts``."""

    def __init__(self, parts: Parts) -> None: ...

class Frame:
    """Limbs as a camera sees them.

    Parameters
    ----------
    mesh : [N] which of the meshes.
    joined : [N, 3, 4] float64, from the limb's frame to eye coordinates.
    side : [N] the side of the triangles that is drawn: 1, −1 where they are clockwise, 0 for both.
    rays : of the camera.
    threads : that work; pictures do not depend on it.
    """

    def __init__(
        self, meshes: Meshes, mesh: Int32, joined: FloatArray, side: Int32, rays: Rays, threads: int
    ) -> None: ...
    def draw(
        self,
        order: Int32,
        looks: Looks,
        eye: FloatArray,
        light: FloatArray,
        textures: Textures,
        people: ShadowMap,
        fixed: ShadowMap,
        table: NDArray[np.uint8],
        owners: Int32,
    ) -> tuple[NDArray[np.uint8], Float32, Int32]:
        """The picture: sRGB [H, W, 3], depth [H, W] in m and ids [H, W].

        Parameters
        ----------
        order : [N] in which limbs are drawn; fastest when near ones come first.
        looks : of the limbs.
        eye : [3, 4] float64, from the world to eye coordinates.
        light, table : `vbbench_renderers.raster.light_table` and ``srgb_table``.
        textures : of the meshes.
        people, fixed : what throws shadows.
        owners : [N + 1] id of each limb's person, `vbbench.sequence.NOBODY` for surroundings, less for the sky.
        """

def shadow_heights(
    meshes: Meshes, mesh: Int32, joined: FloatArray, texels: int, threads: int
) -> tuple[Float32, Float32]:
    """[S, S] heights of limbs along the sun's rays, and the highest of each block of 16 x 16 texels.

    ``joined`` [N, 3, 4] float64 is to texel column, row and m.
    """

def stain(spots: FloatArray, x: float, y: float, scale: float, openness: Float32) -> None:
    """Darken ``openness`` [S, S], of which ``scale`` are a metre from x, y on, under spots.

    ``spots`` [N, 4] float64 are place and radius in m, and how dark the middle is.
    """
