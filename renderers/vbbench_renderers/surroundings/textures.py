"""The textures, computed without image files. Texture coordinates (u, v) show row S v, column S u of a layer.

Pictures of windows, shop fronts, doors and signs stand four to a layer, drawn upside down: row 0 is the foot.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.geometry import FloatArray, IntArray

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


def srgb(linear: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Linear RGB in 0 … 1 as 8-bit sRGB (IEC 61966-2-1, approximated by the power 1/2.2)."""
    return np.asarray(255.0 * np.clip(linear, 0.0, 1.0) ** (1.0 / 2.2) + 0.5).astype(np.uint8)


HALF = SIZE // 2
"""Width and height of a picture, px."""


def quarter(number: int) -> FloatArray:
    """[4, 2] texture coordinates of a picture's corners from the lower left, counter-clockwise; number 0 … 3."""
    low = 0.5 * np.array([number % 2, number // 2]) + 2.0 / SIZE
    span = 0.5 - 4.0 / SIZE
    return np.asarray(low + span * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))


def windows(rng: np.random.Generator, *, old: bool) -> FloatArray:
    """Windows 1.2 m wide and 1.6 m high, white or dark frames, with reflections, curtains, blinds and lamps."""
    pictures = []
    for number in range(4):
        pane = _glass(rng, 0.6)
        if number in (0, 3):
            _curtains(pane, drawn=0.30 if number else 0.18)
        if number == 1:
            blind = _blind(rng)
            low = int(rng.integers(100, 170))
            pane[low:] = blind[low:]
        if number == 2:
            pane += np.array([0.22, 0.15, 0.06]) * np.linspace(0.4, 1.0, HALF)[:, None, None]
        frame = [0.75, 0.74, 0.70] if not old else [0.70, 0.67, 0.60]
        _bars(pane, frame, columns=2, rows=[0.66] if not old else [0.36, 0.68])
        pictures.append(pane)
    return _sheet(pictures)


def shops(rng: np.random.Generator) -> FloatArray:
    """Shop windows of about 2.5 m by 2.5 m with goods in them."""
    pictures = []
    for number in range(4):
        pane = 0.55 * _glass(rng, 0.35)
        pane[:, :] += np.array([[0.10, 0.08, 0.055], [0.05, 0.055, 0.06]][number % 2])
        _goods(pane, rng, number)
        pane += 0.05 * np.clip(_slanted(), 0.0, 1.0)[..., None]
        pane[:14] = np.array([0.06, 0.06, 0.065])
        frame = [[0.05, 0.05, 0.055], [0.25, 0.16, 0.09], [0.5, 0.5, 0.48], [0.05, 0.09, 0.07]][number]
        _bars(pane, frame, columns=1 + number % 2, rows=[0.80])
        pictures.append(pane)
    return _sheet(pictures)


def doors(rng: np.random.Generator) -> FloatArray:
    """A panelled door, a glazed one, a boarded one and a shop's."""
    pictures = []
    for number in range(4):
        stripes = np.repeat(cloudy(rng, 0.6)[:1, :HALF], HALF, axis=0)
        grain = 1.0 + 0.10 * stripes + 0.03 * cloudy(rng, 0.2)[:HALF, :HALF]
        door = grain[..., None] * np.array([[0.7] * 3, [0.65] * 3, [0.62, 0.60, 0.56], [0.3] * 3][number])
        if number == 0:
            for low, high in ((20, 90), (104, 190), (200, 236)):
                for left, right in ((30, 118), (138, 226)):
                    _panel(door, low, high, left, right)
        elif number == 2:
            door[:, ::32] *= 0.5
            door[:, 1::32] *= 0.75
        else:
            low = 70 if number == 1 else 24
            door[low:232, 40:216] = _glass(rng, 0.7)[low:232, 40:216]
            _panel(door, low - 6, 238, 34, 222)
        door[110:126, 232:240] = np.array([0.6, 0.55, 0.4])
        door[:, :8] *= 0.6
        door[:, -8:] *= 0.6
        door[-10:] *= 0.6
        pictures.append(door)
    return _sheet(pictures)


def signs(rng: np.random.Generator) -> FloatArray:
    """Shop signs with lettering that cannot be read, and posters."""
    pictures = []
    for number in range(4):
        ground = np.array([[0.04, 0.07, 0.16], [0.33, 0.04, 0.05], [0.03, 0.12, 0.08], [0.75, 0.68, 0.52]][number])
        ink = np.array([[0.85, 0.80, 0.62], [0.9, 0.88, 0.85], [0.9, 0.75, 0.3], [0.10, 0.07, 0.06]][number])
        board = np.ones((HALF, HALF, 3)) * ground
        column = 24
        while column < HALF - 40:
            wide = int(rng.integers(9, 20))
            if rng.random() > 0.16:
                _letter(board, rng, column, wide, ink)
            column += wide + 7
        board[8:13, 8:-8] = board[-13:-8, 8:-8] = ink * 0.7 + ground * 0.3
        pictures.append(board)
    return _sheet(pictures)


def _sheet(pictures: list[FloatArray]) -> FloatArray:
    return np.concatenate([np.concatenate(pictures[:2], axis=1), np.concatenate(pictures[2:], axis=1)], axis=0)


def _glass(rng: np.random.Generator, strength: float) -> FloatArray:
    """Dark glass: the houses opposite below, the sky above, slightly wavy."""
    height = np.linspace(0.0, 1.0, HALF)[:, None]
    roofs = 0.35 + 0.1 * np.repeat(rng.random(8), HALF // 8)[None, :] + 0.02 * cloudy(rng, 1.4)[:HALF, :HALF]
    sky = 1.0 / (1.0 + np.exp(-(height - roofs) * 40.0))
    reflected = sky[..., None] * np.array([0.30, 0.40, 0.52]) * (0.7 + 0.5 * height[..., None])
    dull = (1.0 - sky[..., None]) * np.array([0.09, 0.085, 0.08])
    return np.asarray(0.02 + strength * (reflected + dull))


def _slanted() -> FloatArray:
    row, column = np.mgrid[:HALF, :HALF]
    return np.asarray(np.cos((row * 0.6 + column) * 2.0 * np.pi / 190.0) - 0.3)


def _curtains(pane: FloatArray, drawn: float) -> None:
    column = np.arange(HALF)
    folds = 0.42 + 0.09 * np.sin(column * 0.32 + 2.0 * np.sin(column * 0.06))
    cloth = folds[None, :, None] * np.array([1.0, 0.97, 0.90])
    side = np.minimum(column, HALF - 1 - column)[None, :] < HALF * drawn * (
        1.0 - 0.25 * np.linspace(1, 0, HALF)[:, None]
    )
    pane[side] = np.broadcast_to(0.75 * cloth, pane.shape)[side] + 0.25 * pane[side]


def _blind(rng: np.random.Generator) -> FloatArray:
    slats = 0.40 + 0.10 * rng.random() + 0.07 * np.sin(np.arange(HALF) * 2.0 * np.pi / 12.0)
    return np.asarray(np.ones((HALF, HALF, 3)) * slats[:, None, None])


def _bars(pane: FloatArray, colour: ArrayLike, *, columns: int, rows: list[float]) -> None:
    """Frame, mullions and transoms with a lit upper and a dark lower edge."""
    tint = np.asarray(colour)
    edges = [(0, 16), (HALF - 16, HALF)]
    upright = [(int(HALF * part / columns) - 7, int(HALF * part / columns) + 7) for part in range(1, columns)]
    for low, high in [(int(HALF * row) - 6, int(HALF * row) + 6) for row in rows]:
        pane[low - 6 : low] *= 0.55
        pane[low:high] = tint
    for low, high in [*edges, *upright]:
        pane[:, high : high + 5] *= 0.6
        pane[:, low:high] = tint
        pane[:, high - 2 : high] *= 0.7
    pane[HALF - 28 : HALF - 14] *= 0.5
    for low, high in edges:
        pane[low:high] = tint


def _panel(door: FloatArray, low: int, high: int, left: int, right: int) -> None:
    door[low:high, left : left + 4] *= 0.6
    door[high - 4 : high, left:right] *= 0.55
    door[low : low + 4, left:right] *= 1.25
    door[low:high, right - 4 : right] *= 1.2


def _goods(pane: FloatArray, rng: np.random.Generator, number: int) -> None:
    for shelf in (30, 95, 150):
        pane[shelf - 5 : shelf] = np.array([0.20, 0.16, 0.12])
        column = int(rng.integers(14, 30))
        while column < HALF - 44:
            wide, tall = int(rng.integers(8, 34)), int(rng.integers(16, 50))
            if rng.random() > 0.25:
                tint = rng.uniform(0.05, 0.45) * rng.uniform(0.3, 1.0, 3)
                roundness = np.cos(np.linspace(-1.2, 1.2, wide))[None, :, None]
                pane[shelf : shelf + tall, column : column + wide] = tint * (0.45 + 0.55 * roundness)
            column += wide + int(rng.integers(3, 12))
    pane[196:204, 30:-30] += 0.25 * (number != 1)


def _letter(board: FloatArray, rng: np.random.Generator, column: int, wide: int, ink: FloatArray) -> None:
    low, high = 84, 172
    stroke = 5
    board[low:high, column : column + stroke] = ink
    if rng.random() < 0.6:
        board[low:high, column + wide - stroke : column + wide] = ink
    for row in (low, (low + high) // 2, high - 12):
        if rng.random() < 0.6:
            board[row : row + 12, column : column + wide] = ink


Layer = IntEnum(
    "Layer",
    "PAVING SETTS ASPHALT GRASS BRICK PLASTER ASHLAR ROOF LEAVES WOOD WINDOWS WINDOWS_OLD SHOPS DOORS SIGNS DISTANT",
    start=0,
)
"""The number of each texture layer."""
TILE = dict(zip(Layer, (2.4, 1.6, 3.0, 3.0, 2.0, 4.0, 2.4, 2.4, 1.2, 0.8), strict=False))
"""Width of a layer in the world, m; the others hold pictures, four to a layer."""


@lru_cache(maxsize=1)
def textures() -> NDArray[np.uint8]:
    """[L, S, S, 3] all layers; they are the same for every seed."""
    stones, plants = (_brick, _plaster, _ashlar, _roof), (_leaves, _wood)
    openings = (partial(windows, old=False), partial(windows, old=True), shops, doors, signs, _distant)
    painters: tuple[Callable[[np.random.Generator], FloatArray], ...]
    painters = (_paving, _setts, _asphalt, _grass, *stones, *plants, *openings)
    streams = (np.random.default_rng([2111, layer]) for layer in Layer)
    stack = np.stack([srgb(paint(rng)) for paint, rng in zip(painters, streams, strict=True)])
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
