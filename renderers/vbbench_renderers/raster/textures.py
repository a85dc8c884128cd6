"""Texture layers, pre-filtered at successively halved sizes, and how they are read."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import IntArray
from vbbench.kernels import kernel
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


@kernel
def read_texture(textures: Textures, layer: int, u: float, v: float, spread: float) -> tuple[float, float, float]:
    """The linear colour of a layer at (u, v), bilinear; row 0 of a layer is at v = 0.

    ``spread`` is what a pixel covers, in texture widths; the size is taken whose texels come nearest to it.
    """
    level, texels = 0, spread * textures.size[0]
    while texels > 1.5 and level < len(textures.size) - 1:
        level, texels = level + 1, 0.5 * texels
    size = textures.size[level]
    x, y = (u - math.floor(u)) * size - 0.5, (v - math.floor(v)) * size - 0.5
    left, top = math.floor(x), math.floor(y)
    fx, fy = x - left, y - top
    right, bottom = (left + 1 if left + 1 < size else 0), (top + 1 if top + 1 < size else 0)
    left, top = (left if left >= 0 else size - 1), (top if top >= 0 else size - 1)
    base = textures.first[level] + layer * size * size
    a, b, c, d = (
        base + top * size + left,
        base + top * size + right,
        base + bottom * size + left,
        base + bottom * size + right,
    )
    wa, wb, wc, wd = (1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy
    bytes_, linear = textures.texels, textures.linear
    red = wa * linear[bytes_[a, 0]] + wb * linear[bytes_[b, 0]] + wc * linear[bytes_[c, 0]] + wd * linear[bytes_[d, 0]]
    green = (
        wa * linear[bytes_[a, 1]] + wb * linear[bytes_[b, 1]] + wc * linear[bytes_[c, 1]] + wd * linear[bytes_[d, 1]]
    )
    blue = wa * linear[bytes_[a, 2]] + wb * linear[bytes_[b, 2]] + wc * linear[bytes_[c, 2]] + wd * linear[bytes_[d, 2]]
    return red, green, blue
