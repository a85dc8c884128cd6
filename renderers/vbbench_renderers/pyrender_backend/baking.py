"""Limbs baked into one mesh per person: one node per limb would cost pyrender ten times the draw calls."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import IntArray
from vbbench_renderers import _core
from vbbench_renderers.drawing import Limbs
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.looks import looks_of
from vbbench_renderers.raster.parts import Parts


class Baked(NamedTuple):
    """The vertices of all limbs in the world, limb after limb.

    Parameters
    ----------
    points, normals, colours : [P, 3]; linear RGB.
    triangles : [F, 3] rows of ``points``.
    first_point, first_triangle : [N + 1] where each limb starts.
    """

    points: Float32
    normals: Float32
    colours: Float32
    triangles: Int32
    first_point: IntArray
    first_triangle: IntArray


def bake(parts: Parts, limbs: Limbs) -> Baked:
    """The limbs' vertices in the world, dyed vertex by vertex."""
    first_point, first_triangle = (
        np.append(0, np.cumsum(np.diff(first)[limbs.mesh])) for first in (parts.first_vertex, parts.first_triangle)
    )
    points, normals, colours, triangles = _core.bake(parts.core, limbs.mesh, limbs.transform, looks_of(limbs))
    return Baked(points, normals, colours, triangles, first_point, first_triangle)
