"""The extension module: sources in ``renderers/cpp``, built by ``CMakeLists.txt``.

Arrays are in C order, of float32 and int32, or float64 and uint8 where it says so. Anything else is a
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

    def __init__(self, meshes: Sequence[Mesh]) -> None: ...

def cast_shadows(meshes: Meshes, mesh: Int32, joined: FloatArray, texels: int, threads: int) -> Float32:
    """Heights [S, S] in m along the sun's rays, of N limbs of the meshes ``mesh`` [N].

    ``joined`` [N, 3, 4] float64 is from the limb's frame to texel column, row and m; ``texels`` is S. Pictures do not
    depend on the threads.
    """

def draw(
    meshes: Meshes, limbs: Limbs, placement: Placement, rays: Rays, scenery: Scenery, threads: int
) -> tuple[NDArray[np.uint8], Float32, Int32]:
    """The picture of limbs: sRGB [H, W, 3], depth [H, W] in m and ids [H, W]."""
