"""Noise and masonry that continue over the border of a texture."""

from dataclasses import dataclass

import numpy as np

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
        """[S, S] a standard normal number a stone."""
        return rng.standard_normal(int(self.stone.max()) + 1)[self.stone]


def masonry(courses: int, stones: int, *, shift: float = 0.5, warp: FloatArray | float = 0.0) -> Masonry:
    """Courses of stones, every second one shifted by a part of a stone; `warp` moves the joints, px."""
    row, column = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5, indexing="ij")
    tall, wide = SIZE / courses, SIZE / stones
    course, in_course = np.divmod(np.mod(row + warp, SIZE), tall)
    number, in_stone = np.divmod(np.mod(column + np.roll(warp, 77) + shift * wide * (course % 2), SIZE), wide)
    edge = np.minimum(np.minimum(in_course, tall - in_course), np.minimum(in_stone, wide - in_stone))
    return Masonry(stone=(course * stones + number).astype(np.int64), edge=edge, height=in_course / tall)


def srgb(linear: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Linear RGB in 0 … 1 as 8-bit sRGB (IEC 61966-2-1, approximated by the power 1/2.2)."""
    return np.asarray(255.0 * np.clip(linear, 0.0, 1.0) ** (1.0 / 2.2) + 0.5).astype(np.uint8)
