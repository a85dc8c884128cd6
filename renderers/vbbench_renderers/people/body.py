"""Limb meshes below the head, clothed or bare, in the frames that `vbbench_renderers.people.skeleton` poses.

All sizes are of a person of 1.75 m; sections are (z, centre x, front, back, half-width).
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh

from vbbench.arrays import FloatArray
from vbbench_renderers.mesh import Mesh
from vbbench_renderers.people.loft import ALONG_X, Detail, Section, finish, loft, turned

TRUNK: Detail = ((16, 10), (10, 5), (6, 4))
HIP: Detail = ((12, 4), (7, 3), (6, 2))
LIMB: Detail = ((8, 4), (5, 3), (4, 2))
HAND: Detail = ((6, 5), (4, 3), (3, 2))
MID_TORSO = 0.24
"""Height in m of the origin of the torso meshes over that of the chest; two-coloured shirts change colour there."""
NECKLINE = 0.45
"""Slope of the neckline: it is lower in front."""
SHOE: Detail = ((8, 7), (6, 4), (4, 3))

TORSOS: dict[str, list[Section]] = {
    "torso man": [
        (-0.080, 0.0, 0.137, 0.138, 0.192),
        (-0.03, 0.0, 0.122, 0.128, 0.178),
        (0.08, 0.0, 0.108, 0.098, 0.156),
        (0.20, 0.002, 0.116, 0.096, 0.160),
        (0.32, 0.003, 0.122, 0.108, 0.174),
        (0.395, -0.003, 0.110, 0.110, 0.184),
        (0.44, -0.008, 0.088, 0.096, 0.187),
        (0.468, -0.010, 0.074, 0.082, 0.160),
        (0.495, -0.012, 0.062, 0.068, 0.104),
        (0.52, -0.012, 0.056, 0.060, 0.068),
    ],
    "torso woman": [
        (-0.080, 0.0, 0.133, 0.142, 0.195),
        (-0.03, 0.0, 0.115, 0.129, 0.178),
        (0.09, 0.0, 0.092, 0.084, 0.130),
        (0.20, 0.002, 0.104, 0.084, 0.138),
        (0.29, 0.004, 0.138, 0.092, 0.154),
        (0.365, 0.0, 0.118, 0.096, 0.164),
        (0.425, -0.005, 0.086, 0.090, 0.166),
        (0.46, -0.008, 0.068, 0.074, 0.142),
        (0.49, -0.010, 0.056, 0.062, 0.096),
        (0.52, -0.012, 0.050, 0.054, 0.060),
    ],
    "torso heavy": [
        (-0.085, 0.01, 0.156, 0.146, 0.212),
        (-0.03, 0.02, 0.168, 0.132, 0.206),
        (0.07, 0.025, 0.176, 0.126, 0.200),
        (0.19, 0.02, 0.156, 0.118, 0.192),
        (0.31, 0.005, 0.138, 0.116, 0.190),
        (0.395, -0.003, 0.116, 0.114, 0.190),
        (0.44, -0.008, 0.092, 0.098, 0.184),
        (0.47, -0.010, 0.076, 0.084, 0.156),
        (0.495, -0.012, 0.066, 0.072, 0.110),
        (0.52, -0.012, 0.060, 0.064, 0.074),
    ],
    "jacket": [
        (-0.10, 0.0, 0.146, 0.150, 0.200),
        (-0.03, 0.0, 0.134, 0.140, 0.192),
        (0.08, 0.0, 0.126, 0.120, 0.178),
        (0.20, 0.002, 0.130, 0.114, 0.180),
        (0.32, 0.002, 0.136, 0.120, 0.190),
        (0.395, -0.003, 0.124, 0.120, 0.196),
        (0.445, -0.008, 0.100, 0.106, 0.190),
        (0.478, -0.010, 0.082, 0.090, 0.158),
        (0.505, -0.012, 0.072, 0.078, 0.110),
        (0.528, -0.012, 0.064, 0.070, 0.074),
    ],
    "jacket woman": [
        (-0.10, 0.0, 0.140, 0.152, 0.196),
        (-0.03, 0.0, 0.127, 0.140, 0.185),
        (0.09, 0.0, 0.108, 0.100, 0.146),
        (0.20, 0.002, 0.116, 0.098, 0.152),
        (0.29, 0.004, 0.142, 0.104, 0.166),
        (0.37, 0.0, 0.126, 0.108, 0.176),
        (0.43, -0.005, 0.096, 0.100, 0.176),
        (0.468, -0.008, 0.076, 0.082, 0.148),
        (0.498, -0.010, 0.064, 0.070, 0.100),
        (0.524, -0.012, 0.056, 0.062, 0.064),
    ],
}
HIPS: dict[str, list[Section]] = {
    "hips man": [
        (-0.105, 0.0, 0.085, 0.104, 0.140),
        (-0.05, 0.0, 0.100, 0.116, 0.162),
        (0.00, 0.0, 0.098, 0.106, 0.156),
        (0.05, 0.0, 0.086, 0.080, 0.132),
    ],
    "hips woman": [
        (-0.105, 0.0, 0.086, 0.110, 0.148),
        (-0.05, 0.0, 0.098, 0.122, 0.168),
        (0.00, 0.0, 0.090, 0.104, 0.150),
        (0.05, 0.0, 0.074, 0.068, 0.108),
    ],
}
# Ends that meet at a joint have its radius, and rounded caps as high as that: together they make a ball.
LIMBS: dict[str, list[Section]] = {
    "neck": [
        (-0.16, -0.012, 0.050, 0.052, 0.054),
        (-0.05, -0.004, 0.050, 0.053, 0.053),
        (0.05, 0.010, 0.048, 0.054, 0.051),
    ],
    "upper arm": [
        (-0.145, 0.0, 0.039, 0.039, 0.037),
        (-0.05, 0.0, 0.044, 0.043, 0.040),
        (0.06, 0.0, 0.050, 0.051, 0.044),
        (0.135, 0.0, 0.046, 0.048, 0.038),
    ],
    "sleeve": [
        (-0.145, 0.0, 0.047, 0.047, 0.045),
        (-0.05, 0.0, 0.051, 0.051, 0.048),
        (0.06, 0.0, 0.057, 0.058, 0.051),
        (0.135, 0.0, 0.051, 0.053, 0.042),
    ],
    "short sleeve": [
        (-0.03, 0.0, 0.058, 0.058, 0.054),
        (0.06, 0.0, 0.057, 0.058, 0.051),
        (0.135, 0.0, 0.050, 0.052, 0.041),
    ],
    "forearm": [
        (-0.13, 0.0, 0.026, 0.026, 0.020),
        (-0.06, 0.0, 0.031, 0.030, 0.027),
        (0.05, 0.002, 0.042, 0.040, 0.037),
        (0.125, 0.0, 0.038, 0.038, 0.036),
    ],
    "forearm sleeve": [
        (-0.125, 0.0, 0.037, 0.037, 0.033),
        (-0.05, 0.0, 0.041, 0.041, 0.037),
        (0.05, 0.0, 0.046, 0.046, 0.042),
        (0.125, 0.0, 0.046, 0.046, 0.044),
    ],
    "thigh": [
        (-0.215, 0.004, 0.063, 0.063, 0.060),
        (-0.10, 0.006, 0.071, 0.071, 0.066),
        (0.08, 0.0, 0.083, 0.088, 0.082),
        (0.20, 0.0, 0.080, 0.094, 0.084),
    ],
    "loose thigh": [
        (-0.215, 0.004, 0.075, 0.075, 0.072),
        (-0.10, 0.004, 0.079, 0.079, 0.075),
        (0.08, 0.0, 0.087, 0.093, 0.088),
        (0.20, 0.0, 0.082, 0.097, 0.086),
    ],
    "shorts leg": [
        (-0.12, 0.0, 0.100, 0.100, 0.096),
        (0.04, 0.0, 0.095, 0.096, 0.091),
        (0.20, 0.0, 0.082, 0.097, 0.086),
    ],
    "shin": [
        (-0.20, -0.004, 0.035, 0.040, 0.035),
        (-0.12, -0.006, 0.040, 0.044, 0.041),
        (0.06, -0.010, 0.049, 0.064, 0.056),
        (0.14, -0.003, 0.053, 0.060, 0.055),
        (0.2075, 0.004, 0.059, 0.059, 0.057),
    ],
    "slim shin": [
        (-0.185, -0.004, 0.048, 0.052, 0.047),
        (-0.10, -0.006, 0.050, 0.055, 0.051),
        (0.06, -0.010, 0.055, 0.067, 0.060),
        (0.2075, 0.004, 0.063, 0.063, 0.060),
    ],
    "loose shin": [
        (-0.232, 0.0, 0.068, 0.076, 0.065),
        (-0.10, -0.004, 0.067, 0.072, 0.065),
        (0.06, -0.006, 0.069, 0.076, 0.069),
        (0.2075, 0.004, 0.075, 0.075, 0.072),
    ],
}
JOINT_CAPS: dict[str, tuple[float, float]] = {  # rounded caps (bottom, top) in m, where they are not 5 mm
    "neck": (0.01, 0.01),
    "upper arm": (0.030, 0.026),
    "sleeve": (0.036, 0.028),
    "short sleeve": (0.002, 0.027),
    "forearm": (0.01, 0.029),
    "forearm sleeve": (0.002, 0.034),
    "thigh": (0.046, 0.03),
    "loose thigh": (0.055, 0.03),
    "shorts leg": (0.002, 0.03),
    "shin": (0.02, 0.044),
    "slim shin": (0.003, 0.046),
    "loose shin": (0.003, 0.054),
}
SHOES: dict[str, list[Section]] = {  # (x, centre z, up, down, half-width); the sole is at z = −0.085
    "shoe": [
        (-0.066, -0.055, 0.030, 0.018, 0.024),
        (-0.045, -0.058, 0.085, 0.027, 0.034),
        (0.005, -0.060, 0.092, 0.025, 0.037),
        (0.055, -0.060, 0.060, 0.025, 0.041),
        (0.105, -0.060, 0.038, 0.025, 0.047),
        (0.160, -0.059, 0.026, 0.022, 0.045),
        (0.188, -0.058, 0.016, 0.014, 0.028),
    ],
    "pump": [
        (-0.062, -0.048, 0.030, 0.020, 0.020),
        (-0.040, -0.050, 0.058, 0.035, 0.030),
        (0.010, -0.055, 0.026, 0.028, 0.033),
        (0.060, -0.062, 0.010, 0.023, 0.038),
        (0.110, -0.066, 0.018, 0.019, 0.043),
        (0.160, -0.066, 0.018, 0.016, 0.038),
        (0.190, -0.066, 0.010, 0.009, 0.018),
    ],
}
SOLE: list[Section] = [
    (-0.066, -0.068, 0.014, 0.014, 0.028),
    (-0.050, -0.069, 0.015, 0.016, 0.038),
    (0.050, -0.069, 0.015, 0.016, 0.043),
    (0.110, -0.069, 0.015, 0.016, 0.051),
    (0.165, -0.066, 0.014, 0.014, 0.047),
    (0.192, -0.062, 0.010, 0.011, 0.030),
]
PALM: list[Section] = [
    (-0.168, 0.030, 0.024, 0.024, 0.011),
    (-0.120, 0.014, 0.034, 0.034, 0.014),
    (-0.080, 0.002, 0.042, 0.040, 0.016),
    (-0.040, 0.0, 0.036, 0.034, 0.017),
    (0.010, 0.0, 0.026, 0.026, 0.019),
]
THUMB: list[Section] = [
    (-0.105, 0.052, 0.010, 0.010, 0.009),
    (-0.070, 0.044, 0.013, 0.013, 0.011),
    (-0.035, 0.026, 0.014, 0.014, 0.012),
]


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
    """Name → what makes the mesh of a level."""
    makers: dict[str, Callable[[int], Mesh]] = {name: partial(trunk, rows) for name, rows in TORSOS.items()}
    makers |= {name: partial(limb, rows, HIP, (0.02, 0.01), 0.0, 2.4) for name, rows in HIPS.items()}
    for name, rows in LIMBS.items():
        folds = 0.025 if "loose" in name or "sleeve" in name else 0.0
        makers[name] = partial(limb, rows, LIMB, JOINT_CAPS[name], folds, 2.2)
    makers |= {name: partial(shoe, name) for name in SHOES}
    makers |= {"sole": sole, "left hand": partial(hand, 1.0), "right hand": partial(hand, -1.0)}
    return makers
