"""Houses, trees and lamps, each in its own frame.

The front of a house faces −y, x to the right, with its lower left corner at (0, 0, 0). Trees and lamps stand at z = 0.
"""

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh, join_meshes
from vbbench_renderers.surroundings.shapes import (
    STREET,
    boxes,
    icosphere,
    one_of,
    place,
    points,
    quads,
    smooth_mesh,
    tube,
)
from vbbench_renderers.surroundings.site import Plot
from vbbench_renderers.surroundings.textures import DOOR, TILE, Layer, quarters

SILL = 0.85
"""Height of a window over its floor, m."""
GROUND_SILL, GROUND_HEAD = 0.95, 2.5
"""Heights of the lower and upper edge of the windows of the ground floor, m."""
DOOR_WIDTH = 1.15
NEAR, FAR = 20.0, 60.0
"""Windows of houses nearer to the walking area than the first, m, have mouldings and sills; beyond the second, m, there
are half as many."""
SURROUND, STANDS = 0.12, 0.03
"""How wide the moulding around windows is, and how far it stands before the wall, m."""


def house_mesh(plot: Plot, rng: np.random.Generator) -> Mesh:
    """The house of a plot in the site's frame."""
    wall = Layer(rng.choice([Layer.PLASTER, Layer.BRICK, Layer.ASHLAR], p=[0.55, 0.3, 0.15]))
    colour, trim = one_of(STREET["walls"][wall.name], rng) * rng.uniform(0.88, 1.05), one_of(STREET["trims"], rng)
    ground = rng.uniform(3.7, 4.2)
    floors = np.linspace(ground, plot.height, max(int(np.round((plot.height - ground) / 3.2)), 1) + 1)
    size = [plot.width, plot.depth, plot.height]
    sides = ("left", "right", "front")
    walls = boxes([0.0, 0.0, 0.0], size, colour, layer=wall, tile=TILE[wall], faces=sides, foot=0.75)
    parts = [walls, *_openings(plot, floors, trim, rng), *_bands(plot, floors, trim, rng)]
    parts.append(_roof(plot, colour, wall, rng))
    return place(join_meshes(parts), plot.u, plot.v, plot.yaw)


def _openings(plot: Plot, floors: FloatArray, trim: FloatArray, rng: np.random.Generator) -> list[Mesh]:
    """A window in each bay of each floor with its moulding and sill, and the door of the house in one of them."""
    count = max(int(np.round(plot.width / rng.uniform(2.5, 3.3) / (1.0 + (plot.distance > FAR)))), 2)
    bay, floor = (n.ravel() for n in np.meshgrid(np.arange(count), np.arange(len(floors))))
    door = (floor == 0) & (bay == rng.integers(count))
    wide, tall = min(rng.uniform(1.0, 1.45), plot.width / count - 0.9), rng.uniform(1.55, 2.0)
    middle, half = (bay + 0.5) * plot.width / count, 0.5 * np.where(door, DOOR_WIDTH, wide)
    left, right = middle - half, middle + half
    below = np.append(0.0, floors)[floor]
    low = np.where(door, 0.0, below + np.where(floor == 0, GROUND_SILL, SILL))
    high = np.where(floor == 0, GROUND_HEAD, np.minimum(low + tall, floors[floor] - 0.35))
    picture = np.where(door, DOOR, rng.choice(DOOR, len(bay), p=[0.4, 0.45, 0.15]))
    tint = np.where(door[:, None], 1.6 * one_of(STREET["doors"], rng), rng.uniform(0.75, 1.05, (len(bay), 1)))
    pane = tint[:, None] * np.array([0.95, 0.95, 0.72, 0.72])[:, None]
    panes = quads(_upright(left, right, low, high, -2.0 * STANDS), pane, layer=Layer.OPENINGS, uv=quarters(picture))
    if plot.distance > NEAR:
        return [panes]
    mouldings = quads(_upright(left - SURROUND, right + SURROUND, low, high + SURROUND, -STANDS), trim * 0.85)
    step = boxes([left[door][0], -0.3, 0.0], [right[door][0], 0.0, 0.06], [0.33, 0.32, 0.30])
    left, right, low = (edge[~door] for edge in (left, right, low))
    sills = points(left - 0.16, -0.14, low - 0.09), points(right + 0.16, 0.0, low)
    return [panes, mouldings, step, boxes(*sills, trim, faces=("front", "top", "bottom"))]


def _upright(x0: ArrayLike, x1: ArrayLike, z0: ArrayLike, z1: ArrayLike, y: float) -> FloatArray:
    """[N, 4, 3] rectangles that face the walking area, at depth y, m."""
    corners = (x0, z0), (x1, z0), (x1, z1), (x0, z1)
    return np.stack([points(x, y, z) for x, z in corners], axis=1)


def _bands(plot: Plot, floors: FloatArray, trim: FloatArray, rng: np.random.Generator) -> list[Mesh]:
    """String courses between floors, always one over the ground floor, and the cornice under the eaves."""
    wide, top, reach = plot.width, plot.height, rng.uniform(0.25, 0.45)
    heights = floors[:-1] if rng.random() < 0.4 and plot.distance < NEAR else floors[:1]
    faces = ("left", "right", "front", "bottom")
    courses = boxes(points(-0.02, -0.1, heights - 0.12), points(wide + 0.02, 0.0, heights + 0.12), trim, faces=faces)
    lower = boxes([-0.05, -0.5 * reach, top - 0.45], [wide + 0.05, 0.1, top - 0.2], trim * 0.8, faces=faces)
    return [courses, lower, boxes([-0.1, -reach, top - 0.2], [wide + 0.1, 0.1, top], trim, faces=(*faces, "top"))]


def _roof(plot: Plot, wall: FloatArray, layer: Layer, rng: np.random.Generator) -> Mesh:
    """A pitched roof with gables and a chimney."""
    colour = one_of(STREET["tiles"], rng)
    top, wide, deep = plot.height, plot.width, plot.depth
    rise, eaves, ridge = rng.uniform(0.3, 0.5) * deep, -0.48, 0.5 * deep
    tiles = quads(
        [[[-0.12, eaves, top + 0.02], [wide + 0.12, eaves, top + 0.02],
          [wide + 0.12, ridge, top + rise], [-0.12, ridge, top + rise]]],
        colour, layer=Layer.ROOF,
        uv=np.array([[[0, 0], [wide, 0], [wide, deep * 0.6], [0, deep * 0.6]]]) / TILE[Layer.ROOF],
    )  # fmt: skip
    ends = [
        [[0, deep, top], [0, 0, top], [0, ridge, top + rise - 0.1], [0, ridge, top + rise - 0.1]],
        [[wide, 0, top], [wide, deep, top], [wide, ridge, top + rise - 0.1], [wide, ridge, top + rise - 0.1]],
    ]
    gables = quads(ends, wall * 0.9, layer=layer, tile=TILE[layer])
    x = rng.uniform(0.5, wide - 1.5)
    chimney = [x, ridge - 0.6, top + 0.6 * rise], [x + 0.9, ridge, top + rise + rng.uniform(0.8, 1.5)]
    return join_meshes([tiles, gables, boxes(*chimney, [0.45, 0.26, 0.19], layer=Layer.BRICK, tile=TILE[Layer.BRICK])])


BARK = np.array([0.20, 0.155, 0.115])
DETAILED = 12.0
"""Trees nearer than this are detailed, m."""
LEAF = 0.40
"""Length of a leaf card at short distance, m."""


def tree(size: float, distance: float, rng: np.random.Generator) -> Mesh:
    """A broad-leaved tree about 6 m high times `size`, simpler the farther away, in its own frame.

    Parameters
    ----------
    size : scale.
    distance : from the walking area, m.
    rng : form and colour.
    """
    near = distance < DETAILED
    fork = rng.uniform(2.0, 2.4) * size
    centre = np.array([0.0, 0.0, fork + 1.6 * size])
    count = 3 if near else 2
    angle = rng.uniform(0.0, 2.0 * np.pi) + (np.arange(count) + rng.uniform(-0.2, 0.2, count)) * 2.0 * np.pi / count
    spread = rng.uniform(0.75, 1.1, count) * size
    offsets = np.column_stack([spread * np.cos(angle), spread * np.sin(angle), rng.uniform(-0.6, 0.25, count) * size])
    centres = centre + np.vstack([offsets, [[*rng.uniform(-0.2, 0.2, 2), rng.uniform(0.7, 1.0) * size]]])
    radii = rng.uniform(0.95, 1.3, count + 1) * size
    cards = int(np.clip(1600.0 / distance, 50, 300))
    parts = [_trunk(fork, size, near=near), *_crown(centres, radii, centre, cards, max(LEAF, 0.03 * distance), rng)]
    if near:
        parts += [_bough(np.array([0.0, 0.0, fork * 0.95]), end, size) for end in centres[:count]]
    return join_meshes(parts)


def _crown(
    centres: FloatArray, radii: FloatArray, centre: FloatArray, cards: int, leaf: float, rng: np.random.Generator
) -> list[Mesh]:
    """Blobs of foliage and the cards around them; the lower and inner parts are darker."""
    green = one_of(STREET["foliage"], rng) * rng.uniform(0.85, 1.15)
    parts = [_core(c, r, centre, green, 0 if leaf > 0.44 else 1, rng) for c, r in zip(centres, radii, strict=True)]
    owner = rng.choice(len(radii), 3 * cards, p=radii**2 / np.sum(radii**2))
    out = rng.standard_normal((3 * cards, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    spots = centres[owner] + radii[owner, None] * rng.uniform(0.88, 1.12, (3 * cards, 1)) * out
    inside = np.linalg.norm(spots[:, None] - centres, axis=2) < 0.84 * radii
    kept = np.flatnonzero(~inside.any(axis=1))[:cards]
    low, high = float((centres[:, 2] - radii).min()), float((centres[:, 2] + radii).max())
    shade = 0.50 + 0.80 * np.clip((spots[kept, 2] - low) / (high - low), 0.0, 1.0)
    parts.append(_cards(spots[kept], out[kept], green, shade, leaf, rng))
    return parts


def _core(
    at: FloatArray, radius: float, middle: FloatArray, green: FloatArray, fineness: int, rng: np.random.Generator
) -> Mesh:
    ball, triangles = icosphere(fineness)
    waves = rng.standard_normal((3, 3)) * 2.5
    bumps = 1.0 + 0.07 * np.sin(ball @ waves + rng.uniform(0.0, 6.0, 3)).sum(axis=1, keepdims=True)
    points = at + 0.93 * radius * ball * bumps
    shade = 0.42 * (0.45 + 0.35 * (ball[:, 2:] + 1.0)) * (1.0 + 0.15 * rng.standard_normal((len(ball), 1)))
    uv = np.stack([points[:, 0] + points[:, 1], points[:, 2] + 0.5 * points[:, 1]], axis=1) / TILE[Layer.LEAVES]
    normals = ball + 0.4 * (points - middle)
    return smooth_mesh(points, normals, green * shade, triangles, uv=uv, layer=Layer.LEAVES)


def _cards(
    spots: FloatArray, out: FloatArray, green: FloatArray, shade: FloatArray, leaf: float, rng: np.random.Generator
) -> Mesh:
    """Triangles of leaves, tilted at random but facing outwards."""
    count = len(spots)
    facing = out + 0.38 * rng.standard_normal((count, 3))
    facing *= np.sign((facing * out).sum(axis=1, keepdims=True))
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    along = np.cross(facing, rng.standard_normal((count, 3)))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(facing, along)
    half = 0.5 * leaf * rng.uniform(0.75, 1.25, (count, 1))
    shape = np.array([[1.0, 0.0], [-0.8, 0.8], [-0.8, -0.8]])
    corners = spots[:, None] + half[:, None] * (shape[:, :1] * along[:, None] + shape[:, 1:] * across[:, None])
    tone = shade[:, None] * (1.0 + 0.22 * rng.standard_normal((count, 1)))
    tints = green * tone * (1.0 + rng.uniform(-0.12, 0.2, (count, 1)) * np.array([1.0, 0.2, 0.0]))
    start = rng.random((count, 1, 2))
    uv = start + np.array([[0.5, 0.0], [-0.4, 0.4], [-0.4, -0.4]]) * leaf / TILE[Layer.LEAVES]
    triangles = np.arange(3 * count).reshape(-1, 3)
    normals = np.repeat(out + 0.6 * facing, 3, axis=0)
    return smooth_mesh(corners, normals, np.repeat(tints, 3, axis=0), triangles, uv=uv, layer=Layer.LEAVES)


def _trunk(fork: float, size: float, *, near: bool) -> Mesh:
    profile = np.array([[0.24, 0.0], [0.17, 0.18], [0.145, 0.7], [0.13, fork], [0.10, fork + 0.8]])
    profile[:, 0] *= size
    shades = np.array([0.5, 0.8, 1.0, 0.75, 0.5])
    return tube(profile, BARK * shades[:, None], sides=7 if near else 4)


def _bough(start: FloatArray, end: FloatArray, size: float) -> Mesh:
    """A bough from the fork into the crown: an upright tube, sheared."""
    rod = tube([[0.075 * size, 0.0], [0.035 * size, 1.0]], BARK * np.array([[0.7], [0.35]]), sides=5)
    lean = (end - start)[:2]
    points = rod.vertices.astype(np.float64)
    moved = np.column_stack([points[:, :2] + points[:, 2:] * lean, points[:, 2] * (end - start)[2]]) + start
    return smooth_mesh(
        moved, rod.normals.astype(np.float64), rod.colours.astype(np.float64), rod.triangles.astype(np.int64)
    )


IRON = np.array([0.035, 0.04, 0.042])


def lamp(rng: np.random.Generator) -> Mesh:
    """A lamp post about 4 m high with a lantern."""
    shades = np.array([[0.6], [1.0], [1.2], [1.0], [1.0], [1.0]])
    top = rng.uniform(3.4, 3.9)
    profile = [[0.13, 0.0], [0.13, 0.25], [0.075, 0.35], [0.07, 0.9], [0.045, 1.0], [0.04, top]]
    glass = tube([[0.06, top], [0.10, top + 0.03], [0.17, top + 0.45]], [0.75, 0.73, 0.62], sides=6)
    cap = tube([[0.21, top + 0.44], [0.20, top + 0.48], [0.06, top + 0.62], [0.02, top + 0.75]], IRON, sides=6)
    return join_meshes([tube(profile, IRON * shades, sides=7), glass, cap])
