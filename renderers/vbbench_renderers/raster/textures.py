"""Texture layers, pre-filtered at successively halved sizes, and how they are read."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import IntArray
from vbbench_renderers.mesh import Float32


class Textures(NamedTuple):
    """L layers of S x S texels at every size S, S/2 … 1.

    Parameters
    ----------
    texels : [sum of L S²] colours of 3 bytes, sRGB; size after size, layer after layer, row after row.
    first : [levels] where each size begins.
    size : [levels] S of each.
    linear : [256] linear value of an sRGB byte.
    """

    texels: NDArray[np.uint8]
    first: IntArray
    size: IntArray
    linear: Float32


def srgb_to_linear(values: Float32) -> Float32:
    """Linear values of sRGB values in 0 … 1 (IEC 61966-2-1)."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(np.float32)


def linear_to_srgb(values: Float32) -> Float32:
    """The inverse of `srgb_to_linear`."""
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * np.maximum(values, 0.0) ** (1 / 2.4) - 0.055).astype(
        np.float32
    )


def build_textures(layers: NDArray[np.uint8]) -> Textures:
    """Layers [L, S, S, 3] with their smaller sizes, each a mean of 2 x 2 texels in linear light."""
    linear = srgb_to_linear(np.arange(256, dtype=np.float32) / 255.0)
    levels = [layers]
    while levels[-1].shape[1] > 1:
        half = levels[-1].shape[1] // 2
        fine = linear[levels[-1][:, : 2 * half, : 2 * half]]
        mean = fine.reshape(len(layers), half, 2, half, 2, 3).mean(axis=(2, 4), dtype=np.float32)
        levels.append(np.round(255.0 * linear_to_srgb(mean)).astype(np.uint8))
    counts = [level.size // 3 for level in levels]
    first = np.cumsum([0, *counts[:-1]])
    size = np.array([level.shape[1] for level in levels])
    return Textures(np.concatenate([level.reshape(-1, 3) for level in levels]), first, size, linear)
