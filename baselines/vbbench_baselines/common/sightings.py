"""Boxes as measurements on the ground: the viewing ray of a box, and how pixel noise moves it.

Every camera of `vbbench.camera` places a person of height h at z = h·ρ(u, v, l), linear in h: ρ, the ray, is the place
of a person one metre tall. To first order, noise in u and l and the height's variance s² give z the covariance

    N = (s² + h²·2σ²/l²)·ρρᵀ + h²σ²·ρ'ρ'ᵀ,   ρ' = ∂ρ/∂u,

σ being the standard deviation in px of u and of box top and bottom (so √2σ of l).
"""

from typing import NamedTuple

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray

SMALLEST_BOX = 1.0
"""Boxes lower than this (px) are taken to be this high: noise must not turn a person's distance negative."""


FARTHEST_PIXEL = 1e6
"""In px; no picture is that large."""


class Sightings(NamedTuple):
    """The boxes of one frame as rays; NaN = not observed.

    Attributes
    ----------
    rays : [K, 2] (right, forward) place in m of a person one metre tall.
    sideways : [K, 2] in m, how far one standard deviation of u moves that place.
    stretch : [K] relative standard deviation of the distance from the noise of the box height.
    """

    rays: FloatArray
    sideways: FloatArray
    stretch: FloatArray


def usable(observations: FloatArray) -> FloatArray:
    """The boxes [..., K, 3] in px, those that are not finite or beyond any picture as if they were not there."""
    sound = np.all(np.abs(observations) <= FARTHEST_PIXEL, axis=-1, keepdims=True)
    return np.where(sound, observations, np.nan)


def sight(camera: Camera, observations: FloatArray, pixel_std: float) -> Sightings:
    """Rays of the boxes [..., K, 3] in px, with noise of ``pixel_std`` px on u and on box top and bottom."""
    boxes = np.array((observations, observations))
    boxes[1, ..., 0] += 1.0
    np.maximum(boxes[..., 2], SMALLEST_BOX, out=boxes[..., 2])
    rays, shifted = camera.unproject(boxes, np.ones(()))
    return Sightings(rays, pixel_std * (shifted - rays), (np.sqrt(2.0) * pixel_std) / boxes[0, ..., 2])
