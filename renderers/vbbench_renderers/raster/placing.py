"""Limbs brought into eye coordinates."""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_renderers import _core
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.parts import Parts
from vbbench_renderers.rays import Rays


def place(parts: Parts, mesh: Int32, transform: Float32, both: BoolArray, eye: FloatArray, rays: Rays) -> _core.Frame:
    """Limbs in eye coordinates, with the columns that they may cover.

    Parameters
    ----------
    parts : meshes.
    mesh : [N] which of them.
    transform : [N, 3, 4] from the limb's frame to the world.
    both : [N] whether triangles are drawn from behind, too.
    eye : [3, 4] from the world to eye coordinates.
    rays : of the camera.
    """
    joined = np.matmul(eye[:, :3], transform.astype(np.float64))
    joined[:, :, 3] += eye[:, 3]
    side = np.where(both, 0, -np.sign(np.linalg.det(joined[:, :, :3]))).astype(np.int32)  # the eye's are left-handed
    return _core.Frame(parts.core, mesh, joined, side, rays, _core.available_threads())
