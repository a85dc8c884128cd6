"""Street furniture, cars, trees and hedges, each in its own frame: the front faces −y and the foot is at z = 0."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Float32, Mesh, join_meshes
from vbbench_renderers.surroundings.shapes import (
    STREET,
    Quads,
    boxes,
    icosphere,
    join,
    one_of,
    place,
    quads,
    smooth_mesh,
    tube,
    turned,
)
from vbbench_renderers.surroundings.textures import TILE, Layer, quarter

BARK = np.array([0.20, 0.155, 0.115])
NEAR = 12.0
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
    near = distance < NEAR
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


def hedge(length: float, distance: float, rng: np.random.Generator) -> Mesh:
    """A clipped hedge along x, 0.9 m high, in its own frame."""
    green = one_of(STREET["foliage"], rng)
    half, deep, tall = 0.5 * length, 0.32, 0.9
    core = boxes(
        [-half, -deep, 0.0], [half, deep, tall], green * 0.8, layer=Layer.LEAVES, tile=TILE[Layer.LEAVES], foot=0.4
    )
    count = int(length * np.clip(160.0 / distance, 6.0, 34.0))
    spots = rng.uniform([-half, -deep, 0.05], [half, deep, tall], (count, 3))
    side = rng.choice(3, count, p=[0.42, 0.42, 0.16])
    spots[side == 0, 1], spots[side == 1, 1], spots[side == 2, 2] = -deep, deep, tall
    out = np.array([[0.0, -1.0, 0.15], [0.0, 1.0, 0.15], [0.0, 0.0, 1.0]])[side]
    shade = 0.45 + 0.65 * spots[:, 2] / tall
    return join_meshes([core.divide(0.095 * distance).mesh(), _cards(spots, out, green, shade, 0.17, rng)])


def bush(radius: float, rng: np.random.Generator) -> Mesh:
    """A round bush that stands on z = 0."""
    centre = np.array([[0.0, 0.0, radius * 0.8]])
    return join_meshes(_crown(centre, np.array([radius]), centre[0], 40, 0.18, rng))


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
    shade = _depth_shade(spots[kept], centres, radii)
    parts.append(_cards(spots[kept], out[kept], green, shade, leaf, rng))
    return parts


def _depth_shade(points: FloatArray, centres: FloatArray, radii: FloatArray) -> FloatArray:
    """[N] tone by height in the crown: little light from above reaches the underside."""
    low, high = float((centres[:, 2] - radii).min()), float((centres[:, 2] + radii).max())
    return np.asarray(0.50 + 0.80 * np.clip((points[:, 2] - low) / (high - low), 0.0, 1.0))


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


GLASS = np.array([0.035, 0.045, 0.055])
SKY = np.array([0.22, 0.28, 0.34])
"""The reflection at the upper edge of the glass."""


def car(rng: np.random.Generator) -> list[Mesh | Quads]:
    """A car 4.2 m long along x, its nose at negative x."""
    paint = one_of(STREET["cars"], rng)
    tall, back = rng.uniform(1.40, 1.55), rng.uniform(1.35, 1.85)
    wheels = [
        place(_wheel(), x, side * 0.89, 0.5 * np.pi * (side + 1.0), 0.32) for x in (-1.35, 1.30) for side in (-1, 1)
    ]
    return [_hull(np.array(STREET["car_stations"]), paint), *_cabin(paint, tall, back), *_lights(), *wheels]


def _hull(stations: FloatArray, paint: FloatArray) -> Quads:
    """The lower body: sides in three bands, the top and both ends."""
    x, half, shoulder = stations.T
    sill, belt = np.full_like(x, 0.22), np.full_like(x, 0.48)
    rows = [(half - 0.06, sill, 0.25), (half, belt, 0.8), (half, shoulder - 0.10, 1.0),
            (half - 0.07, shoulder, 1.1)]  # fmt: skip
    faces, tints = [], []
    for (y0, z0, s0), (y1, z1, s1) in pairwise(rows):
        low, high = np.column_stack([x, -y0, z0]), np.column_stack([x, -y1, z1])
        near = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
        far = (near * [1.0, -1.0, 1.0])[:, [1, 0, 3, 2]]
        front = np.stack([low[0] * [1, -1, 1], low[0], high[0], high[0] * [1, -1, 1]])[None]
        rear = np.stack([low[-1], low[-1] * [1, -1, 1], high[-1] * [1, -1, 1], high[-1]])[None]
        group = np.concatenate([near, far, front, rear])
        faces.append(group)
        tints.append(np.broadcast_to(np.array([s0, s0, s1, s1])[None, :, None] * paint, group.shape))
    rim = np.column_stack([x, -(half - 0.07), shoulder])
    lid = np.stack([rim[:-1], rim[1:], rim[1:] * [1, -1, 1], rim[:-1] * [1, -1, 1]], axis=1)
    return join([quads(np.concatenate(faces), np.concatenate(tints)), quads(lid, paint * 1.05)])


def _cabin(paint: FloatArray, tall: float, back: float) -> list[Quads]:
    """Roof, pillars and glass."""
    low = np.array([[-0.95, -0.80, 0.90], [back, -0.80, 0.92], [back, 0.80, 0.92], [-0.95, 0.80, 0.90]])
    high = np.array(
        [[-0.25, -0.60, tall], [back - 0.45, -0.60, tall - 0.02], [back - 0.45, 0.60, tall - 0.02], [-0.25, 0.60, tall]]
    )
    walls = np.stack([np.stack([low[n], low[m], high[m], high[n]]) for n, m in ((0, 1), (1, 2), (2, 3), (3, 0))])
    middle = walls.mean(axis=1, keepdims=True)
    out = np.cross(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    panes = middle + np.array([0.90, 0.90, 0.80])[None, None] * (walls - middle) + 0.02 * out[:, None]
    tint = np.stack([GLASS, GLASS, SKY, SKY])[None]
    door = boxes([0.42, -0.90, 0.55], [0.44, -0.86, 0.88], paint * 0.3, faces=("front",))
    pillar = boxes([0.40, -0.79, 0.92], [0.48, -0.70, 0.93], paint, faces=("front",))
    return [quads(walls, paint * 0.85), quads(panes, tint), quads(high[None], paint * 1.1), door, pillar]


def _lights() -> list[Quads]:
    """Headlights, tail lights, and dark bumpers."""
    black = [0.03, 0.03, 0.03]
    parts = [
        boxes([-2.14, -0.66, 0.25], [-2.0, 0.66, 0.42], black, faces=("left", "front", "back")),
        boxes([2.0, -0.68, 0.25], [2.15, 0.68, 0.42], black, faces=("right", "front", "back")),
    ]
    for y in (-0.66, 0.40):
        parts.append(boxes([-2.14, y, 0.50], [-2.0, y + 0.26, 0.61], [0.75, 0.75, 0.72], faces=("left",)))
        parts.append(boxes([2.0, y, 0.56], [2.15, y + 0.26, 0.70], [0.40, 0.02, 0.02], faces=("right",)))
    return parts


def _wheel() -> Mesh:
    """A wheel in the plane y = 0 that is seen from −y."""
    rubber, rim = [0.018] * 3, [0.42] * 3
    shades = np.array([rim, rim, rubber, rubber, rubber])
    disc = tube([[0.0, 0.02], [0.19, 0.02], [0.21, 0.0], [0.32, 0.01], [0.32, 0.18]], shades, sides=9)
    return smooth_mesh(
        _laid(disc.vertices), _laid(disc.normals), disc.colours.astype(np.float64), disc.triangles.astype(np.int64)
    )


def _laid(vectors: Float32) -> FloatArray:
    """Turned about x so that −z becomes −y."""
    x, y, z = vectors.astype(np.float64).T
    return np.column_stack([x, z, -y])


Parts = list[Mesh | Quads]
"""What a thing is made of; only quadrilaterals need be divided."""
IRON = np.array([0.035, 0.04, 0.042])
OAK = np.array([0.42, 0.27, 0.15])


def lamp(rng: np.random.Generator) -> Parts:
    """A lamp post about 4 m high with a lantern."""
    shades = np.array([[0.6], [1.0], [1.2], [1.0], [1.0], [1.0]])
    top = rng.uniform(3.4, 3.9)
    profile = [[0.13, 0.0], [0.13, 0.25], [0.075, 0.35], [0.07, 0.9], [0.045, 1.0], [0.04, top]]
    glass = tube([[0.06, top], [0.10, top + 0.03], [0.17, top + 0.45]], [0.75, 0.73, 0.62], sides=6)
    cap = tube([[0.21, top + 0.44], [0.20, top + 0.48], [0.06, top + 0.62], [0.02, top + 0.75]], IRON, sides=6)
    return [tube(profile, IRON * shades, sides=7), glass, cap]


def bench(rng: np.random.Generator) -> Parts:
    """A wooden bench on iron legs, 1.8 m long."""
    half, tint = 0.9, OAK * rng.uniform(0.8, 1.15)
    rows = np.array([[-0.25, 0.42], [-0.09, 0.42], [0.07, 0.42], [0.28, 0.58], [0.32, 0.76]])
    deep = np.array([[0.14, 0.035]] * 3 + [[0.03, 0.14]] * 2)
    low, high = np.insert(rows, 0, -half, axis=1), np.insert(rows + deep, 0, half, axis=1)
    wood: list[tuple[slice, tuple[str, ...]]] = [
        (slice(0, 1), ("left", "right", "front", "top")),
        (slice(1, 3), ("left", "right", "top")),
        (slice(3, 5), ("left", "right", "front", "back", "top")),
    ]
    slats = [boxes(low[n], high[n], tint, faces=f, layer=Layer.WOOD, tile=TILE[Layer.WOOD]) for n, f in wood]
    bars = np.array(
        [[-0.24, 0.0, -0.19, 0.42], [-0.26, 0.37, 0.30, 0.415], [0.26, 0.0, 0.31, 0.6], [0.34, 0.55, 0.37, 0.9]]
    )
    legs = [
        boxes(
            np.insert(bars[:, :2], 0, x, axis=1), np.insert(bars[:, 2:], 0, x + 0.05, axis=1), IRON,
            faces=("left", "right", "front", "back"),
        )
        for x in (-0.75, 0.70)
    ]  # fmt: skip
    return [*slats, *legs]


def litter_bin(rng: np.random.Generator) -> Parts:
    """A litter bin."""
    colour = np.array([[0.05, 0.10, 0.07], [0.16, 0.16, 0.17], [0.30, 0.16, 0.08]][rng.integers(3)])
    body = tube([[0.20, 0.0], [0.22, 0.06], [0.24, 0.80]], colour * np.array([[0.5], [0.9], [1.0]]), sides=10)
    rim = tube([[0.26, 0.78], [0.26, 0.86], [0.20, 0.90], [0.19, 0.78], [0.0, 0.74]], colour * 0.6, sides=10)
    return [body, rim]


def bollard(rng: np.random.Generator) -> Parts:
    """An iron bollard."""
    shades = rng.uniform(1.1, 1.5) * np.array([[0.6], [1.0], [1.0], [1.6], [1.0], [1.2]])
    profile = [[0.10, 0.0], [0.085, 0.08], [0.065, 0.70], [0.085, 0.74], [0.06, 0.84], [0.0, 0.90]]
    return [tube(profile, IRON * shades, sides=7)]


def planter(rng: np.random.Generator) -> Parts:
    """A stone tub with a bush."""
    stone = np.array([0.42, 0.40, 0.37]) * rng.uniform(0.8, 1.1)
    shades = np.array([[0.5], [0.8], [1.0], [1.0], [0.8], [0.3]])
    profile = [[0.36, 0.0], [0.40, 0.08], [0.49, 0.50], [0.53, 0.60], [0.45, 0.60], [0.0, 0.52]]
    tub = tube(profile, stone * shades, sides=11, layer=Layer.ASHLAR, tile=TILE[Layer.ASHLAR])
    return [tub, place(bush(rng.uniform(0.42, 0.55), rng), 0.0, 0.0, 0.0, 0.52)]


def column(rng: np.random.Generator) -> Parts:
    """A round column with posters."""
    greys = np.array([0.30, 0.42, 0.5, 0.42])[:, None] * np.array([1.0, 0.96, 0.88])
    body = tube([[0.68, 0.0], [0.68, 0.35], [0.62, 0.38], [0.62, 2.75]], greys, sides=18)
    roof = [[0.62, 2.72], [0.80, 2.76], [0.80, 2.90], [0.45, 3.15], [0.12, 3.45], [0.0, 3.6]]
    return [body, tube(roof, [0.07, 0.13, 0.10], sides=18), *_posters(0.65, rng)]


def _posters(radius: float, rng: np.random.Generator) -> list[Quads]:
    """Two rows of posters bent around a column of some radius, m."""
    edges = np.linspace(0.0, 1.0, 5)
    sheets = []
    for number, angle in enumerate(np.arange(0.0, 2.0 * np.pi, np.pi / 4.0)):
        for low in (0.5, 1.6):
            turn = (np.stack([edges[:-1], edges[1:], edges[1:], edges[:-1]], axis=1) - 0.5) * rng.uniform(0.6, 0.74)
            tall = np.broadcast_to([low, low, low + 1.0, low + 1.0], turn.shape) + rng.uniform(0.0, 0.12)
            corners = np.stack([radius * np.sin(turn), -radius * np.cos(turn), tall], axis=-1)
            first, _, third, _ = quarter((number + int(low)) % 4)
            ends = np.stack([edges[:-1], edges[1:], edges[1:], edges[:-1]], axis=1)
            uv = first + np.stack([ends, np.broadcast_to([0, 0, 1, 1], ends.shape)], axis=-1) * (third - first)
            sheets.append(quads(turned(corners, float(angle)), rng.uniform(0.6, 1.0, 3), layer=Layer.SIGNS, uv=uv))
    return sheets


def sign(rng: np.random.Generator) -> Parts:
    """A round street sign on a pole."""
    tint = np.array([[0.03, 0.10, 0.40], [0.5, 0.03, 0.03]][rng.integers(2)])
    angle = np.linspace(0.0, 2.0 * np.pi, 13)
    rim = np.column_stack([0.3 * np.cos(angle), np.full(13, -0.05), 2.3 + 0.3 * np.sin(angle)])
    core = np.broadcast_to([0.0, -0.05, 2.3], (12, 3))
    disc = np.stack([core, rim[:-1], rim[1:], core], axis=1)
    face = core[:, None] + 0.8 * (disc - core[:, None]) - [0.0, 0.02, 0.0]
    back = disc[:, [0, 2, 1, 3]] + [0.0, 0.02, 0.0]
    pole = tube([[0.03, 0.0], [0.03, 2.6]], [0.35, 0.35, 0.36], sides=6)
    return [pole, quads(disc, [0.8, 0.8, 0.8]), quads(face, tint), quads(back, [0.4, 0.4, 0.4])]


def cafe(rng: np.random.Generator) -> Parts:
    """A round table, two chairs and a parasol."""
    top = tube([[0.38, 0.70], [0.38, 0.73], [0.0, 0.735]], [0.55, 0.53, 0.50], sides=10)
    leg = tube([[0.22, 0.0], [0.03, 0.06], [0.03, 0.70]], IRON, sides=6)
    pole = tube([[0.025, 0.73], [0.025, 2.55]], [0.5, 0.48, 0.44], sides=5)
    cloth = one_of(STREET["parasols"], rng)
    shade = tube([[1.05, 2.08], [1.05, 2.14], [0.0, 2.58]], cloth, sides=14)
    under = tube([[1.04, 2.11], [0.0, 2.55]], cloth * 0.4, sides=14)
    angles = rng.uniform(0.0, np.pi) + np.array([0.0, rng.uniform(2.4, 3.8)])
    chairs: Parts = [place(_chair(), 0.75 * np.sin(a), -0.75 * np.cos(a), float(a)) for a in angles]
    return [top, leg, pole, shade, _inside_out(under), *chairs]


def _chair() -> Mesh:
    """A chair that faces +y."""
    wood = boxes([[-0.20, -0.2, 0.44], [-0.20, -0.22, 0.62]], [[0.20, 0.2, 0.47], [0.20, -0.19, 0.86]], OAK)
    legs = [[x, y] for x in (-0.20, 0.17) for y in (-0.22, 0.17)]
    low = np.insert(np.array(legs), 2, 0.0, axis=1)
    high = low + np.array([0.03, 0.03, 0.0]) + np.array([[0, 0, 0.86], [0, 0, 0.44]] * 2)
    return join([wood, boxes(low, high, IRON, faces=("left", "right", "front", "back"))]).mesh()


def _inside_out(mesh: Mesh) -> Mesh:
    return Mesh(
        vertices=mesh.vertices, normals=-mesh.normals, colours=mesh.colours, uv=mesh.uv, layers=mesh.layers,
        triangles=mesh.triangles[:, ::-1],
    )  # fmt: skip


THINGS: dict[str, Callable[[np.random.Generator], Parts]] = {
    "lamp": lamp,
    "bench": bench,
    "bin": litter_bin,
    "bollard": bollard,
    "planter": planter,
    "column": column,
    "sign": sign,
    "cafe": cafe,
    "car": car,
}
"""What can be placed."""
