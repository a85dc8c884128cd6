"""Limb meshes below the head, clothed or bare, in the frames that `vbbench_renderers.people.skeleton` poses."""

from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.people.loft import ALONG_X, Detail, Section, finish, loft, turned
from vbbench_renderers.people.measures import HIPS, JOINT_CAPS, LIMBS, PALM, SHOES, SOLE, THUMB, TORSOS

TRUNK: Detail = ((16, 10), (10, 5), (6, 4))
HIP: Detail = ((12, 4), (7, 3), (6, 2))
LIMB: Detail = ((8, 4), (5, 3), (4, 2))
HAND: Detail = ((6, 5), (4, 3), (3, 2))
MID_TORSO = 0.24
"""Height in m of the origin of the torso meshes over that of the chest; two-coloured shirts change colour there."""
NECKLINE = 0.45
"""Slope of the neckline: it is lower in front."""
SHOE: Detail = ((8, 7), (6, 4), (4, 3))


def limb(
    sections: list[Section], detail: Detail, caps: tuple[float, float], ripple: float, power: float, level: int
) -> Mesh:
    """A limb along z, darker towards its joints; folds show at the finest level only."""
    if level == 2:  # without rings in the caps a limb would end in spikes
        caps = (0.4 * caps[0], 0.4 * caps[1])
    solid = loft(sections, detail[level], caps=caps, ripple=ripple if level == 0 else 0.0, power=power)
    return finish(solid, paint=_shade_ends)


def trunk(sections: list[Section], level: int) -> Mesh:
    """A torso, darker under the arms and towards the hem, where less of the sky reaches."""
    solid = loft(sections, TRUNK[level], caps=(0.004, 0.01), power=2.4, ripple=0.012 if level == 0 else 0.0)
    points = np.array(solid.vertices)
    points[:, 2] -= NECKLINE * points[:, 0] * np.clip((points[:, 2] - 0.44) / 0.08, 0.0, 1.0)
    points[:, 2] -= MID_TORSO
    return finish(trimesh.Trimesh(points, solid.faces, process=False), paint=_shade_sides)


def hand(side: float, level: int) -> Mesh:
    """A hand that hangs, its palm to the thigh and its fingers a little bent; side is 1 for the left."""
    palm = loft(PALM, HAND[level], caps=(0.015, 0.01))
    if level > 0:
        return finish(palm)
    thumb = loft([(z, x, f, b, w) for z, x, f, b, w in THUMB], (4, 3), caps=(0.01, 0.01))
    return finish(palm, turned(thumb, np.eye(3), (0.0, -0.008 * side, 0.0)))


def shoe(name: str, level: int) -> Mesh:
    """A shoe in the frame of the foot: x to the toes, the ankle at the origin."""
    solid = loft(SHOES[name], SHOE[level], caps=(0.006, 0.010), power=2.8)
    return finish(turned(solid, ALONG_X, (0.0, 0.0, 0.0)))


def sole(level: int) -> Mesh:
    """The rubber under a sports shoe."""
    solid = loft(SOLE, SHOE[level], caps=(0.004, 0.004), power=4.0)
    return finish(turned(solid, ALONG_X, (0.0, 0.0, 0.0)))


def _shade_ends(vertices: FloatArray) -> FloatArray:
    z = vertices[:, 2] / np.abs(vertices[:, 2]).max()
    return np.repeat((1.0 - 0.16 * z[:, None] ** 6), 3, axis=1)


def _shade_sides(vertices: FloatArray) -> FloatArray:
    z = vertices[:, 2] + MID_TORSO
    under_arm = np.clip(np.abs(vertices[:, 1]) / 0.17 - 0.55, 0.0, 0.5) * np.clip((0.42 - z) / 0.1, 0.0, 1.0)
    shade: FloatArray = 1.0 - 0.45 * under_arm - 0.12 * np.clip(-z / 0.12, 0.0, 1.0)
    return np.repeat(shade[:, None], 3, axis=1)


def body_meshes() -> dict[str, Callable[[int], Mesh]]:
    """Name → the function that makes the mesh of a level."""
    makers: dict[str, Callable[[int], Mesh]] = {name: partial(trunk, rows) for name, rows in TORSOS.items()}
    makers |= {name: partial(limb, rows, HIP, (0.02, 0.01), 0.0, 2.4) for name, rows in HIPS.items()}
    for name, rows in LIMBS.items():
        folds = 0.025 if "loose" in name or "sleeve" in name else 0.0
        makers[name] = partial(limb, rows, LIMB, JOINT_CAPS[name], folds, 2.2)
    makers |= {name: partial(shoe, name) for name in SHOES}
    makers |= {"sole": sole, "left hand": partial(hand, 1.0), "right hand": partial(hand, -1.0)}
    return makers
