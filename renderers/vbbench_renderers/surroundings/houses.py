"""Houses each in its own frame: the front faces −y, x to the right, with its lower left corner at (0, 0, 0)."""

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh, join_meshes
from vbbench_renderers.surroundings.shapes import STREET, boxes, one_of, place, points, quads
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
