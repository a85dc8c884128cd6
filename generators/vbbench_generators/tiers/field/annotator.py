"""Boxes as people draw them: whole bodies, cut off at the picture's borders, off by a share of their height.

With l the box's height, a person's own errors and those that change from frame to frame add up on the lower edge and
the centre column; the upper edge is nearly exact, since a head is what a box begins with.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench_generators.tiers.field.recipe import AnnotatorModel
from vbbench_generators.tiers.noise import wandering


def drawn(boxes: FloatArray, who: IntArray, dt: float, model: AnnotatorModel, rng: np.random.Generator) -> FloatArray:
    """Boxes [N, 3] (u, v, l) in px with the errors of whoever drew them.

    Parameters
    ----------
    boxes : [T, K, 3] exact.
    who : [N] of which of them, counted through [T, K]; everybody has errors, so that these do not depend on it.
    dt : seconds per frame.
    """
    shape, person = boxes.shape[:2], who % max(boxes.shape[1], 1)
    column_bias, bottom_bias = rng.standard_normal((2, shape[1]))[:, person]
    column_walk = wandering(shape, model.column_time, dt, rng).take(who)
    bottom_walk = wandering(shape, model.bottom_time, dt, rng).take(who)
    column = model.column_person_std * column_bias + model.column_std * column_walk
    bottom = model.bottom_person_std * bottom_bias + model.bottom_std * bottom_walk
    top = model.top_std * rng.standard_normal(shape).take(who)
    u, v, length = boxes.reshape(-1, 3).take(who, axis=0).T
    return np.stack([u + column * length, v + 0.5 * (top + bottom) * length, length * (1.0 + bottom - top)], axis=-1)
