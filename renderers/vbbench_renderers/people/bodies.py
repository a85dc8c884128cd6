"""Limb meshes by level of detail: bodies, clothes and what people carry, lofted through sections of ``bodies.toml``.

Meshes are in the frames of the bones that they hang from; a head has the chin at z = 0 and the face towards x.
"""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from vbbench.geometry import FloatArray
from vbbench.parsing.toml_text import bundled_table
from vbbench_renderers.meshes import PLAIN, Mesh, join_meshes

LEVELS = 3
"""Levels of detail, the finest first."""
MID_TORSO = 0.24
"""Height in m of the origin of the torso meshes over that of the chest."""
NECKLINE = 0.45
"""Slope of the neckline: it is lower in front."""
CROWN = 0.218
"""Height in m of the bald head's top over the chin."""
FLAT = 0.011
"""Caps up to this height in m are plain cones."""
COLUMNS = ((0.0, 11, 22, 34, 47, 62, 82, 105, 130, 156, 180), (0.0, 25, 60, 105, 180), (0.0, 80, 180))
"""Azimuths in degrees of a head's vertices on one side, by level; the face has more of them."""
HEAD_ROWS = (tuple(range(16)), (0, 2, 5, 7, 10, 13, 15), (0, 3, 9, 14))
"""Sections of a head's vertices, by level."""
ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""Lays a loft along x: its axis becomes x, its front becomes up."""
BAND = ((6, 7), (4, 4), (4, 2))
TABLE: dict[str, dict[str, Any]] = bundled_table(__package__, "bodies.toml")

Paint = Callable[[FloatArray], FloatArray]


def metres(rows: Any) -> FloatArray:
    """Lengths of the table in m."""
    return np.asarray(rows, np.float64) / 1000.0


def loft(
    sections: FloatArray, grid: tuple[int, int], caps: FloatArray, power: float = 2.2, ripple: float = 0.0
) -> trimesh.Trimesh:
    """A closed surface along z; monotone cubic interpolation between the sections.

    Parameters
    ----------
    sections : [S, 5] (z, centre x, front, back, half-width) in m, z strictly monotone upwards.
    grid : vertices around, and rings along; the first vertex is at the left, so that the width is exact.
    caps : height in m of the rounded bottom and top.
    power : exponent of the superellipse; 2 is an ellipse, 4 nearly a box.
    ripple : relative depth of folds in the cloth.
    """
    sides, rings = grid
    steps = PchipInterpolator(np.arange(len(sections)), sections)(np.linspace(0.0, len(sections) - 1.0, rings))
    if rings > 3:
        steps = _with_caps(steps, caps)
    around = np.pi / 2 + 2.0 * np.pi * np.arange(sides) / sides
    ring = np.stack([_power(np.cos(around), 2.0 / power), _power(np.sin(around), 2.0 / power)], axis=-1)
    ring[np.abs(ring) < 1e-9] = 0.0
    fade = np.sin(np.pi * np.linspace(0.0, 1.0, len(steps)))[:, None]
    waves = np.sin(2.0 * around + 90.0 * steps[:, :1]) * np.sin(3.0 * around - 55.0 * steps[:, :1])
    folds = 1.0 + ripple * fade * waves
    depth = np.where(ring[:, 0] > 0, steps[:, 2:3], steps[:, 3:4])
    x, y = steps[:, 1:2] + folds * depth * ring[:, 0], folds * steps[:, 4:5] * ring[:, 1]
    points = np.stack([x, y, steps[:, :1] + 0.0 * depth], axis=-1)
    ends = steps[[0, -1], :][:, [1, 1, 0]] * (1.0, 0.0, 1.0) + np.outer([-caps[0], caps[1]], (0.0, 0.0, 1.0))
    return close_grid(points, ends[0], ends[1])


def _with_caps(steps: FloatArray, caps: FloatArray) -> FloatArray:
    """Adds a ring at each end that is not flat, so that it is round."""
    bottom, top = steps[:1].copy(), steps[-1:].copy()
    bottom[:, 0], top[:, 0] = bottom[:, 0] - 0.68 * caps[0], top[:, 0] + 0.68 * caps[1]
    bottom[:, 2:], top[:, 2:] = 0.74 * bottom[:, 2:], 0.74 * top[:, 2:]
    return np.concatenate([*([bottom] if caps[0] > FLAT else []), steps, *([top] if caps[1] > FLAT else [])])


def _power(values: FloatArray, exponent: float) -> FloatArray:
    return np.asarray(np.sign(values) * np.abs(values) ** exponent)


def close_grid(points: FloatArray, bottom: FloatArray, top: FloatArray) -> trimesh.Trimesh:
    """A closed surface of rings [R, S, 3] (counter-clockwise seen from the top) and a pole [3] at either end."""
    rings, sides = points.shape[:2]
    index = np.arange(rings * sides).reshape(rings, sides)
    right = np.roll(index, -1, axis=1)
    south, north = np.full(sides, rings * sides), np.full(sides, rings * sides + 1)
    faces = [
        np.stack([index[:-1], right[:-1], right[1:]], -1).reshape(-1, 3),
        np.stack([index[:-1], right[1:], index[1:]], -1).reshape(-1, 3),
        np.stack([right[0], index[0], south], -1),
        np.stack([index[-1], right[-1], north], -1),
    ]
    vertices = np.concatenate([points.reshape(-1, 3), bottom[None], top[None]])
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)


def finish(*solids: trimesh.Trimesh, paint: Paint | None = None) -> Mesh:
    """The solids as one limb mesh with smooth normals, painted by a function of the vertices [V, 3] → [V, 3]."""
    return join_meshes(
        [
            Mesh(
                vertices=solid.vertices.astype(np.float32),
                normals=solid.vertex_normals.astype(np.float32),
                colours=(np.ones_like(solid.vertices) if paint is None else paint(solid.vertices)).astype(np.float32),
                uv=np.zeros((len(solid.vertices), 2), np.float32),
                layers=np.full(len(solid.vertices), PLAIN, np.int32),
                triangles=solid.faces.astype(np.int32),
            )
            for solid in solids
        ]
    )


def shape(family: str, name: str, level: int) -> trimesh.Trimesh:
    """A shape of the table at a level of detail."""
    how, rows = TABLE[family]["loft"], TABLE[family][name]
    caps = metres(how["caps"] if "caps" in how else rows[0])
    if level == 2 and family in ("hips", "limb"):  # without rings in the caps a limb would end in spikes
        caps = 0.4 * caps
    folds = 0.025 if "loose" in name or "sleeve" in name else how.get("ripple", 0.0)
    sections = metres([row for row in rows if len(row) == 5])
    return loft(sections, how["detail"][level], caps, how.get("power", 2.2), folds if level == 0 else 0.0)


def moved(
    solid: trimesh.Trimesh, shift: tuple[float, float, float] = (0.0, 0.0, 0.0), turn: FloatArray | None = None
) -> trimesh.Trimesh:
    """The solid turned by a rotation [3, 3] and then shifted by m."""
    return trimesh.Trimesh(solid.vertices @ (np.eye(3) if turn is None else turn).T + shift, solid.faces, process=False)


def with_neckline(solid: trimesh.Trimesh, foot: float = 0.44, down: float = 0.0) -> trimesh.Trimesh:
    """The solid with a neckline that is lower in front, from 8 cm over a height in m on; lowered by ``down`` m."""
    points = np.array(solid.vertices)
    points[:, 2] -= NECKLINE * points[:, 0] * np.clip((points[:, 2] - foot) / 0.08, 0.0, 1.0)
    points[:, 2] -= down
    return trimesh.Trimesh(points, solid.faces, process=False)


def _plain(family: str, name: str, paint: Paint | None, level: int) -> Mesh:
    return finish(shape(family, name, level), paint=paint)


def _torso(name: str, level: int) -> Mesh:
    """A torso, darker under the arms and towards the hem, where less of the sky reaches."""
    return finish(with_neckline(shape("torso", name, level), down=MID_TORSO), paint=_shade_sides)


def _collar(level: int) -> Mesh:
    return finish(with_neckline(shape("collar", "collar", level), foot=0.38))


def _footwear(name: str, level: int) -> Mesh:
    """A shoe or sole in the frame of the foot: x to the toes, the ankle at the origin."""
    return finish(moved(shape(name, name, level), turn=ALONG_X))


def _hand(side: float, level: int) -> Mesh:
    """A hand that hangs, its palm to the thigh and its fingers a little bent; side is 1 for the left."""
    thumb = [] if level > 0 else [moved(shape("thumb", "thumb", level), (0.0, -0.008 * side, 0.0))]
    return finish(shape("palm", "palm", level), *thumb)


def _shade_ends(vertices: FloatArray) -> FloatArray:
    """A limb is darker towards its joints."""
    z = vertices[:, 2] / np.abs(vertices[:, 2]).max()
    return np.repeat((1.0 - 0.16 * z[:, None] ** 6), 3, axis=1)


def _shade_sides(vertices: FloatArray) -> FloatArray:
    z = vertices[:, 2] + MID_TORSO
    under_arm = np.clip(np.abs(vertices[:, 1]) / 0.17 - 0.55, 0.0, 0.5) * np.clip((0.42 - z) / 0.1, 0.0, 1.0)
    shade: FloatArray = 1.0 - 0.45 * under_arm - 0.12 * np.clip(-z / 0.12, 0.0, 1.0)
    return np.repeat(shade[:, None], 3, axis=1)


def _strands(vertices: FloatArray) -> FloatArray:
    """Hair is darker near its lower edge and uneven around."""
    around = np.arctan2(vertices[:, 1], vertices[:, 0])
    shade = 0.86 + 0.14 * np.clip(vertices[:, 2] / 0.2, 0.0, 1.0) + 0.08 * np.sin(9.0 * around)
    return np.repeat(shade[:, None], 3, axis=1)


End = tuple[float, float]


def band(torso: str, level: int, ends: tuple[End, End], half: End, stands: float = 0.002) -> trimesh.Trimesh:
    """A band `stands` m off a torso's front from (y, z) up to (y, z), as wide as `half` there."""
    start, end = ends
    z = np.linspace(start[1], end[1], 9)
    y = np.interp(z, (start[1], end[1]), (start[0], end[0]))
    width = np.interp(z, (start[1], end[1]), half)
    table = metres(TABLE["torso"][torso])
    centre, front, _, reach = np.moveaxis(PchipInterpolator(table[:, 0], table[:, 1:])(z), -1, 0)
    inside = np.clip(1.0 - np.abs(y / reach) ** 2.5, 0.0, 1.0)
    x = centre + front * inside ** (1.0 / 2.5) + stands
    rows = np.column_stack([z, x, np.full(9, 0.008), np.full(9, 0.008), width])
    solid = loft(rows, BAND[level], np.array([0.004, 0.004]), power=3.5)
    points = np.array(solid.vertices)
    points[:, 1] += start[0] + (end[0] - start[0]) / (end[1] - start[1]) * (points[:, 2] - start[1])
    return with_neckline(trimesh.Trimesh(points, solid.faces, process=False))


def _straps(torso: str, level: int) -> Mesh:
    """The two straps of a rucksack."""
    ends = [((side * 0.150, 0.16), (side * 0.095, 0.485)) for side in (-1.0, 1.0)]
    return finish(*(band(torso, level, end, (0.018, 0.026)) for end in ends))


def _panel(torso: str, span: End, half: End, stands: float, level: int) -> Mesh:
    """A strip down the middle of the front."""
    return finish(band(torso, level, ((0.0, span[0]), (0.0, span[1])), half, stands))


def outline(azimuth: FloatArray, z: FloatArray) -> FloatArray:
    """Points [..., 3] of the bald head's surface at azimuths [...] in rad and heights [...] in m."""
    table = metres(TABLE["head"]["skull"])
    centre, front, back, width = np.moveaxis(PchipInterpolator(table[:, 0], table[:, 1:])(z), -1, 0)
    depth = np.where(np.cos(azimuth) > 0, front, back)
    return np.stack([centre + depth * _power(np.cos(azimuth), 0.92), width * _power(np.sin(azimuth), 0.92), z], axis=-1)


def azimuths(level: int) -> FloatArray:
    """Azimuths in rad around the head, counter-clockwise from −π."""
    half = np.radians(COLUMNS[level])
    return np.concatenate([-half[:0:-1], half[:-1]])


def _head(jaw: float, level: int) -> Mesh:
    """A head with brow, nose, mouth and chin; `jaw` widens the lower face."""
    a, h = np.meshgrid(azimuths(level), metres(TABLE["head"]["skull"])[list(HEAD_ROWS[level]), 0])
    points = outline(a, h)
    points[..., 1] *= 1.0 + jaw * np.clip((0.09 - h) / 0.06, 0.0, 1.0)
    points[..., 0] += _face(a, h)
    solid = close_grid(points, np.array([0.0, 0.0, -0.014]), np.array([-0.005, 0.0, CROWN]))
    ears = [] if level > 0 else [moved(shape("ear", "ear", 0), (0.0, 0.077 * side, 0.0)) for side in (-1.0, 1.0)]
    return finish(solid, *ears, paint=_paint_face if level < 2 else None)


def _eyes(level: int) -> Mesh:
    """Two eyeballs with dark irises."""
    balls = [moved(shape("eye", "eye", level), (0.0665, 0.031 * side, 0.1175), ALONG_X) for side in (-1.0, 1.0)]
    return finish(*balls, paint=lambda points: np.where(points[:, :1] > 0.0765, 0.05, 1.0) * np.ones(3))


def _bump(a: FloatArray, h: FloatArray, at: End, size: End) -> FloatArray:
    """A smooth bump of height 1 at ± an azimuth in degrees and a height, with its two widths."""
    distance = (np.abs(np.degrees(a)) - at[0]) / size[0]
    return np.asarray(np.exp(-(distance**2) - ((h - at[1]) / size[1]) ** 2))


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
    eyes, brows = _bump(a, h, (22, 0.120), (12, 0.009)), _bump(a, h, (24, 0.139), (14, 0.006))
    dark = np.maximum(0.45 * eyes * (x > 0), 0.75 * brows * (x > 0))
    lips = 0.45 * _bump(a, h, (0, 0.046), (20, 0.008)) * (x > 0)
    shade = 1.0 - 0.35 * np.clip((0.012 - h) / 0.02, 0.0, 1.0)
    factors = shade[:, None] * (1.0 - dark[:, None]) * (1.0 - lips[:, None] * np.array([0.15, 0.75, 0.65]))
    return np.asarray(factors)


def _shell(name: str, level: int) -> Mesh:
    """The surface of hair, closed inside the head."""
    table = TABLE["shells"][name]
    flare, curls, thickness = (metres(table.get(key, 0.0)) for key in ("flare", "curls", "thick"))
    around, rings = azimuths(level), (7, 4, 3)[level]
    edge = PchipInterpolator(np.radians([0, 40, 75, 110, 180]), metres(table["edge"]))(np.abs(around))
    share = np.linspace(0.0, 0.94, rings)[:, None]
    rise = np.sin(0.5 * np.pi * share)
    z = edge + (CROWN - edge) * np.minimum(rise, 0.995)
    a = np.broadcast_to(around, z.shape)
    points = outline(a, np.maximum(z, 0.045 if flare else 0.0))
    points[..., 2] = z
    thick = PchipInterpolator([0.0, 0.5, 1.0], thickness)(share) + flare * np.clip(-np.minimum(z, 0.0) / 0.1, 0.0, 1.0)
    thick = thick + curls * np.sin(5 * a) * np.sin(90.0 * z)
    up = rise**3 + 0.0 * a
    outwards = np.stack([np.sqrt(1.0 - up**2) * np.cos(a), np.sqrt(1.0 - up**2) * np.sin(a), up], axis=-1)
    points = points + thick[..., None] * outwards
    inner = points[:1] * (0.86, 0.86, 1.0) + (0.0, 0.0, 0.008)
    middle, top = np.array([0.0, 0.0, float(np.mean(edge)) + 0.02]), np.array([-0.005, 0.0, CROWN + thickness[2]])
    return finish(close_grid(np.concatenate([inner, points]), middle, top), paint=_strands)


def _makers() -> dict[str, Callable[[int], Mesh]]:
    """Name → the function that makes the mesh of a level."""
    paints = {"hips": _shade_ends, "limb": _shade_ends}
    makers: dict[str, Callable[[int], Mesh]] = {name: partial(_shell, name) for name in TABLE["shells"]}
    for family in ("hips", "limb", "skirt", "hem", "bag", "tail"):
        for name in TABLE[family].keys() - {"loft"}:
            makers[name] = partial(_plain, family, name, paints.get(family))
    makers |= {name: partial(_footwear, name) for name in ("shoe", "sole")}
    makers |= {"left hand": partial(_hand, 1.0), "right hand": partial(_hand, -1.0), "collar": _collar}
    makers |= {"head man": partial(_head, 0.05), "head woman": partial(_head, -0.06), "eyes": _eyes}
    for torso in TABLE["torso"].keys() - {"loft"}:
        makers[torso] = partial(_torso, torso)
        makers[f"straps {torso}"] = partial(_straps, torso)
    for coat in ("jacket", "jacket woman"):
        makers[f"open {coat}"] = partial(_panel, coat, (-0.09, 0.525), (0.030, 0.048), 0.004)
        makers[f"buttoned {coat}"] = partial(_panel, coat, (0.14, 0.525), (0.006, 0.056), 0.004)
    return dict(sorted(makers.items()))


_MAKERS = _makers()
NAMES = tuple(_MAKERS)
"""The name of each mesh of a level."""


@cache
def library() -> tuple[Mesh, ...]:
    """The meshes of all levels, the finest first, each in the order of `NAMES`."""
    return tuple(make(level) for level in range(LEVELS) for make in _MAKERS.values())


@cache
def top_of(number: int) -> float:
    """Height in m of the highest point of a mesh, by its number in `NAMES`, in its own frame."""
    return float(library()[number].vertices[:, 2].max())
