"""Skirts, hems and things that people carry, in the frames of the bones that they hang from."""

from collections.abc import Callable
from functools import partial

import numpy as np
import trimesh

from vbbench.arrays import FloatArray
from vbbench_renderers.mesh import Mesh
from vbbench_renderers.people.body import TORSOS
from vbbench_renderers.people.loft import Detail, Section, finish, loft

CLOTH: Detail = ((18, 6), (10, 4), (6, 3))
BOX: Detail = ((12, 5), (8, 3), (4, 2))
BAND: Detail = ((4, 9), (4, 5), (4, 2))

SKIRTS: dict[str, list[Section]] = {  # z = 0 is the waist
    "short skirt": [
        (-0.50, 0.0, 0.165, 0.170, 0.205),
        (-0.30, 0.0, 0.145, 0.155, 0.196),
        (-0.12, 0.0, 0.118, 0.135, 0.182),
        (0.03, 0.0, 0.094, 0.086, 0.134),
    ],
    "pencil skirt": [
        (-0.58, 0.0, 0.112, 0.116, 0.160),
        (-0.30, 0.0, 0.118, 0.130, 0.180),
        (-0.12, 0.0, 0.112, 0.134, 0.180),
        (0.03, 0.0, 0.094, 0.086, 0.134),
    ],
    "long skirt": [
        (-0.84, 0.0, 0.190, 0.195, 0.225),
        (-0.45, 0.0, 0.155, 0.165, 0.205),
        (-0.12, 0.0, 0.118, 0.136, 0.184),
        (0.03, 0.0, 0.094, 0.086, 0.134),
    ],
    "coat hem": [
        (-0.52, 0.0, 0.155, 0.160, 0.212),
        (-0.30, 0.0, 0.146, 0.152, 0.206),
        (-0.12, 0.0, 0.134, 0.146, 0.198),
        (0.06, 0.0, 0.124, 0.116, 0.174),
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
    (0.40, -0.105, 0.030, 0.040, 0.080),
    (0.46, -0.100, 0.050, 0.055, 0.110),
    (0.52, -0.080, 0.060, 0.050, 0.098),
    (0.56, -0.065, 0.040, 0.030, 0.070),
]
COLLAR: list[Section] = [
    (0.485, -0.008, 0.076, 0.080, 0.092),
    (0.525, -0.004, 0.074, 0.074, 0.076),
    (0.560, 0.002, 0.072, 0.072, 0.072),
]


def front_of(torso: str, y: FloatArray, z: FloatArray) -> FloatArray:
    """X in m of a torso's front at (y, z)."""
    table = np.array(TORSOS[torso])
    centre, front, width = (np.interp(z, table[:, 0], table[:, column]) for column in (1, 2, 4))
    inside = np.clip(1.0 - np.abs(y / width) ** 2.5, 0.0, 1.0)
    return np.asarray(centre + front * inside ** (1.0 / 2.5))


def band(torso: str, level: int, start: tuple[float, float], end: tuple[float, float], half: float) -> trimesh.Trimesh:
    """A band that lies on a torso's front from (y, z) up to (y, z)."""
    z = np.linspace(start[1], end[1], 9)
    y = np.interp(z, (start[1], end[1]), (start[0], end[0]))
    x = front_of(torso, y, z)
    thick = 0.012 if half < 0.03 else 0.02
    solid = loft(
        [(float(zi), float(xi), thick, thick, half) for zi, xi in zip(z, x, strict=True)],
        BAND[level],
        caps=(0.004, 0.004),
        power=3.0,
    )
    slope = (end[0] - start[0]) / (end[1] - start[1])
    points = np.array(solid.vertices)
    points[:, 1] += start[0] + slope * (points[:, 2] - start[1])
    return trimesh.Trimesh(points, solid.faces, process=False)


def backpack(level: int) -> Mesh:
    """A rucksack with its two straps."""
    straps = [band("jacket", level, (side * 0.135, 0.14), (side * 0.085, 0.49), 0.020) for side in (-1.0, 1.0)]
    return finish(loft(BACKPACK, BOX[level], caps=(0.02, 0.03), power=3.5), *(straps if level < 2 else []))


def strap(side: float, level: int) -> Mesh:
    """The strap across the chest of a bag at the left (1) or right (−1) hip."""
    return finish(band("jacket", level, (side * 0.165, -0.10), (-side * 0.08, 0.495), 0.018))


def cloth(sections: list[Section], level: int) -> Mesh:
    """A skirt with pleats, darker at the hem."""
    return finish(loft(sections, CLOTH[level], caps=(0.003, 0.01), power=2.1, ripple=0.05 if level == 0 else 0.0))


def box(sections: list[Section], power: float, level: int) -> Mesh:
    """Something with rounded corners."""
    return finish(loft(sections, BOX[level], caps=(0.012, 0.012), power=power))


def garment_meshes() -> dict[str, Callable[[int], Mesh]]:
    """Name → what makes the mesh of a level."""
    makers: dict[str, Callable[[int], Mesh]] = {name: partial(cloth, rows) for name, rows in SKIRTS.items()}
    makers |= {"pouch": partial(box, POUCH, 3.5), "tote": partial(box, TOTE, 3.5), "backpack": backpack}
    makers |= {"hood": partial(box, HOOD, 2.2), "collar": partial(box, COLLAR, 2.2)}
    makers |= {"left strap": partial(strap, 1.0), "right strap": partial(strap, -1.0)}
    for name in ("jacket", "jacket woman"):
        makers[f"front {name}"] = partial(_panel, name, (-0.12, 0.50), 0.05)
        makers[f"tie {name}"] = partial(_panel, name, (0.08, 0.49), 0.022)
    return makers


def _panel(torso: str, span: tuple[float, float], half: float, level: int) -> Mesh:
    """A strip down the middle of the front."""
    return finish(band(torso, level, (0.0, span[0]), (0.0, span[1]), half))
