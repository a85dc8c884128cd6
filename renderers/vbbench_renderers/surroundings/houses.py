"""Houses: real relief near the walking area, pictures of windows far away."""

import numpy as np

from vbbench_renderers.mesh import Mesh
from vbbench_renderers.surroundings.layers import TILE, Layer
from vbbench_renderers.surroundings.layout import Plot
from vbbench_renderers.surroundings.quads import Quads, boxes, join, quads
from vbbench_renderers.surroundings.shapes import place

SPREAD = 0.095
"""Widest part of a house over its distance, rad: so narrow that it may be projected on a cylinder by its corners."""


def house_mesh(plot: Plot, rng: np.random.Generator) -> Mesh:
    """The house of a plot in the site's frame."""
    step = max(SPREAD * plot.distance, 0.3)
    return place(distant_house(plot, rng).divide(step).mesh(), plot.u, plot.v, plot.yaw)


def distant_house(plot: Plot, rng: np.random.Generator) -> Quads:
    """A box with painted windows and a roof."""
    tone = rng.uniform(0.45, 0.8) * np.array([1.0, rng.uniform(0.82, 0.98), rng.uniform(0.65, 0.9)])
    size = np.array([plot.width, plot.depth, plot.height])
    walls = boxes([0, 0, 0], size, tone, layer=Layer.DISTANT, tile=12.0, faces=("left", "right", "front"), foot=0.8)
    roof = quads(
        [[[-0.3, -0.3, size[2]], [size[0] + 0.3, -0.3, size[2]], [size[0] + 0.3, 5.0, size[2] + 3.0],
          [-0.3, 5.0, size[2] + 3.0]]],
        [0.5, 0.3, 0.24], layer=Layer.ROOF, tile=TILE[Layer.ROOF],
    )  # fmt: skip
    return join([walls, roof])
