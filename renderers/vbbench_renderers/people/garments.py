"""Skirts, hems and things that people carry, in the frames of the bones that they are attached to."""

from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.people.body import NECKLINE
from vbbench_renderers.people.loft import Detail, Section, finish, loft
from vbbench_renderers.people.measures import TORSOS

CLOTH: Detail = ((14, 5), (8, 3), (6, 2))
BOX: Detail = ((12, 5), (8, 3), (4, 2))
BAND: Detail = ((6, 7), (4, 4), (4, 2))

SKIRTS: dict[str, list[Section]] = {  # z = 0 is the waist
    "short skirt": [
        (-0.50, 0.0, 0.168, 0.176, 0.210),
        (-0.30, 0.0, 0.148, 0.162, 0.202),
        (-0.12, 0.0, 0.124, 0.144, 0.190),
        (0.03, 0.0, 0.104, 0.098, 0.142),
    ],
    "pencil skirt": [
        (-0.58, 0.0, 0.116, 0.120, 0.166),
        (-0.30, 0.0, 0.126, 0.138, 0.190),
        (-0.12, 0.0, 0.122, 0.144, 0.192),
        (0.03, 0.0, 0.104, 0.098, 0.142),
    ],
    "long skirt": [
        (-0.84, 0.0, 0.196, 0.205, 0.230),
        (-0.45, 0.0, 0.160, 0.172, 0.210),
        (-0.12, 0.0, 0.124, 0.145, 0.192),
        (0.03, 0.0, 0.104, 0.098, 0.142),
    ],
    "coat hem": [
        (-0.52, 0.0, 0.164, 0.172, 0.222),
        (-0.30, 0.0, 0.157, 0.166, 0.214),
        (-0.15, 0.0, 0.152, 0.160, 0.208),
        (0.00, 0.0, 0.104, 0.104, 0.154),
    ],
}
BACKPACK: list[Section] = [
    (0.03, -0.185, 0.075, 0.070, 0.120),
    (0.10, -0.185, 0.080, 0.095, 0.140),
    (0.30, -0.185, 0.080, 0.085, 0.138),
    (0.44, -0.175, 0.070, 0.055, 0.115),
]
POUCH: list[Section] = [
    (-0.14, 0.0, 0.150, 0.150, 0.045),
    (-0.02, 0.0, 0.150, 0.150, 0.050),
    (0.10, 0.0, 0.140, 0.140, 0.035),
]
TOTE: list[Section] = [
    (-0.48, 0.02, 0.150, 0.150, 0.045),
    (-0.34, 0.02, 0.155, 0.155, 0.040),
    (-0.21, 0.02, 0.150, 0.150, 0.022),
    (-0.19, 0.02, 0.020, 0.020, 0.016),
    (-0.10, 0.015, 0.014, 0.014, 0.012),
]
HOOD: list[Section] = [
    (0.38, -0.100, 0.020, 0.030, 0.060),
    (0.43, -0.100, 0.050, 0.050, 0.105),
    (0.49, -0.085, 0.060, 0.048, 0.105),
    (0.535, -0.070, 0.045, 0.034, 0.080),
]
COLLAR: list[Section] = [
    (0.470, -0.010, 0.076, 0.082, 0.100),
    (0.500, -0.008, 0.068, 0.074, 0.080),
    (0.526, -0.004, 0.066, 0.070, 0.072),
]
PHONE: list[Section] = [(-0.16, 0.0, 0.036, 0.036, 0.005), (-0.02, 0.0, 0.036, 0.036, 0.005)]


def side_of(torso: str, y: FloatArray, z: FloatArray, side: float) -> FloatArray:
    """X in m of a torso's front (side 1) or back (−1) at (y, z)."""
    table = np.array(TORSOS[torso])
    centre, front, back, width = np.moveaxis(PchipInterpolator(table[:, 0], table[:, 1:])(z), -1, 0)
    inside = np.clip(1.0 - np.abs(y / width) ** 2.5, 0.0, 1.0)
    return np.asarray(centre + (front if side > 0 else -back) * inside ** (1.0 / 2.5))


def band(
    torso: str,
    level: int,
    start: tuple[float, float],
    end: tuple[float, float],
    half: tuple[float, float],
    stands: float = 0.002,
    side: float = 1.0,
) -> trimesh.Trimesh:
    """A band `stands` m off a torso's front (side 1) or back (−1) from (y, z) up to (y, z), as wide as `half` there."""
    z = np.linspace(start[1], end[1], 9)
    y = np.interp(z, (start[1], end[1]), (start[0], end[0]))
    width = np.interp(z, (start[1], end[1]), half)
    x = side_of(torso, y, z, side) + side * stands
    rows = [(float(zi), float(xi), 0.008, 0.008, float(w)) for zi, xi, w in zip(z, x, width, strict=True)]
    solid = loft(rows, BAND[level], caps=(0.004, 0.004), power=3.5)
    slope = (end[0] - start[0]) / (end[1] - start[1])
    points = np.array(solid.vertices)
    points[:, 1] += start[0] + slope * (points[:, 2] - start[1])
    points[:, 2] -= NECKLINE * points[:, 0] * np.clip((points[:, 2] - 0.44) / 0.08, 0.0, 1.0)
    return trimesh.Trimesh(points, solid.faces, process=False)


def straps(torso: str, level: int) -> Mesh:
    """The two straps of a rucksack."""
    ends = [((side * 0.150, 0.16), (side * 0.095, 0.485)) for side in (-1.0, 1.0)]
    return finish(*(band(torso, level, low, high, (0.018, 0.026)) for low, high in ends))


def strap(torso: str, hip: float, level: int) -> Mesh:
    """The strap across chest and back of a bag at the left (1) or right (−1) hip."""
    ends = (hip * 0.165, -0.07), (-hip * 0.09, 0.49)
    return finish(*(band(torso, level, *ends, (0.018, 0.018), side=side) for side in (1.0, -1.0)))


def cloth(sections: list[Section], pleats: float, level: int) -> Mesh:
    """A skirt with pleats of a relative depth."""
    return finish(loft(sections, CLOTH[level], caps=(0.003, 0.01), power=2.1, ripple=pleats if level == 0 else 0.0))


def collar(level: int) -> Mesh:
    """A collar around the neck, lower in front."""
    solid = loft(COLLAR, BOX[level], caps=(0.002, 0.004))
    points = np.array(solid.vertices)
    points[:, 2] -= NECKLINE * points[:, 0]
    return finish(trimesh.Trimesh(points, solid.faces, process=False))


def box(sections: list[Section], power: float, level: int) -> Mesh:
    """Something with rounded corners."""
    return finish(loft(sections, BOX[level], caps=(0.012, 0.012), power=power))


def garment_meshes() -> dict[str, Callable[[int], Mesh]]:
    """Name → the function that makes the mesh of a level."""
    makers: dict[str, Callable[[int], Mesh]] = {
        name: partial(cloth, rows, 0.01 if name == "coat hem" else 0.05) for name, rows in SKIRTS.items()
    }
    makers |= {"pouch": partial(box, POUCH, 3.5), "tote": partial(box, TOTE, 3.5)}
    makers |= {"backpack": partial(box, BACKPACK, 3.5)}
    makers |= {"hood": partial(box, HOOD, 2.2), "collar": collar, "phone": partial(box, PHONE, 4.0)}
    for name in TORSOS:
        makers[f"straps {name}"] = partial(straps, name)
        makers[f"left strap {name}"] = partial(strap, name, 1.0)
        makers[f"right strap {name}"] = partial(strap, name, -1.0)
    for name in ("jacket", "jacket woman"):
        makers[f"open {name}"] = partial(_panel, name, (-0.09, 0.525), (0.030, 0.048))
        makers[f"buttoned {name}"] = partial(_panel, name, (0.14, 0.525), (0.006, 0.056))
        makers[f"tie {name}"] = partial(_panel, name, (0.16, 0.50), (0.004, 0.020), stands=0.008)
    return makers


def _panel(torso: str, span: tuple[float, float], half: tuple[float, float], level: int, stands: float = 0.004) -> Mesh:
    """A strip down the middle of the front."""
    return finish(band(torso, level, (0.0, span[0]), (0.0, span[1]), half, stands))
