"""A façade, and its upper floors: windows recessed into the wall, with reveals, sills, lintels and balconies."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray
from vbbench_renderers.surroundings.layers import TILE, Layer
from vbbench_renderers.surroundings.panes import quarter
from vbbench_renderers.surroundings.shapes import Quads, boxes, join, quads


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
    left, right, low, high = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(value, float)) for value in (x0, x1, z0, z1))
    )
    level = np.full(left.shape, y)
    corners = [(left, level, low), (right, level, low), (right, level, high), (left, level, high)]
    return np.asarray(np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1))


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
    ends = [np.column_stack([x, np.full(len(x), y), z]) for x in (x0, x1) for y in (0, SET_BACK) for z in (low, high)]
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
    zero = np.zeros_like(x0)
    sills = boxes(
        np.column_stack([x0 - 0.08, zero - out, low - 0.09]), np.column_stack([x1 + 0.08, zero + SET_BACK, low]),
        front.trim, faces=("front", "bottom"),
    )  # fmt: skip
    parts = [sills]
    style = rng.random()
    if style < 0.65:
        parts.append(
            boxes(np.column_stack([x0 - 0.12, zero - 0.06, high]), np.column_stack([x1 + 0.12, zero, high + 0.16]),
                  front.trim, faces=("left", "right", "front"))
        )  # fmt: skip
    if style < 0.2:
        for start, end in ((x0 - 0.12, x0), (x1, x1 + 0.12)):
            parts.append(
                boxes(np.column_stack([start, zero - 0.045, low]), np.column_stack([end, zero, high]), front.trim,
                      faces=("left", "right", "front"))
            )  # fmt: skip
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
    low = np.column_stack([bars - 0.012, np.full(7, -out + 0.02), np.full(7, z)])
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
    low = np.column_stack([spots, rng.uniform(-0.30, -0.22, 4), np.full(4, z + 0.14)])
    tall = rng.uniform(0.08, 0.22, 4)
    green, bloom = np.array([0.08, 0.16, 0.04]), np.array([[0.6, 0.05, 0.07], [0.65, 0.25, 0.35], [0.65, 0.45, 0.06]])
    bush = boxes(
        low, low + np.column_stack([np.full(4, 0.20), np.full(4, 0.14), tall]), green, faces=("left", "right", "front")
    )
    high = low + np.column_stack([np.zeros(4), np.zeros(4), tall * 0.6])
    heads = boxes(
        high - [0.0, 0.025, 0.0], high + np.array([0.12, 0.0, 0.07]), bloom[rng.integers(3)], faces=("front",)
    )
    return join([box, bush, heads])


def _nothing() -> Quads:
    return quads(np.zeros((0, 4, 3)), 0.0)
