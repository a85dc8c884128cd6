"""The extension module: sources in ``renderers/cpp``, built by ``CMakeLists.txt``.

Arrays are in C order, of float32 and int32, or float64, int64 and uint8 where it says so. Anything else is a
`VbbenchError`.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Float32, Int32, Limbs, Mesh
from vbbench_renderers.raster import Placement, Scenery
from vbbench_renderers.views import Rays

NEAR: Final[float]

def available_threads() -> int:
    """How many threads this process may run at the same time."""

class Meshes:
    """M meshes, whose indices are checked once."""

    spheres: Float32
    """[M, 4] centre and radius in m of a sphere around each mesh."""

    def __init__(self, meshes: Sequence[Mesh]) -> None: ...

class Textures:
    """L texture layers [L, S, S, 3] uint8 sRGB at the ``sizes`` S, S/2 … 1.

    ``linear`` [256] are the linear values of sRGB bytes.
    """

    def __init__(self, sizes: list[NDArray[np.uint8]], linear: Float32) -> None: ...

class Shadows:
    """Heights of limbs along the sun's rays, and the share of the sky that the ground sees.

    A point is entered where the sun's ray through it meets the ground, with its height; a texel keeps the greatest
    height, and what lies deeper on the same ray is in the shade.

    Parameters
    ----------
    mesh : [N] which of the meshes.
    joined : [N, 3, 4] float64, from the limb's frame to texel column, row and m.
    ground : [5] x, y in m at the outer corner of texel (0, 0), texels a metre, and ground metres (x, y) a metre of
        height, away from the sun.
    texels : S of the map [S, S].
    threads : that work; pictures do not depend on it.
    """

    def __init__(
        self, meshes: Meshes, mesh: Int32, joined: FloatArray, ground: FloatArray, texels: int, threads: int
    ) -> None: ...
    def stain(self, spots: FloatArray) -> None:
        """Darken the ground under spots [N, 4] float64: place and radius in m, and how dark the middle is."""

def draw(
    meshes: Meshes, limbs: Limbs, placement: Placement, rays: Rays, scenery: Scenery, threads: int
) -> tuple[NDArray[np.uint8], Float32, Int32]:
    """The picture of limbs: sRGB [H, W, 3], depth [H, W] in m and ids [H, W]."""
