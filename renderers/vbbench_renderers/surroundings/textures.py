"""The textures, computed without image files. Texture coordinates (u, v) show row S v, column S u of a layer.

Pictures of windows and of a door stand four to a layer, drawn upside down: row 0 is the foot.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.geometry import FloatArray, IntArray
from vbbench_renderers.meshes import linear_to_srgb

SIZE = 512
"""Width and height of a texture layer, px."""


def cloudy(rng: np.random.Generator, slope: float, finest: float = 1.0) -> FloatArray:
    """[S, S] periodic Gaussian noise, mean 0 and deviation 1, with amplitude 1/f^slope; `finest` in px."""
    spectrum = np.fft.rfft2(rng.standard_normal((SIZE, SIZE), dtype=np.float32))
    frequency = np.hypot(np.fft.fftfreq(SIZE)[:, None], np.fft.rfftfreq(SIZE)) + 0.5 / SIZE
    filtered = spectrum * frequency**-slope * np.exp(-((frequency * finest) ** 2))
    filtered[0, 0] = 0.0
    noise = np.fft.irfft2(filtered, s=(SIZE, SIZE))
    return np.asarray(noise / noise.std())


@dataclass(frozen=True, kw_only=True)
class Masonry:
    """Stones in courses: the number of the stone [S, S] and the distance to its edge [S, S], px."""

    stone: IntArray
    edge: FloatArray
    height: FloatArray

    def tones(self, rng: np.random.Generator) -> FloatArray:
        """[S, S] one standard normal number per stone."""
        return rng.standard_normal(int(self.stone.max()) + 1)[self.stone]


def masonry(courses: int, stones: int, *, warp: FloatArray | float = 0.0) -> Masonry:
    """Courses of stones, every second one shifted by half a stone; `warp` moves the joints, px."""
    row, column = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5, indexing="ij")
    tall, wide = SIZE / courses, SIZE / stones
    course, in_course = np.divmod(np.mod(row + warp, SIZE), tall)
    number, in_stone = np.divmod(np.mod(column + np.roll(warp, 77) + 0.5 * wide * (course % 2), SIZE), wide)
    edge = np.minimum(np.minimum(in_course, tall - in_course), np.minimum(in_stone, wide - in_stone))
    return Masonry(stone=(course * stones + number).astype(np.int64), edge=edge, height=in_course / tall)


HALF = SIZE // 2
"""Width and height of a picture, px."""


DOOR = 3
"""The number of the door among the pictures of openings; those before it are windows."""


def quarters(number: IntArray) -> FloatArray:
    """[N, 4, 2] texture coordinates of pictures' corners from the lower left, counter-clockwise; numbers [N] 0 … 3."""
    low = 0.5 * np.stack([number % 2, number // 2], axis=-1) + 2.0 / SIZE
    corners = (0.5 - 4.0 / SIZE) * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return np.asarray(low[:, None] + corners)


def _openings(rng: np.random.Generator) -> FloatArray:
    """Two windows with pale frames, one with a lamp behind it, and a panelled door."""
    pictures = []
    for number in range(DOOR):
        pane = _glass(rng, 0.6)
        if number == 2:
            pane += np.array([0.22, 0.15, 0.06]) * np.linspace(0.4, 1.0, HALF)[:, None, None]
        _bars(pane, [0.75, 0.74, 0.70] if number else [0.70, 0.67, 0.60], rows=[0.66] if number else [0.36, 0.68])
        pictures.append(pane)
    pictures.append(_door(rng))
    return np.concatenate([np.concatenate(pictures[:2], axis=1), np.concatenate(pictures[2:], axis=1)], axis=0)


def _door(rng: np.random.Generator) -> FloatArray:
    """A door with six panels."""
    stripes = np.repeat(cloudy(rng, 0.6)[:1, :HALF], HALF, axis=0)
    door = 0.7 * (1.0 + 0.10 * stripes + 0.03 * cloudy(rng, 0.2)[:HALF, :HALF])[..., None] * np.ones(3)
    for low, high in ((20, 90), (104, 190), (200, 236)):
        for left, right in ((30, 118), (138, 226)):
            door[low:high, left : left + 4] *= 0.6
            door[high - 4 : high, left:right] *= 0.55
            door[low : low + 4, left:right] *= 1.25
            door[low:high, right - 4 : right] *= 1.2
    door[110:126, 232:240] = np.array([0.6, 0.55, 0.4])
    door[:, :8] *= 0.6
    door[:, -8:] *= 0.6
    door[-10:] *= 0.6
    return door


def _glass(rng: np.random.Generator, strength: float) -> FloatArray:
    """Dark glass: the houses opposite below, the sky above, slightly wavy."""
    height = np.linspace(0.0, 1.0, HALF)[:, None]
    roofs = 0.35 + 0.1 * np.repeat(rng.random(8), HALF // 8)[None, :] + 0.02 * cloudy(rng, 1.4)[:HALF, :HALF]
    sky = 1.0 / (1.0 + np.exp(-(height - roofs) * 40.0))
    reflected = sky[..., None] * np.array([0.30, 0.40, 0.52]) * (0.7 + 0.5 * height[..., None])
    dull = (1.0 - sky[..., None]) * np.array([0.09, 0.085, 0.08])
    return np.asarray(0.02 + strength * (reflected + dull))


def _bars(pane: FloatArray, colour: ArrayLike, *, rows: list[float]) -> None:
    """A frame, a mullion and transoms, with a lit upper and a dark lower edge."""
    middle = HALF // 2
    for low, high in [(int(HALF * row) - 6, int(HALF * row) + 6) for row in rows]:
        pane[low - 6 : low] *= 0.55
        pane[low:high] = colour
    for low, high in ((0, 16), (HALF - 16, HALF), (middle - 7, middle + 7)):
        pane[:, high : high + 5] *= 0.6
        pane[:, low:high] = colour
        pane[:, high - 2 : high] *= 0.7
    pane[HALF - 28 : HALF - 14] *= 0.5
    for low, high in ((0, 16), (HALF - 16, HALF)):
        pane[low:high] = colour


Layer = IntEnum("Layer", "PAVING ASPHALT GRASS BRICK PLASTER ASHLAR ROOF LEAVES OPENINGS", start=0)
"""The number of each texture layer."""
TILE = dict(zip(Layer, (2.4, 3.0, 3.0, 2.0, 4.0, 2.4, 2.4, 1.2), strict=False))
"""Width of a layer in the world, m; the last one holds pictures, four to a layer."""


@lru_cache(maxsize=1)
def textures() -> NDArray[np.uint8]:
    """[L, S, S, 3] all layers; they are the same for every seed."""
    painters = (_paving, _asphalt, _grass, _brick, _plaster, _ashlar, _roof, _leaves, _openings)
    streams = (np.random.default_rng([2111, layer]) for layer in Layer)
    linear = np.stack([paint(rng) for paint, rng in zip(painters, streams, strict=True)]).clip(0.0, 1.0)
    stack = np.round(255.0 * linear_to_srgb(linear.astype(np.float32))).astype(np.uint8)
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
