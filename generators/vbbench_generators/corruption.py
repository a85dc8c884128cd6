"""Tiers: how exact boxes are corrupted."""

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.camera import Camera

PIXEL_STD = {"ideal": 0.0, "noisy": 1.0}
"""Standard deviation in px of a box's column, top and bottom, by tier."""

SHORTEST_BOX = 1.0
"""No box gets shorter than this, in px, by noise."""


def add_pixel_noise(boxes: FloatArray, camera: Camera, pixel_std: float, rng: np.random.Generator) -> FloatArray:
    """Gaussian noise of ``pixel_std`` px on the column, top and bottom of boxes [T, K, 3] (u, v, l) in px."""
    column, top, bottom = pixel_std * rng.standard_normal((3, *boxes.shape[:-1]))
    u = camera.wrap_column(boxes[..., 0] + column)
    v = boxes[..., 1] + 0.5 * (top + bottom)
    length = np.maximum(boxes[..., 2] + bottom - top, SHORTEST_BOX)
    return np.stack([u, v, length], axis=-1)
