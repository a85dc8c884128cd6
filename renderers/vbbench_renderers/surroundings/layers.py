"""The textures, computed without image files. Texture coordinates (u, v) show row S v, column S u of a layer."""

from collections.abc import Callable
from enum import IntEnum
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.geometry import FloatArray
from vbbench_renderers.surroundings.panes import SIZE, Masonry, cloudy, doors, masonry, shops, signs, srgb, windows


class Layer(IntEnum):
    """The number of each texture layer."""

    PAVING = 0
    SETTS = 1
    ASPHALT = 2
    GRASS = 3
    BRICK = 4
    PLASTER = 5
    ASHLAR = 6
    ROOF = 7
    LEAVES = 8
    WOOD = 9
    WINDOWS = 10
    WINDOWS_OLD = 11
    SHOPS = 12
    DOORS = 13
    SIGNS = 14
    DISTANT = 15


TILE = {
    Layer.PAVING: 2.4,
    Layer.SETTS: 1.6,
    Layer.ASPHALT: 3.0,
    Layer.GRASS: 3.0,
    Layer.BRICK: 2.0,
    Layer.PLASTER: 4.0,
    Layer.ASHLAR: 2.4,
    Layer.ROOF: 2.4,
    Layer.LEAVES: 1.2,
    Layer.WOOD: 0.8,
}
"""Width of a layer in the world, m; the others hold pictures, four to a layer."""


@lru_cache(maxsize=1)
def textures() -> NDArray[np.uint8]:
    """[L, S, S, 3] all layers; they are the same for every seed."""
    painters: dict[Layer, Callable[[np.random.Generator], FloatArray]] = {
        Layer.PAVING: _paving,
        Layer.SETTS: _setts,
        Layer.ASPHALT: _asphalt,
        Layer.GRASS: _grass,
        Layer.BRICK: _brick,
        Layer.PLASTER: _plaster,
        Layer.ASHLAR: _ashlar,
        Layer.ROOF: _roof,
        Layer.LEAVES: _leaves,
        Layer.WOOD: _wood,
        Layer.WINDOWS: lambda rng: windows(rng, old=False),
        Layer.WINDOWS_OLD: lambda rng: windows(rng, old=True),
        Layer.SHOPS: shops,
        Layer.DOORS: doors,
        Layer.SIGNS: signs,
        Layer.DISTANT: _distant,
    }
    layers = [srgb(painters[layer](np.random.default_rng([2111, layer]))) for layer in Layer]
    stack = np.stack(layers)
    stack.flags.writeable = False
    return stack


def _tinted(shade: FloatArray, colour: ArrayLike) -> FloatArray:
    return np.asarray(shade[..., None] * np.asarray(colour))


def _laid(stones: Masonry, joint: float, depth: float, bevel: float) -> FloatArray:
    """Shade of masonry: joints `joint` px wide as dark as `depth`, edges lit from above over `bevel` px."""
    inside = np.clip((stones.edge - joint) / 1.5, 0.0, 1.0)
    rim = np.exp(-np.maximum(stones.edge - joint, 0.0) / bevel) * (stones.height - 0.5)
    return np.asarray((depth + (1.0 - depth) * inside) * (1.0 + 0.25 * rim))


def _paving(rng: np.random.Generator) -> FloatArray:
    stones = masonry(8, 4, warp=0.6 * cloudy(rng, 1.2))
    tone = 1.0 + 0.07 * stones.tones(rng) + 0.05 * cloudy(rng, 1.0) + 0.07 * cloudy(rng, 0.2)
    warm = 0.010 * stones.tones(rng)
    colour = np.stack([0.43 + warm, np.full_like(warm, 0.405), 0.365 - warm], axis=2)
    return np.asarray(colour * (tone * _laid(stones, 1.6, 0.42, 5.0))[..., None])


def _setts(rng: np.random.Generator) -> FloatArray:
    stones = masonry(16, 12, warp=3.0 * cloudy(rng, 1.5, 6.0))
    dome = np.clip(stones.edge / 14.0, 0.0, 1.0) ** 0.5
    tone = (1.0 + 0.13 * stones.tones(rng) + 0.08 * cloudy(rng, 0.3)) * (0.35 + 0.65 * dome)
    warm = 0.015 * stones.tones(rng)
    colour = np.stack([0.345 + warm, np.full_like(warm, 0.32), 0.295 - warm], axis=2)
    return np.asarray(colour * (tone * _laid(stones, 1.5, 0.4, 6.0))[..., None])


def _asphalt(rng: np.random.Generator) -> FloatArray:
    return _tinted(1.0 + 0.16 * cloudy(rng, 0.1) + 0.06 * cloudy(rng, 1.3), [0.125, 0.125, 0.13])


def _grass(rng: np.random.Generator) -> FloatArray:
    blades = np.roll(cloudy(rng, 0.4), 3, axis=0) + cloudy(rng, 0.2, 1.5)
    tone = np.clip(1.0 + 0.25 * blades + 0.12 * cloudy(rng, 1.2), 0.25, 2.0)
    dry = np.clip(0.5 + 0.5 * cloudy(rng, 1.4), 0.0, 1.0)[..., None]
    colour = dry * np.array([0.15, 0.22, 0.055]) + (1.0 - dry) * np.array([0.085, 0.19, 0.045])
    return np.asarray(tone[..., None] * colour)


def _brick(rng: np.random.Generator) -> FloatArray:
    bricks = masonry(26, 8, warp=0.5 * cloudy(rng, 1.0))
    tone = 1.0 + 0.12 * bricks.tones(rng) + 0.10 * cloudy(rng, 0.3) + 0.05 * cloudy(rng, 1.4)
    inside = np.clip((bricks.edge - 1.2) / 1.2, 0.0, 1.0)[..., None]
    pale = 0.06 * bricks.tones(rng)[..., None]
    clay = np.array([0.80, 0.74, 0.70]) * (tone[..., None]) + pale * np.array([0.2, 0.9, 1.0])
    return np.asarray(inside * clay + (1.0 - inside) * 0.62 * (1.0 + 0.06 * cloudy(rng, 0.3))[..., None])


def _plaster(rng: np.random.Generator) -> FloatArray:
    streaks = np.repeat(cloudy(rng, 1.2).mean(axis=0, keepdims=True), SIZE, axis=0)
    return _tinted(0.86 + 0.02 * cloudy(rng, 0.4) + 0.025 * cloudy(rng, 1.5) + 0.1 * streaks, [1.0, 1.0, 1.0])


def _ashlar(rng: np.random.Generator) -> FloatArray:
    stones = masonry(6, 3, warp=0.3 * cloudy(rng, 1.0))
    tone = 0.84 + 0.035 * stones.tones(rng) + 0.03 * cloudy(rng, 0.3) + 0.03 * cloudy(rng, 1.4)
    return _tinted(tone * _laid(stones, 2.0, 0.5, 5.0), [1.0, 0.985, 0.96])


def _roof(rng: np.random.Generator) -> FloatArray:
    tiles = masonry(10, 10, warp=0.6 * cloudy(rng, 1.2))
    tone = (1.0 + 0.10 * tiles.tones(rng) + 0.08 * cloudy(rng, 0.6)) * (1.1 - 0.5 * tiles.height**3)
    return _tinted(0.8 * tone * (0.45 + 0.55 * np.clip(tiles.edge / 3.0, 0.0, 1.0)), [1.0, 0.96, 0.93])


def _leaves(rng: np.random.Generator) -> FloatArray:
    cells = cloudy(rng, 0.6, 4.0)
    light = np.clip(0.62 + 0.34 * (np.roll(cells, 3, axis=0) - 0.6 * cells) + 0.12 * cloudy(rng, 0.2), 0.12, 1.3)
    warm = 0.12 * cloudy(rng, 0.8)[..., None] * np.array([1.0, 0.4, 0.0])
    return np.asarray(light[..., None] * (0.75 + warm))


def _wood(rng: np.random.Generator) -> FloatArray:
    grain = cloudy(rng, 0.9)
    grain = np.mean([np.roll(grain, 9 * shift, axis=1) for shift in range(10)], axis=0)
    return _tinted(0.7 + 0.25 * grain + 0.04 * cloudy(rng, 0.2), [1.0, 0.92, 0.82])


def _distant(rng: np.random.Generator) -> FloatArray:
    """Four by four windows in a wall: a distant façade."""
    picture = _tinted(0.84 + 0.03 * cloudy(rng, 1.0), [1.0, 1.0, 1.0])
    for cell in range(16):
        top, left = 128 * (cell // 4), 128 * (cell % 4)
        picture[top + 36 : top + 98, left + 38 : left + 90] *= 1.12
        tone = 0.10 + 0.10 * rng.random() ** 2
        picture[top + 41 : top + 98, left + 42 : left + 86] = np.array([0.8, 0.95, 1.1]) * tone
        picture[top + 41 : top + 98, left + 62 : left + 66] = 0.72
        picture[top + 74 : top + 77, left + 42 : left + 86] = 0.72
        picture[top + 34 : top + 38, left + 34 : left + 94] *= 0.75
    return picture
