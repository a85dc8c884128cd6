"""Houses each in its own frame: the front faces −y, x to the right, with its lower left corner at (0, 0, 0)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray, IntArray
from vbbench_renderers.meshes import Mesh, join_meshes
from vbbench_renderers.surroundings.shapes import STREET, boxes, one_of, place, points, quads
from vbbench_renderers.surroundings.site import Plot
from vbbench_renderers.surroundings.textures import DOOR, TILE, Layer, quarters


@dataclass(frozen=True, kw_only=True)
class Front:
    """A façade.

    Parameters
    ----------
    wall : layer of the wall.
    colour, trim : [3] linear RGB of wall and mouldings.
    bays : [B + 1] borders of the bays, m from the left.
    floors : [F + 1] heights of the upper floors and of the eaves, m.
    window : width and height of a window, m.
    """

    wall: Layer
    colour: FloatArray
    trim: FloatArray
    bays: FloatArray
    floors: FloatArray
    window: tuple[float, float]


def upright(x0: ArrayLike, x1: ArrayLike, z0: ArrayLike, z1: ArrayLike, y: float = 0.0) -> FloatArray:
    """[N, 4, 3] rectangles that face the walking area, at depth y, m."""
    values = (np.atleast_1d(np.asarray(value, float)) for value in (x0, x1, z0, z1))
    left, right, low, high = np.broadcast_arrays(*values)
    corners = (left, low), (right, low), (right, high), (left, high)
    return np.stack([points(x, y, z) for x, z in corners], axis=1)


SILL = 0.85
"""Height of a window over its floor, m."""
DEEP = 0.2
"""Depth of windows and doors in the wall, m."""
GROUND_SILL, GROUND_HEAD = 0.95, 2.5
"""Heights of the lower and upper edge of the windows of the ground floor, m."""
DOOR_WIDTH = 1.15


@dataclass(frozen=True, kw_only=True)
class Opening:
    """N windows or doors, each in its rectangle of wall; m from the left end and from the foot of the front.

    Parameters
    ----------
    around : [4, N] left, right, lower and upper edge of the rectangles of wall.
    edges : [4, N] those of the openings.
    picture : [N] number of the picture in the layer of openings.
    tint : [N, 1, 3] the colour that the picture is multiplied with.
    """

    around: FloatArray
    edges: FloatArray
    picture: IntArray
    tint: FloatArray


def pierced_wall(front: Front, openings: Opening) -> Mesh:
    """Rectangles of wall, what is set into their openings, and the reveals in between."""
    x0, x1, z0, z1 = openings.around
    a, b, low, high = openings.edges
    below = upright(a, b, z0, low)[low > z0]
    faces = [upright(x0, a, z0, z1), upright(b, x1, z0, z1), upright(a, b, high, z1), below]
    left = [points(a, y, z) for y, z in ((0.0, low), (DEEP, low), (DEEP, high), (0.0, high))]
    right = [points(b, y, z) for y, z in ((DEEP, low), (0.0, low), (0.0, high), (DEEP, high))]
    lid = [points(x, y, high) for x, y in ((a, 0.0), (a, DEEP), (b, DEEP), (b, 0.0))]
    pane = openings.tint * np.array([0.95, 0.95, 0.72, 0.72])[:, None]
    return join_meshes(
        [
            quads(np.concatenate(faces), front.colour, layer=front.wall, tile=TILE[front.wall]),
            quads(upright(a, b, low, high, DEEP), pane, layer=Layer.OPENINGS, uv=quarters(openings.picture)),
            quads(np.concatenate([np.stack(side, axis=1) for side in (left, right)]), front.trim * 0.8),
            quads(np.stack(lid, axis=1), front.trim * 0.4),
        ]
    )


def upper_floors(front: Front, rng: np.random.Generator) -> Mesh:
    """Walls and windows above the ground floor, with their sills."""
    bay, floor = (n.ravel() for n in np.meshgrid(np.arange(len(front.bays) - 1), np.arange(len(front.floors) - 1)))
    (left, right), sill = (column[bay] for column in _columns(front)), front.floors[floor] + SILL
    head = np.minimum(sill + front.window[1], front.floors[floor + 1] - 0.35)
    windows = Opening(
        around=np.stack([front.bays[bay], front.bays[bay + 1], front.floors[floor], front.floors[floor + 1]]),
        edges=np.stack([left, right, sill, head]),
        picture=rng.choice(DOOR, len(bay), p=[0.4, 0.45, 0.15]),
        tint=rng.uniform(0.75, 1.05, (len(bay), 1, 1)) * np.ones(3),
    )
    return join_meshes([pierced_wall(front, windows), _sills(front, left, right, sill), *_bands(front, rng)])


def ground_floor(front: Front, rng: np.random.Generator) -> Mesh:
    """The ground floor, a window in each bay but one, which has the door of the house, and a stone foot."""
    count = len(front.bays) - 1
    entrance = int(rng.integers(count))
    door = np.arange(count) == entrance
    middle, half = 0.5 * (front.bays[1:] + front.bays[:-1]), 0.5 * np.where(door, DOOR_WIDTH, front.window[0])
    sill = np.where(door, 0.0, GROUND_SILL)
    openings = Opening(
        around=np.stack([front.bays[:-1], front.bays[1:], np.zeros(count), np.full(count, front.floors[0])]),
        edges=np.stack([middle - half, middle + half, sill, np.full(count, GROUND_HEAD)]),
        picture=np.where(door, DOOR, rng.choice(DOOR, count)),
        tint=np.where(door[:, None, None], 1.6 * one_of(STREET["doors"], rng), 1.0),
    )
    left, right = openings.edges[:2]
    step = boxes([left[entrance], -0.05, 0.0], [right[entrance], DEEP, 0.06], [0.33, 0.32, 0.30])
    foot = boxes(
        points([0.0, right[entrance]], -0.05, 0.0),
        points([left[entrance], front.bays[-1]], 0.0, 0.42),
        [0.42, 0.40, 0.37],
        layer=Layer.ASHLAR,
        tile=TILE[Layer.ASHLAR],
        foot=0.55,
    )
    return join_meshes(
        [pierced_wall(front, openings), _sills(front, left[~door], right[~door], sill[~door]), step, foot]
    )


def _columns(front: Front) -> tuple[FloatArray, FloatArray]:
    """[B] left and right edges of the windows of the bays."""
    middle = 0.5 * (front.bays[1:] + front.bays[:-1])
    return middle - 0.5 * front.window[0], middle + 0.5 * front.window[0]


def _sills(front: Front, left: FloatArray, right: FloatArray, height: FloatArray) -> Mesh:
    low, high = points(left - 0.08, -0.1, height - 0.09), points(right + 0.08, DEEP, height)
    return boxes(low, high, front.trim, faces=("front", "top", "bottom"))


def _bands(front: Front, rng: np.random.Generator) -> list[Mesh]:
    """String courses between floors; always one over the ground floor."""
    heights = front.floors[:-1] if rng.random() < 0.4 else front.floors[:1]
    wide = front.bays[-1]
    return [
        boxes([-0.02, -0.10, z - 0.12], [wide + 0.02, 0.0, z + 0.12], front.trim, faces=("front", "bottom"))
        for z in heights
    ]


RELIEF, RELIEF_WIDTH = 19.5, 60.0
"""Houses nearer than the first, m, have windows set into the wall, as long as their total width is at most the second,
m; the windows of others are painted."""


def house_meshes(plots: tuple[Plot, ...], rng: np.random.Generator) -> list[Mesh]:
    """All houses in the site's frame, the nearest in relief."""
    order = np.argsort([plot.distance for plot in plots], kind="stable")
    widths = np.cumsum([plots[n].width for n in order])
    before = {int(n): float(width) for n, width in zip(order, widths, strict=True)}
    return [house_mesh(plot, rng, before[n]) for n, plot in enumerate(plots)]


def house_mesh(plot: Plot, rng: np.random.Generator, before: float) -> Mesh:
    """The house of a plot in the site's frame; `before` is the width of the houses up to this one, m."""
    front = _front(plot, rng)
    parts = [_roof(plot, one_of(STREET["tiles"], rng), front, rng)]
    if plot.distance < RELIEF and before < RELIEF_WIDTH:
        parts += [ground_floor(front, rng), _gables(plot, front), _cornice(plot, front, rng), upper_floors(front, rng)]
    else:
        parts.append(_painted(plot, front))
    return place(join_meshes(parts), plot.u, plot.v, plot.yaw)


def _front(plot: Plot, rng: np.random.Generator) -> Front:
    wall = Layer(rng.choice([Layer.PLASTER, Layer.BRICK, Layer.ASHLAR], p=[0.55, 0.3, 0.15]))
    count = max(int(np.round(plot.width / rng.uniform(2.5, 3.3))), 2)
    foot = rng.uniform(3.7, 4.2)
    storeys = max(int(np.round((plot.height - foot) / 3.2)), 1)
    bay = plot.width / count
    return Front(
        wall=wall,
        colour=one_of(STREET["walls"][wall.name], rng) * rng.uniform(0.88, 1.05),
        trim=one_of(STREET["trims"], rng),
        bays=np.linspace(0.0, plot.width, count + 1),
        floors=np.linspace(foot, plot.height, storeys + 1),
        window=(min(rng.uniform(1.0, 1.45), bay - 0.9), rng.uniform(1.55, 2.0)),
    )


def _painted(plot: Plot, front: Front) -> Mesh:
    """A distant house: walls with painted windows, one per bay and storey."""
    up = np.round(plot.height / 3.3) / 4.0
    deep = np.round(plot.depth / 3.0)
    size, sides = [plot.width, plot.depth, plot.height], []
    for face, windows in (("front", len(front.bays) - 1), ("left", deep), ("right", deep)):
        wide = float(windows) / 4.0
        uv = np.array([[[0.0, 0.0], [wide, 0.0], [wide, up], [0.0, up]]])
        sides.append(boxes([0, 0, 0], size, front.colour, layer=Layer.DISTANT, uv=uv, faces=(face,), foot=0.7))
    return join_meshes(sides)


def _gables(plot: Plot, front: Front) -> Mesh:
    """The side walls, darker at the foot, and the support of the roof."""
    return boxes(
        [0.0, 0.0, 0.0],
        [plot.width, plot.depth, plot.height],
        front.colour * 0.94,
        layer=front.wall,
        tile=TILE[front.wall],
        faces=("left", "right"),
        foot=0.75,
    )


def _cornice(plot: Plot, front: Front, rng: np.random.Generator) -> Mesh:
    """Mouldings under the eaves."""
    top, reach = plot.height, rng.uniform(0.25, 0.45)
    faces = ("left", "right", "front", "bottom")
    lower = [-0.05, -0.5 * reach, top - 0.45], [plot.width + 0.05, 0.1, top - 0.2]
    upper = [-0.1, -reach, top - 0.2], [plot.width + 0.1, 0.1, top]
    return join_meshes([boxes(*lower, front.trim * 0.8, faces=faces), boxes(*upper, front.trim, faces=(*faces, "top"))])


def _roof(plot: Plot, colour: FloatArray, front: Front, rng: np.random.Generator) -> Mesh:
    """A pitched roof with gables and a chimney."""
    top, wide, deep = plot.height, plot.width, plot.depth
    rise = rng.uniform(0.3, 0.5) * deep
    eaves, ridge = -0.48, 0.5 * deep
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
    gutter = boxes([-0.12, eaves - 0.07, top - 0.07], [wide + 0.12, 0.0, top + 0.05], colour * 0.5,
                   faces=("front", "bottom"))  # fmt: skip
    gables = quads(ends, front.colour * 0.9, layer=front.wall, tile=TILE[front.wall])
    if plot.distance > RELIEF:
        return join_meshes([tiles, gables])
    x = rng.uniform(0.5, wide - 1.5)
    chimney = [x, ridge - 0.6, top + 0.6 * rise], [x + 0.9, ridge, top + rise + rng.uniform(0.8, 1.5)]
    stack = boxes(*chimney, [0.45, 0.26, 0.19], layer=Layer.BRICK, tile=TILE[Layer.BRICK])
    return join_meshes([tiles, gutter, gables, stack])
