"""Boxes as people draw them: whole bodies, cut off at the picture's borders, off by a share of their height.

With l the box's height, a person's own errors and those that change from frame to frame add up on the lower edge and
the centre column; the upper edge is nearly exact, since a head is what a box begins with.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_generators.tiers.field.recipe import AnnotatorModel
from vbbench_generators.tiers.noise import wandering


def drawn(boxes: FloatArray, dt: float, model: AnnotatorModel, rng: np.random.Generator) -> FloatArray:
    """Boxes [T, K, 3] (u, v, l) in px with the errors of whoever drew them; ``dt`` s a frame."""
    shape, length = boxes.shape[:2], boxes[..., 2]
    column_bias, bottom_bias = rng.standard_normal((2, shape[1]))
    column = model.column_person_std * column_bias + model.column_std * wandering(shape, model.column_time, dt, rng)
    bottom = model.bottom_person_std * bottom_bias + model.bottom_std * wandering(shape, model.bottom_time, dt, rng)
    top = model.top_std * rng.standard_normal(shape)
    u = boxes[..., 0] + column * length
    v = boxes[..., 1] + 0.5 * (top + bottom) * length
    return np.stack([u, v, length * (1.0 + bottom - top)], axis=-1)
