"""Shadow maps along the sun, and how much light reaches the ground under feet.

A map is a grid on the ground. A point is entered where the sun's ray through it meets the ground, with its height;
a texel keeps the greatest height, and what lies deeper on the same ray is in the shade.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers import _core
from vbbench_renderers.drawing import FOOT_HEIGHT, Limbs
from vbbench_renderers.mesh import Float32, Int32
from vbbench_renderers.raster.parts import Parts


class ShadowMap(NamedTuple):
    """Heights along the sun's rays.

    Parameters
    ----------
    heights : [S, S] in m; row is y, column is x.
    open : [S, S] share of the sky that the ground sees, 0 … 1.
    x, y : the ground point at the outer corner of texel (0, 0), in m.
    scale : texels a metre.
    slope_x, slope_y : ground metres a metre of height, away from the sun.
    """

    heights: Float32
    open: Float32
    x: float
    y: float
    scale: float
    slope_x: float
    slope_y: float


def draw_map(
    parts: Parts, limbs: Limbs, mesh: Int32, sun: FloatArray, centre: FloatArray, half: float, texels: int
) -> ShadowMap:
    """The map of some limbs around a ground point.

    Parameters
    ----------
    parts : meshes.
    limbs : what throws shadows.
    mesh : [N] which meshes throw the limbs' shadows: coarse ones will do.
    sun : [3] towards the sun.
    centre : [2] middle of the map; taken to whole texels, so that shadows do not crawl.
    half : half the width of the map in m.
    texels : S.
    """
    scale = texels / (2.0 * half)
    x, y = np.round(np.asarray(centre) * scale) / scale - half
    shear = np.array([[1.0, 0.0, -sun[0] / sun[2]], [0.0, 1.0, -sun[1] / sun[2]], [0.0, 0.0, 1.0]])
    joined = np.matmul(shear, limbs.transform.astype(np.float64))
    joined[:, 0, 3] -= x
    joined[:, 1, 3] -= y
    joined[:, :2] *= scale
    heights = _core.shadow_heights(parts.core, mesh, joined, texels, _core.available_threads())
    openness = np.ones((texels // 4, texels // 4), np.float32)
    return ShadowMap(heights, openness, float(x), float(y), scale, float(shear[0, 2]), float(shear[1, 2]))


def darken_contacts(shadows: ShadowMap, limbs: Limbs) -> None:
    """Spots in ``shadows.open``: one under each foot, a wide one under each body."""
    if len(limbs.person):
        centres = limbs.transform[:, :, 3]
        feet = centres[centres[:, 2] < FOOT_HEIGHT]
        starts = np.flatnonzero(np.diff(limbs.person, prepend=-1))
        bodies = np.add.reduceat(centres, starts) / np.diff(starts, append=len(centres))[:, None]
        near = np.column_stack((feet[:, :2], np.full(len(feet), 0.22), 0.55 - feet[:, 2]))
        wide = np.column_stack((bodies[:, :2], np.full(len(bodies), 0.6), np.full(len(bodies), 0.45)))
        _core.stain(np.concatenate([near, wide]), shadows.x, shadows.y, shadows.scale / 4, shadows.open)
