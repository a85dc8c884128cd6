"""Houses in a frame of their own: the front faces −y, x to the right, with its lower left corner at (0, 0, 0)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.surroundings.shapes import SPREAD, STREET, Quads, boxes, join, one_of, place, points, quads
from vbbench_renderers.surroundings.site import Plot
from vbbench_renderers.surroundings.textures import TILE, Layer, quarter


@dataclass(frozen=True, kw_only=True)
class Front:
    """A façade.

    Parameters
    ----------
    wall, panes : layers of the wall and of the windows.
    colour, trim : [3] linear RGB of wall and mouldings.
    bays : [B + 1] borders of the bays, m from the left.
    floors : [F + 1] heights of the upper floors and of the eaves, m.
    window : width and height of a window, m.
    """

    wall: Layer
    panes: Layer
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


def graded(colour: ArrayLike, foot: float, head: float) -> FloatArray:
    """[1, 4, 3] colours of a rectangle that is darkened at its foot and at its head."""
    return np.asarray(np.asarray(colour) * np.array([foot, foot, head, head])[None, :, None])


def wall(front: Front, corners: FloatArray, tile: float, foot: float = 1.0, head: float = 1.0) -> Quads:
    """Rectangles of wall."""
    return quads(corners, graded(front.colour, foot, head), layer=front.wall, tile=tile)


SILL = 0.85
"""Height of a window over its floor, m."""
SET_BACK = 0.16
"""Depth of windows in the wall, m."""


def upper_floors(front: Front, rng: np.random.Generator) -> Quads:
    """Walls and windows above the ground floor."""
    left, right = _columns(front)
    base, top = front.floors[0], front.floors[-1]
    tile = TILE[front.wall]
    piers_from, piers_to = np.append(0.0, right), np.append(left, front.bays[-1])
    shadow = 0.55
    solid = [
        wall(front, upright(piers_from, piers_to, base, top), tile),
        wall(front, upright(piers_from, piers_to, top - 1.0, top, -0.004), tile, 1.0, shadow),
    ]
    x0, z0 = (grid.ravel() for grid in np.meshgrid(left, front.floors[:-1]))
    x1, z1 = (grid.ravel() for grid in np.meshgrid(right, front.floors[1:]))
    low, high = z0 + SILL, np.minimum(z0 + SILL + front.window[1], z1 - 0.35)
    upmost = np.where(z1 > top - 0.01, shadow, 1.0)[:, None, None]
    over = wall(front, upright(x0, x1, high, z1), tile)
    shaded = over.colours * np.concatenate([np.ones((len(x0), 2, 1)), np.repeat(upmost, 2, axis=1)], axis=1)
    solid += [
        wall(front, upright(x0, x1, z0, low), tile, 1.0, 0.9),
        quads(over.corners, shaded, layer=front.wall, tile=tile),
        _windows(front, x0, x1, low, high, rng),
        _mouldings(front, x0, x1, low, high, rng),
    ]
    return join([*solid, *_bands(front, rng)])


def plain_floors(front: Front, rng: np.random.Generator) -> Quads:
    """Walls above the ground floor with windows on the surface, for houses at some distance."""
    left, right = _columns(front)
    base, top = front.floors[0], front.floors[-1]
    x0, z0 = (grid.ravel() for grid in np.meshgrid(left, front.floors[:-1]))
    x1 = np.tile(right, len(front.floors) - 1)
    low = z0 + SILL
    high = low + np.minimum(front.window[1], np.diff(front.floors).min() - SILL - 0.35)
    return join(
        [
            wall(front, upright(0.0, front.bays[-1], base, top - 1.0), TILE[front.wall]),
            wall(front, upright(0.0, front.bays[-1], top - 1.0, top), TILE[front.wall], 1.0, 0.6),
            quads(upright(x0 - 0.1, x1 + 0.1, low - 0.1, high + 0.14, -0.03), graded(front.trim, 1.0, 0.75)),
            _panes(front, x0, x1, low, high, -0.06, rng),
            *_bands(front, rng),
        ]
    )


def balconies(front: Front, rng: np.random.Generator) -> Quads:
    """Balconies with railings in front of some windows of half of the houses; a plain flower box otherwise."""
    left, right = _columns(front)
    middle = 0.5 * (left + right)
    parts: list[Quads] = []
    iron = np.array([0.05, 0.05, 0.055])
    chosen = rng.random(len(middle)) < 0.45
    kind = rng.random()
    for floor in front.floors[:-1]:
        for x in middle[chosen]:
            if kind < 0.4:
                parts.append(_balcony(front, x, floor + 0.05, iron))
            elif kind < 0.8:
                parts.append(_flowers(x, floor + SILL, 0.5 * front.window[0], rng))
    return join([_nothing(), *parts])


def _columns(front: Front) -> tuple[FloatArray, FloatArray]:
    middle = 0.5 * (front.bays[1:] + front.bays[:-1])
    return middle - 0.5 * front.window[0], middle + 0.5 * front.window[0]


def _windows(
    front: Front, x0: FloatArray, x1: FloatArray, low: FloatArray, high: FloatArray, rng: np.random.Generator
) -> Quads:
    """Panes and the reveals around them."""
    panes = _panes(front, x0, x1, low, high, SET_BACK, rng)
    ends = [points(x, y, z) for x in (x0, x1) for y in (0, SET_BACK) for z in (low, high)]
    a, b, c, d, e, f, g, h = ends  # left: front low, front high, back low, back high; then right
    sides = np.concatenate([np.stack([a, c, d, b], axis=1), np.stack([g, e, f, h], axis=1)])
    lids = np.stack([b, d, h, f], axis=1)
    reveals = quads(sides, front.trim * 0.8)
    inner = front.trim * np.array([0.5, 0.3, 0.3, 0.5])[None, :, None]
    return join([panes, reveals, quads(lids, inner)])


def _panes(
    front: Front, x0: FloatArray, x1: FloatArray, low: FloatArray, high: FloatArray, y: float, rng: np.random.Generator
) -> Quads:
    """Pictures of windows at depth y, m, darker at the head."""
    number = rng.choice(4, len(x0), p=[0.3, 0.25, 0.1, 0.35])
    uv = np.stack([quarter(int(n)) for n in number])
    flip = rng.random(len(x0)) < 0.5
    uv[flip] = uv[flip][:, [1, 0, 3, 2]]
    tone = rng.uniform(0.75, 1.05, (len(x0), 1, 1)) * np.array([0.95, 0.95, 0.72, 0.72])[None, :, None]
    return quads(upright(x0, x1, low, high, y), tone, layer=front.panes, uv=uv)


def _mouldings(
    front: Front, x0: FloatArray, x1: FloatArray, low: FloatArray, high: FloatArray, rng: np.random.Generator
) -> Quads:
    """A sill under every window and, on some houses, a lintel or a whole frame around it."""
    out = rng.uniform(0.07, 0.13)
    sills = boxes(
        points(x0 - 0.08, -out, low - 0.09), points(x1 + 0.08, SET_BACK, low), front.trim, faces=("front", "bottom")
    )
    parts = [sills]
    style = rng.random()
    if style < 0.65:
        lintel = points(x0 - 0.12, -0.06, high), points(x1 + 0.12, 0.0, high + 0.16)
        parts.append(boxes(*lintel, front.trim, faces=("left", "right", "front")))
    if style < 0.2:
        for start, end in ((x0 - 0.12, x0), (x1, x1 + 0.12)):
            side = points(start, -0.045, low), points(end, 0.0, high)
            parts.append(boxes(*side, front.trim, faces=("left", "right", "front")))
    return join(parts)


def _bands(front: Front, rng: np.random.Generator) -> list[Quads]:
    """String courses between floors; always one over the ground floor."""
    heights = front.floors[:-1] if rng.random() < 0.4 else front.floors[:1]
    wide = front.bays[-1]
    return [
        boxes([-0.02, -0.10, z - 0.12], [wide + 0.02, 0.0, z + 0.12], front.trim, faces=("front", "bottom"))
        for z in heights
    ]


def _balcony(front: Front, x: float, z: float, iron: FloatArray) -> Quads:
    half, out = 0.5 * front.window[0] + 0.25, 0.75
    slab = boxes(
        [x - half, -out, z - 0.14], [x + half, 0, z], front.trim * 0.9, faces=("left", "right", "front", "bottom")
    )
    bars = np.linspace(x - half + 0.03, x + half - 0.03, 7)
    low = points(bars - 0.012, -out + 0.02, z)
    posts = boxes(low, low + np.array([0.024, 0.024, 0.95]), iron, faces=("front",))
    rails = [
        boxes([x - half, -out, z + 0.92], [x + half, -out + 0.05, z + 0.98], iron, faces=("front", "bottom")),
        boxes([x - half, -out, z + 0.92], [x - half + 0.04, 0.0, z + 0.98], iron, faces=("left", "right")),
        boxes([x + half - 0.04, -out, z + 0.92], [x + half, 0.0, z + 0.98], iron, faces=("left", "right")),
    ]
    return join([slab, posts, *rails])


def _flowers(x: float, z: float, half: float, rng: np.random.Generator) -> Quads:
    box = boxes(
        [x - half, -0.30, z - 0.02], [x + half, -0.06, z + 0.14], [0.30, 0.12, 0.07], faces=("front", "left", "right")
    )
    spots = np.linspace(x - half + 0.05, x + half - 0.22, 4)
    low = points(spots, rng.uniform(-0.30, -0.22, 4), z + 0.14)
    tall = rng.uniform(0.08, 0.22, 4)
    green, bloom = np.array([0.08, 0.16, 0.04]), np.array([[0.6, 0.05, 0.07], [0.65, 0.25, 0.35], [0.65, 0.45, 0.06]])
    bush = boxes(low, low + points(0.20, 0.14, tall), green, faces=("left", "right", "front"))
    high = low + points(0.0, 0.0, tall * 0.6)
    heads = boxes(high - [0.0, 0.025, 0.0], high + points(0.12, 0.0, 0.07), bloom[rng.integers(3)], faces=("front",))
    return join([box, bush, heads])


def _nothing() -> Quads:
    return quads(np.zeros((0, 4, 3)), 0.0)


PALE = np.array([0.78, 0.75, 0.68])
DEEP = 0.24
"""Depth of shop windows and doors in the wall, m."""


def ground_floor(front: Front, rng: np.random.Generator, *, shop: bool) -> Quads:
    """The ground floor, bay by bay; one bay has the door of the house."""
    entrance = int(rng.integers(len(front.bays) - 1))
    paint = one_of(STREET["doors"], rng)
    cloth = one_of(STREET["awnings"], rng)
    number, awnings = int(rng.integers(4)), rng.random() < 0.55
    parts: list[Quads] = []
    for bay, (x0, x1) in enumerate(zip(front.bays[:-1], front.bays[1:], strict=True)):
        if bay == entrance:
            parts.append(_opening(front, x0, x1, 1.15, 2.45, Layer.DOORS, int(rng.choice([0, 1, 2])), paint * 1.6))
        elif shop:
            pane = (number + int(rng.integers(2)) * 2) % 4
            parts.append(_opening(front, x0, x1, x1 - x0 - 0.5, 2.75, Layer.SHOPS, pane, np.ones(3)))
            if awnings:
                parts.append(_awning(x0 + 0.12, x1 - 0.12, cloth))
        else:
            parts.append(
                _opening(front, x0, x1, front.window[0], 2.5, front.panes, int(rng.integers(4)), np.ones(3), 0.95)
            )
    parts.append(_plinth(front, entrance, shop=shop))
    if shop:
        parts.append(_sign(front, entrance, number, paint))
    return join(parts)


def _opening(
    front: Front,
    x0: float,
    x1: float,
    wide: float,
    head: float,
    layer: Layer,
    number: int,
    tint: object,
    sill: float = 0.0,
) -> Quads:
    """A bay of wall with something recessed into it, from the height `sill` to `head`, m."""
    middle, top = 0.5 * (x0 + x1), float(front.floors[0])
    a, b = middle - 0.5 * wide, middle + 0.5 * wide
    tile = TILE[front.wall]
    parts = [
        wall(front, upright([x0, b], [a, x1], 0.0, top), tile, 0.8, 1.0),
        wall(front, upright(a, b, head, top), tile, 1.0, 0.85),
        quads(
            upright(a, b, sill, head, DEEP), graded(np.asarray(tint), 0.85, 0.6), layer=layer, uv=quarter(number)[None]
        ),
    ]
    if sill:
        parts.append(wall(front, upright(a, b, 0.0, sill), tile, 0.6, 1.0))
    reveal = front.trim * 0.75
    jambs = [
        [[a, 0, sill], [a, DEEP, sill], [a, DEEP, head], [a, 0, head]],
        [[b, DEEP, sill], [b, 0, sill], [b, 0, head], [b, DEEP, head]],
    ]
    parts.append(quads(jambs, graded(reveal, 0.6, 0.8)))
    parts.append(quads([[[a, 0, head], [a, DEEP, head], [b, DEEP, head], [b, 0, head]]], reveal * 0.4))
    if not sill:
        step = boxes([a, -0.05, 0.0], [b, DEEP, 0.06], [0.33, 0.32, 0.30], faces=("front", "top"))
        parts.append(step)
    else:
        parts.append(boxes([a - 0.08, -0.1, sill - 0.09], [b + 0.08, DEEP, sill], front.trim))
    return join(parts)


def _plinth(front: Front, entrance: int, *, shop: bool) -> Quads:
    """A stone foot along the wall, between the openings."""
    gaps: list[tuple[float, float]] = []
    start = 0.0
    for bay, (x0, x1) in enumerate(zip(front.bays[:-1], front.bays[1:], strict=True)):
        wide = 1.15 if bay == entrance else (x1 - x0 - 0.5 if shop else 0.0)
        if wide:
            middle = 0.5 * (x0 + x1)
            gaps.append((start, middle - 0.5 * wide))
            start = middle + 0.5 * wide
    gaps.append((start, float(front.bays[-1])))
    edges = np.array(gaps)
    return boxes(
        points(edges[:, 0], -0.05, 0.0),
        points(edges[:, 1], 0.0, 0.42),
        [0.42, 0.40, 0.37],
        layer=Layer.ASHLAR,
        tile=TILE[Layer.ASHLAR],
        faces=("left", "right", "front", "top"),
        foot=0.55,
    )


def _sign(front: Front, entrance: int, number: int, paint: object) -> Quads:
    """A fascia with lettering over the shop windows."""
    runs = [(0, entrance), (entrance + 1, len(front.bays) - 1)]
    parts: list[Quads] = []
    for first, last in runs:
        if last > first:
            a, b = front.bays[first] + 0.15, front.bays[last] - 0.15
            parts.append(
                boxes(
                    [a, -0.14, 2.85],
                    [b, 0.0, 3.42],
                    np.asarray(paint),
                    faces=("left", "right", "front", "top", "bottom"),
                )
            )
            middle, half = 0.5 * (a + b), min(0.5 * (b - a) - 0.1, 1.7)
            parts.append(quads(upright(middle - half, middle + half, 2.88, 3.39, -0.165), 1.0, layer=Layer.SIGNS,
                               uv=quarter(number)[None]))  # fmt: skip
    return join(parts)


def _awning(x0: float, x1: float, cloth: FloatArray) -> Quads:
    """A striped awning; seen from below it is dark."""
    count = max(int((x1 - x0) / 0.4) // 2 * 2 + 1, 3)
    edges = np.linspace(x0, x1, count + 1)
    high, low, hem, out = 2.84, 2.38, 2.2, -1.15
    stripes = np.where((np.arange(count) % 2 == 0)[:, None], cloth, PALE)[:, None, :]
    a, b = edges[:-1], edges[1:]

    def strip(y0: float, z0: float, y1: float, z1: float) -> FloatArray:
        ends = [(a, y0, z0), (b, y0, z0), (b, y1, z1), (a, y1, z1)]
        return np.stack([points(*end) for end in ends], axis=1)

    upper = quads(strip(out, low, -0.15, high), stripes)
    front = quads(strip(out, hem, out, low), stripes * 0.95)
    under = quads(strip(out, low - 0.01, -0.15, high - 0.01)[:, ::-1], stripes * 0.45)
    return join([upper, front, under])


EYE = 2.0
"""Things nearer than their height minus this, in m, are outside the picture, which reaches about 45° upwards."""
FLAT = 19.5
"""Houses farther from the walking area than this have painted windows, m."""
RELIEF = 14.0
"""Houses nearer than this have windows recessed into the wall, m …"""
RELIEF_WIDTH, PLAIN_WIDTH = 30.0, 84.0
"""… as long as their total width is at most this, m; up to the second width windows are on the surface, beyond it
they are painted."""


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
    parts = [_roof(plot, one_of(STREET["tiles"], rng), front, rng, dormers=relief)]
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
    bay = plot.width / count
    return Front(
        wall=wall,
        colour=one_of(STREET["walls"][wall.name], rng) * rng.uniform(0.88, 1.05),
        trim=one_of(STREET["trims"], rng),
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
        low = points(blocks, -reach * 0.9, top - 0.36)
        parts.append(boxes(low, low + points(0.16, reach * 0.9, 0.16), front.trim * 0.85, faces=faces[:3]))
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
