"""Heads, hair and headgear, in the frame of the head: the chin at z = 0, the face towards x, sizes in m."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.people.loft import ALONG_X, Section, close_grid, finish, loft, turned

CROWN = 0.218
"""Height of the bald head's top over the chin."""

# (z, centre x, front, back, half-width)
PROFILE: list[Section] = [
    (-0.012, 0.030, 0.030, 0.060, 0.036),
    (0.0, 0.030, 0.052, 0.070, 0.040),
    (0.012, 0.028, 0.063, 0.078, 0.049),
    (0.030, 0.024, 0.067, 0.084, 0.056),
    (0.046, 0.022, 0.071, 0.086, 0.061),
    (0.062, 0.020, 0.073, 0.088, 0.066),
    (0.076, 0.018, 0.074, 0.092, 0.069),
    (0.092, 0.016, 0.075, 0.098, 0.071),
    (0.106, 0.014, 0.076, 0.102, 0.073),
    (0.118, 0.012, 0.077, 0.104, 0.074),
    (0.130, 0.010, 0.081, 0.105, 0.075),
    (0.142, 0.008, 0.084, 0.105, 0.076),
    (0.160, 0.006, 0.084, 0.104, 0.076),
    (0.182, 0.002, 0.079, 0.098, 0.072),
    (0.202, -0.002, 0.062, 0.080, 0.058),
    (0.213, -0.004, 0.038, 0.050, 0.036),
    (CROWN, -0.005, 0.004, 0.004, 0.004),
]
COLUMNS = ((0.0, 11, 22, 34, 47, 62, 82, 105, 130, 156, 180), (0.0, 25, 60, 105, 180), (0.0, 80, 180))
"""Azimuths in degrees of the vertices on one side, by level; the face has more of them."""
ROWS = (tuple(range(len(PROFILE) - 1)), (0, 2, 5, 7, 10, 13, 15), (0, 3, 9, 14))


EAR: list[Section] = [
    (0.085, -0.004, 0.008, 0.010, 0.006),
    (0.110, -0.010, 0.014, 0.016, 0.009),
    (0.128, -0.014, 0.012, 0.014, 0.008),
]
EYE: list[Section] = [  # along x
    (-0.006, 0.0, 0.006, 0.007, 0.012),
    (0.004, 0.0, 0.0065, 0.007, 0.0135),
    (0.0105, 0.0, 0.0050, 0.005, 0.0070),
]


def outline(azimuth: FloatArray, z: FloatArray) -> FloatArray:
    """Points [..., 3] of the bald head's surface at azimuths [...] in rad and heights [...] in m."""
    table = np.array(PROFILE)
    centre, front, back, width = np.moveaxis(PchipInterpolator(table[:, 0], table[:, 1:])(z), -1, 0)
    depth = np.where(np.cos(azimuth) > 0, front, back)
    x = centre + depth * np.sign(np.cos(azimuth)) * np.abs(np.cos(azimuth)) ** 0.92
    y = width * np.sign(np.sin(azimuth)) * np.abs(np.sin(azimuth)) ** 0.92
    return np.stack([x, y, z], axis=-1)


def azimuths(level: int) -> FloatArray:
    """Azimuths in rad around the head, counter-clockwise from −π."""
    half = np.radians(COLUMNS[level])
    return np.concatenate([-half[:0:-1], half[:-1]])


def head(jaw: float, level: int) -> Mesh:
    """A head with brow, nose, mouth and chin; `jaw` widens the lower face."""
    around = azimuths(level)
    z = np.array([PROFILE[row][0] for row in ROWS[level]])
    a, h = np.meshgrid(around, z)
    points = outline(a, h)
    points[..., 1] *= 1.0 + jaw * np.clip((0.09 - h) / 0.06, 0.0, 1.0)
    points[..., 0] += _face(a, h)
    bottom, top = np.array([0.0, 0.0, -0.014]), np.array([-0.005, 0.0, CROWN])
    solid = close_grid(points, bottom, top)
    ears = [] if level > 0 else [_ear(side) for side in (-1.0, 1.0)]
    return finish(solid, *ears, paint=_paint_face if level < 2 else None)


def _ear(side: float) -> trimesh.Trimesh:
    ear = loft(EAR, (5, 3), caps=(0.006, 0.008))
    return turned(ear, np.eye(3), (0.0, 0.077 * side, 0.0))


def eyes(level: int) -> Mesh:
    """Two eyeballs with dark irises."""
    balls = []
    for side in (-1.0, 1.0):
        ball = loft(EYE, ((6, 3), (6, 3), (4, 2))[level], caps=(0.003, 0.0025), power=2.0)
        balls.append(turned(ball, ALONG_X, (0.0665, 0.031 * side, 0.1175)))
    return finish(*balls, paint=lambda points: np.where(points[:, :1] > 0.0765, 0.05, 1.0) * np.ones(3))


def _bump(a: FloatArray, h: FloatArray, at: tuple[float, float], size: tuple[float, float]) -> FloatArray:
    """A smooth bump of height 1 at ± an azimuth in degrees and a height, with its two widths."""
    azimuth, z = at
    distance = (np.abs(np.degrees(a)) - azimuth) / size[0]
    return np.asarray(np.exp(-(distance**2) - ((h - z) / size[1]) ** 2))


def _face(a: FloatArray, h: FloatArray) -> FloatArray:
    """How far in m the face extends beyond the egg shape."""
    nose = 0.024 * _bump(a, h, (0, 0.080), (10, 0.014)) + 0.010 * _bump(a, h, (0, 0.105), (8, 0.018))
    brow = 0.004 * _bump(a, h, (18, 0.138), (24, 0.008)) - 0.009 * _bump(a, h, (22, 0.119), (11, 0.012))
    mouth = 0.004 * _bump(a, h, (0, 0.046), (22, 0.010)) + 0.006 * _bump(a, h, (0, 0.012), (18, 0.012))
    cheek = 0.003 * _bump(a, h, (34, 0.090), (15, 0.02))
    return np.asarray(nose + brow + mouth + cheek)


def _paint_face(vertices: FloatArray) -> FloatArray:
    """Eyes, brows and lips on skin, as factors of the skin's colour."""
    x, y, h = vertices.T
    a = np.arctan2(y, x - 0.01)
    dark = np.maximum(
        0.45 * _bump(a, h, (22, 0.120), (12, 0.009)) * (x > 0), 0.75 * _bump(a, h, (24, 0.139), (14, 0.006)) * (x > 0)
    )
    lips = 0.45 * _bump(a, h, (0, 0.046), (20, 0.008)) * (x > 0)
    shade = 1.0 - 0.35 * np.clip((0.012 - h) / 0.02, 0.0, 1.0)
    factors = shade[:, None] * (1.0 - dark[:, None]) * (1.0 - lips[:, None] * np.array([0.15, 0.75, 0.65]))
    return np.asarray(factors)


@dataclass(frozen=True, kw_only=True)
class Shell:
    """Something that covers the skull: hair, a cap, a scarf.

    Parameters
    ----------
    edge : height in m of the lower edge at azimuths 0, 40, 75, 110 and 180 degrees.
    thick : thickness in m at the edge, halfway and at the crown.
    flare : m that the edge below the jaw stands away from the head.
    curls : depth in m of curls.
    """

    edge: tuple[float, float, float, float, float]
    thick: tuple[float, float, float]
    flare: float = 0.0
    curls: float = 0.0


WRAP: list[Section] = [  # what a head scarf covers below the chin
    (-0.105, -0.005, 0.105, 0.100, 0.125),
    (-0.060, 0.006, 0.078, 0.078, 0.078),
    (-0.010, 0.020, 0.066, 0.090, 0.066),
    (0.030, 0.016, 0.060, 0.090, 0.066),
]
BEARD: list[Section] = [
    (-0.017, 0.032, 0.040, 0.040, 0.034),
    (0.004, 0.030, 0.062, 0.055, 0.047),
    (0.024, 0.026, 0.071, 0.060, 0.057),
    (0.042, 0.022, 0.066, 0.055, 0.064),
    (0.075, 0.014, 0.040, 0.050, 0.072),
]
SHELLS: dict[str, Shell] = {
    "hair short": Shell(edge=(0.176, 0.172, 0.120, 0.070, 0.052), thick=(0.004, 0.011, 0.014)),
    "hair crew": Shell(edge=(0.182, 0.178, 0.125, 0.085, 0.065), thick=(0.002, 0.005, 0.006)),
    "hair swept": Shell(edge=(0.190, 0.160, 0.112, 0.062, 0.045), thick=(0.006, 0.017, 0.024)),
    "hair curly": Shell(edge=(0.168, 0.160, 0.105, 0.055, 0.040), thick=(0.018, 0.034, 0.036), curls=0.006),
    "hair long": Shell(edge=(0.184, 0.150, -0.100, -0.130, -0.140), thick=(0.010, 0.024, 0.016), flare=0.006),
    "hair bob": Shell(edge=(0.165, 0.150, 0.005, 0.0, 0.0), thick=(0.006, 0.023, 0.016), flare=0.004),
    "hair tied": Shell(edge=(0.182, 0.175, 0.105, 0.065, 0.055), thick=(0.004, 0.008, 0.009)),
    "hair receding": Shell(edge=(0.206, 0.204, 0.125, 0.070, 0.055), thick=(0.003, 0.006, 0.004)),
    "cap": Shell(edge=(0.158, 0.152, 0.132, 0.120, 0.115), thick=(0.016, 0.021, 0.024)),
    "beanie": Shell(edge=(0.150, 0.145, 0.115, 0.098, 0.090), thick=(0.019, 0.024, 0.034)),
    "scarf": Shell(edge=(0.172, 0.146, -0.030, -0.075, -0.080), thick=(0.013, 0.022, 0.013), flare=0.020),
    "crown": Shell(edge=(0.160, 0.156, 0.146, 0.140, 0.135), thick=(0.016, 0.022, 0.040)),
}


def shell(name: str, level: int) -> Mesh:
    """The surface of a shell, closed inside the head."""
    what = SHELLS[name]
    around, rings = azimuths(level), (7, 4, 3)[level]
    edge = PchipInterpolator(np.radians([0, 40, 75, 110, 180]), what.edge)(np.abs(around))
    share = np.linspace(0.0, 0.94, rings)[:, None]
    rise = np.sin(0.5 * np.pi * share)
    z = edge + (CROWN - edge) * np.minimum(rise, 0.995)
    a = np.broadcast_to(around, z.shape)
    low = np.minimum(z, 0.0)
    points = outline(a, np.maximum(z, 0.045 if what.flare else 0.0))
    points[..., 2] = z
    thick = PchipInterpolator([0.0, 0.5, 1.0], what.thick)(share) + what.flare * np.clip(-low / 0.1, 0.0, 1.0)
    thick = thick + what.curls * np.sin(5 * a) * np.sin(90.0 * z)
    up = rise**3 + 0.0 * a
    outwards = np.stack([np.sqrt(1.0 - up**2) * np.cos(a), np.sqrt(1.0 - up**2) * np.sin(a), up], axis=-1)
    points = points + thick[..., None] * outwards
    inner = points[:1] * (0.86, 0.86, 1.0) + (0.0, 0.0, 0.008)
    middle = np.array([0.0, 0.0, float(np.mean(edge)) + 0.02])
    solid = close_grid(np.concatenate([inner, points]), middle, np.array([-0.005, 0.0, CROWN + what.thick[2]]))
    return finish(solid, paint=_strands)


def _strands(vertices: FloatArray) -> FloatArray:
    """Hair is darker near its lower edge and uneven around."""
    around = np.arctan2(vertices[:, 1], vertices[:, 0])
    shade = 0.86 + 0.14 * np.clip(vertices[:, 2] / 0.2, 0.0, 1.0) + 0.08 * np.sin(9.0 * around)
    return np.repeat(shade[:, None], 3, axis=1)


def wrap(level: int) -> Mesh:
    """The part of a head scarf that covers neck and throat."""
    return finish(loft(WRAP, ((14, 5), (8, 4), (5, 2))[level], caps=(0.01, 0.01)))


def beard(level: int) -> Mesh:
    """A full beard around the jaw, below the mouth."""
    return finish(loft(BEARD, ((14, 6), (8, 4), (5, 3))[level], caps=(0.004, 0.004)), paint=_strands)


def tail(hang: bool, level: int) -> Mesh:
    """A pony tail, or a bun."""
    if hang:
        sections = [
            (-0.06, -0.135, 0.010, 0.012, 0.014),
            (0.03, -0.145, 0.024, 0.026, 0.030),
            (0.10, -0.132, 0.026, 0.028, 0.028),
            (0.145, -0.108, 0.018, 0.020, 0.020),
        ]
    else:
        sections = [
            (0.120, -0.115, 0.022, 0.026, 0.026),
            (0.150, -0.120, 0.036, 0.036, 0.038),
            (0.180, -0.110, 0.024, 0.026, 0.026),
        ]
    return finish(loft(sections, ((8, 5), (6, 3), (4, 2))[level], caps=(0.015, 0.015)))


def brim(front: float, back: float, width: float, level: int) -> Mesh:
    """The brim of a hat, or, without a back, the peak of a cap; it bends down a little."""
    sections = [
        (0.139, 0.0, front, back, width),
        (0.147, 0.0, 0.97 * front, 0.97 * back, 0.97 * width),
        (0.160, 0.0, 0.55 * front, 0.6 * back, 0.6 * width),
    ]
    return finish(loft(sections, ((18, 3), (10, 3), (6, 3))[level], caps=(0.001, 0.001)))


def head_meshes() -> dict[str, Callable[[int], Mesh]]:
    """Name → the function that makes the mesh of a level."""
    makers: dict[str, Callable[[int], Mesh]] = {name: partial(shell, name) for name in SHELLS}
    makers |= {"head man": partial(head, 0.05), "head woman": partial(head, -0.06)}
    makers |= {
        "wrap": wrap,
        "beard": beard,
        "eyes": eyes,
        "pony tail": partial(tail, True),
        "bun": partial(tail, False),
    }
    makers |= {"peak": partial(brim, 0.165, 0.06, 0.085)}
    makers |= {"wide brim": partial(brim, 0.185, 0.185, 0.170)}
    makers |= {"narrow brim": partial(brim, 0.145, 0.145, 0.130)}
    return makers
