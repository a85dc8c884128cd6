"""Houses: real relief near the walking area, pictures of windows far away.

A house is built in the frame of its front: x to the right, y away from the walking area, z up, from (0, 0, 0).
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.surroundings.facade import Front, balconies, plain_floors, upper_floors
from vbbench_renderers.surroundings.layers import TILE, Layer
from vbbench_renderers.surroundings.layout import Plot
from vbbench_renderers.surroundings.shapes import SPREAD, Quads, boxes, join, place, quads
from vbbench_renderers.surroundings.shopfronts import ground_floor

EYE = 2.0
"""Things nearer than their height minus this, in m, are outside the picture, which reaches about 45° upwards."""
FLAT = 19.5
"""Houses farther from the walking area than this have painted windows, m."""
RELIEF = 14.0
"""Houses nearer than this have windows recessed into the wall, m …"""
RELIEF_WIDTH, PLAIN_WIDTH = 30.0, 84.0
"""… as long as their total width is at most this, m; up to the second width windows are on the surface, beyond it
they are painted."""
WALLS = {
    Layer.PLASTER: [
        (0.80, 0.70, 0.50),
        (0.72, 0.46, 0.30),
        (0.84, 0.80, 0.72),
        (0.62, 0.66, 0.66),
        (0.74, 0.56, 0.46),
        (0.55, 0.62, 0.50),
        (0.82, 0.62, 0.36),
        (0.50, 0.56, 0.64),
    ],
    Layer.BRICK: [(0.50, 0.20, 0.13), (0.60, 0.30, 0.19), (0.42, 0.19, 0.15), (0.62, 0.46, 0.30)],
    Layer.ASHLAR: [(0.72, 0.64, 0.50), (0.66, 0.62, 0.56), (0.78, 0.72, 0.62)],
}
"""Colours of walls by what they are made of, linear RGB, multiplied with the texture."""
TRIMS = [(0.80, 0.77, 0.70), (0.62, 0.57, 0.49), (0.86, 0.85, 0.83), (0.55, 0.50, 0.44)]
TILES = [(0.50, 0.22, 0.14), (0.40, 0.20, 0.15), (0.20, 0.20, 0.22), (0.30, 0.25, 0.22)]


def house_meshes(plots: tuple[Plot, ...], rng: np.random.Generator) -> list[Mesh]:
    """All houses in the site's frame, the nearest in relief."""
    order = np.argsort([plot.distance for plot in plots], kind="stable")
    widths = np.cumsum([plots[n].width for n in order])
    before = {int(n): float(width) for n, width in zip(order, widths, strict=True)}
    return [house_mesh(plot, rng, before[n]) for n, plot in enumerate(plots)]


def house_mesh(plot: Plot, rng: np.random.Generator, before: float) -> Mesh:
    """The house of a plot in the site's frame; `before` is the width of the houses up to this one, m."""
    relief = plot.distance < RELIEF and before < RELIEF_WIDTH
    flat = plot.distance > FLAT or before > PLAIN_WIDTH
    front = _front(plot, rng)
    parts = [_roof(plot, np.array(TILES[rng.integers(len(TILES))]), front, rng, dormers=relief)]
    if flat:
        parts.append(_painted(plot, front))
    else:
        parts += [ground_floor(front, rng, shop=rng.random() < 0.75), _gables(plot, front), _cornice(plot, front, rng)]
        parts += [upper_floors(front, rng), balconies(front, rng)] if relief else [plain_floors(front, rng)]
    whole = join(parts)
    seen_from = np.maximum(plot.distance, whole.corners[..., 2].min(axis=1) - EYE)
    return place(whole.divide(SPREAD * seen_from).mesh(), plot.u, plot.v, plot.yaw)


def _front(plot: Plot, rng: np.random.Generator) -> Front:
    wall = Layer(rng.choice([Layer.PLASTER, Layer.BRICK, Layer.ASHLAR], p=[0.55, 0.3, 0.15]))
    count = max(int(np.round(plot.width / rng.uniform(2.5, 3.3))), 2)
    foot = rng.uniform(3.7, 4.2)
    storeys = max(int(np.round((plot.height - foot) / 3.2)), 1)
    choices = WALLS[wall]
    bay = plot.width / count
    return Front(
        wall=wall,
        colour=np.array(choices[rng.integers(len(choices))]) * rng.uniform(0.88, 1.05),
        trim=np.array(TRIMS[rng.integers(len(TRIMS))]),
        bays=np.linspace(0.0, plot.width, count + 1),
        floors=np.linspace(foot, plot.height, storeys + 1),
        window=(min(rng.uniform(1.0, 1.45), bay - 0.9), rng.uniform(1.55, 2.0)),
        panes=Layer.WINDOWS_OLD if rng.random() < 0.5 else Layer.WINDOWS,
    )


def _painted(plot: Plot, front: Front) -> Quads:
    """A distant house: walls with painted windows, one per bay and storey."""
    size = np.array([plot.width, plot.depth, plot.height])
    across, up = (len(front.bays) - 1) / 4.0, np.round(plot.height / 3.3) / 4.0
    deep = np.round(plot.depth / 3.0) / 4.0
    parts = []
    for face, wide in (("front", across), ("left", deep), ("right", deep)):
        wall = boxes([0, 0, 0], size, front.colour, faces=(face,), foot=0.7)
        parts.append(quads(wall.corners, wall.colours, layer=Layer.DISTANT,
                           uv=np.array([[[0, 0], [wide, 0], [wide, up], [0, up]]])))  # fmt: skip
    return join(parts)


def _gables(plot: Plot, front: Front) -> Quads:
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


def _cornice(plot: Plot, front: Front, rng: np.random.Generator) -> Quads:
    """Mouldings under the eaves, and the shadow that they cast on the wall."""
    top, reach = plot.height, rng.uniform(0.25, 0.45)
    faces = ("left", "right", "front", "bottom")
    parts = [
        boxes([-0.05, -0.5 * reach, top - 0.45], [plot.width + 0.05, 0.1, top - 0.2], front.trim * 0.8, faces=faces),
        boxes([-0.1, -reach, top - 0.2], [plot.width + 0.1, 0.1, top], front.trim, faces=(*faces, "top")),
    ]
    if plot.distance < RELIEF and rng.random() < 0.5:
        blocks = np.arange(0.3, plot.width - 0.3, 1.1)
        low = np.column_stack([blocks, np.full_like(blocks, -reach * 0.9), np.full_like(blocks, top - 0.36)])
        parts.append(
            boxes(low, low + np.array([0.16, reach * 0.9, 0.16]), front.trim * 0.85, faces=("left", "right", "front"))
        )
    return join(parts)


def _roof(plot: Plot, colour: FloatArray, front: Front, rng: np.random.Generator, *, dormers: bool) -> Quads:
    """A pitched roof with gables and a chimney, sometimes with dormers."""
    top, wide, deep = plot.height, plot.width, plot.depth
    rise = rng.uniform(0.3, 0.5) * deep
    eaves, ridge = -0.48, 0.5 * deep
    slope = rise / (ridge - eaves)
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
    parts = [tiles, gutter, quads(ends, front.colour * 0.9, layer=front.wall, tile=TILE[front.wall])]
    if plot.distance > FLAT:
        return join([tiles, parts[-1]])
    for x in rng.uniform(0.5, wide - 1.5, 1):
        low = np.array([x, ridge - 0.6, top + 0.6 * rise])
        parts.append(boxes(low, [x + 0.9, ridge, top + rise + rng.uniform(0.8, 1.5)], [0.45, 0.26, 0.19],
                           layer=Layer.BRICK, tile=TILE[Layer.BRICK]))  # fmt: skip
    if dormers and rng.random() < 0.6:
        middles = 0.5 * (front.bays[1:] + front.bays[:-1])[:: int(rng.integers(1, 3))]
        parts += [_dormer(x, eaves + 0.9, top + 0.9 * slope, slope, front) for x in middles]
    return join(parts)


def _dormer(x: float, y: float, z: float, slope: float, front: Front) -> Quads:
    half, tall = 0.6, 1.35
    deep = tall / slope
    box = boxes([x - half, y, z], [x + half, y + deep, z + tall], front.trim * 0.8, faces=("left", "right"))
    lid = boxes([x - half - 0.12, y - 0.15, z + tall], [x + half + 0.12, y + deep, z + tall + 0.12], [0.25, 0.25, 0.27],
                faces=("left", "right", "front", "bottom"))  # fmt: skip
    pane = quads(
        [[[x - half, y, z], [x + half, y, z], [x + half, y, z + tall], [x - half, y, z + tall]]],
        0.9, layer=front.panes, uv=[[[0.01, 0.01], [0.49, 0.01], [0.49, 0.49], [0.01, 0.49]]],
    )  # fmt: skip
    return join([box, lid, pane])
