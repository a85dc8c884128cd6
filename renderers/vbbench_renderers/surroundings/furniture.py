"""Street furniture, each in its own frame: the front faces −y and the foot is at z = 0."""

from collections.abc import Callable

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.surroundings.cars import car
from vbbench_renderers.surroundings.layers import TILE, Layer
from vbbench_renderers.surroundings.panes import quarter
from vbbench_renderers.surroundings.shapes import Quads, boxes, join, place, quads, tube, turned
from vbbench_renderers.surroundings.trees import bush

Parts = list[Mesh | Quads]
"""What a thing is made of; only quadrilaterals need be divided."""
IRON = np.array([0.035, 0.04, 0.042])
OAK = np.array([0.42, 0.27, 0.15])
CLOTHS = [(0.62, 0.56, 0.45), (0.45, 0.09, 0.07), (0.10, 0.22, 0.16), (0.62, 0.42, 0.14)]


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
    cloth = np.array(CLOTHS[rng.integers(len(CLOTHS))])
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
FEET: dict[str, FloatArray] = {
    "lamp": np.array([0.3, 0.3]),
    "bench": np.array([1.1, 0.5]),
    "bin": np.array([0.4, 0.4]),
    "bollard": np.array([0.2, 0.2]),
    "planter": np.array([0.65, 0.65]),
    "column": np.array([0.95, 0.95]),
    "cafe": np.array([1.2, 1.0]),
    "car": np.array([2.5, 1.2]),
    "tree": np.array([0.75, 0.75]),
}
"""Half axes of the dark spot on the ground under a thing, m."""
