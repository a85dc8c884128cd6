"""The ground floor of a façade: shop windows, doors, signs and awnings, or windows over a plinth."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.surroundings.facade import Front, graded, upright, wall
from vbbench_renderers.surroundings.layers import TILE, Layer
from vbbench_renderers.surroundings.panes import quarter
from vbbench_renderers.surroundings.shapes import Quads, boxes, join, quads

PAINTS = [
    (0.05, 0.09, 0.07),
    (0.06, 0.08, 0.16),
    (0.28, 0.05, 0.05),
    (0.09, 0.09, 0.10),
    (0.32, 0.22, 0.13),
    (0.45, 0.44, 0.40),
]
"""Colours of doors and shop fronts, linear RGB."""
CLOTHS = [(0.55, 0.07, 0.06), (0.06, 0.22, 0.14), (0.08, 0.14, 0.34), (0.70, 0.50, 0.16), (0.42, 0.20, 0.10)]
"""Colours of awnings, linear RGB; every second stripe is pale."""
PALE = np.array([0.78, 0.75, 0.68])
DEEP = 0.24
"""Depth of shop windows and doors in the wall, m."""


def ground_floor(front: Front, rng: np.random.Generator, *, shop: bool) -> Quads:
    """The ground floor, bay by bay; one bay has the door of the house."""
    entrance = int(rng.integers(len(front.bays) - 1))
    paint = np.array(PAINTS[rng.integers(len(PAINTS))])
    cloth = np.array(CLOTHS[rng.integers(len(CLOTHS))])
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
    zero = np.zeros(len(edges))
    return boxes(
        np.column_stack([edges[:, 0], zero - 0.05, zero]),
        np.column_stack([edges[:, 1], zero, zero + 0.42]),
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
        return np.stack([np.column_stack([x, np.full(count, y), np.full(count, z)]) for x, y, z in ends], axis=1)

    upper = quads(strip(out, low, -0.15, high), stripes)
    front = quads(strip(out, hem, out, low), stripes * 0.95)
    under = quads(strip(out, low - 0.01, -0.15, high - 0.01)[:, ::-1], stripes * 0.45)
    return join([upper, front, under])
