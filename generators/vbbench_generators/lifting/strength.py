"""How much of a track's wobble is the boxes' noise, and how much is walking.

Second differences of positions at time steps τ have variance 6·r + ⅔·q·τ³: r is the noise of a mean over a block, q the
density of a white-noise acceleration (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking
and Navigation, 2001, section 6.2). One grows with τ and the other does not, so several τ tell them apart. Blocks are as
long as the gaps between an annotator's key boxes often are, so that interpolated noise counts as what it is.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray

BLOCK = 0.4
_LAGS = (1, 2, 3, 4)
_BANDS = 3
_LEAST = 20
_MEDIAN_OF_CHI2 = 0.4549


@dataclass(frozen=True, kw_only=True)
class Strength:
    """One coordinate's noise and motion.

    Parameters
    ----------
    noise : spectral density of the noise, as a standard deviation over one second, in units of the boxes' scale.
    acceleration : spectral density of acceleration, squared units of the coordinate / s³.
    """

    noise: float
    acceleration: float


def estimate_strength(value: FloatArray, scale: FloatArray, frame: IntArray, track: IntArray, *, dt: float) -> Strength:
    """Noise and motion along one coordinate.

    Parameters
    ----------
    value : [N] the coordinate, by track, then by frame.
    scale : [N] what one head's size of noise in the picture is there.
    frame, track : [N].
    dt : seconds a frame.
    """
    from scipy.optimize import nnls

    mean, level, block, owner, seconds = _blocks(value, scale, frame, track, dt)
    rows, seen = [], []
    for lag in _LAGS:
        second, size = _second_differences(mean, level, block, owner, lag)
        for part in np.array_split(np.argsort(size, kind="stable"), _BANDS):
            if len(part) >= _LEAST:
                rows.append([6.0 * float(np.mean(size[part] ** 2)) / seconds, (lag * seconds) ** 3 / 1.5])
                seen.append(float(np.median(second[part] ** 2)) / _MEDIAN_OF_CHI2)
    if not rows:
        return Strength(noise=0.0, acceleration=0.0)
    weight = 1.0 / np.maximum(np.array(seen), 1e-12)
    solution, _ = nnls(np.array(rows) * weight[:, None], np.array(seen) * weight)
    return Strength(noise=float(np.sqrt(solution[0])), acceleration=float(solution[1]))


def _blocks(
    value: FloatArray, scale: FloatArray, frame: IntArray, track: IntArray, dt: float
) -> tuple[FloatArray, FloatArray, IntArray, IntArray, float]:
    """Means of coordinate and scale over whole blocks, each block's number and owner, and its length in s."""
    length = max(1, round(BLOCK / dt))
    opening = np.r_[True, track[1:] != track[:-1]]
    number = np.cumsum(opening) - 1
    part = (frame - frame[opening][number]) // length
    starts = np.flatnonzero(np.r_[True, (part[1:] != part[:-1]) | opening[1:]])
    count = np.diff(np.r_[starts, len(value)])
    whole = count == length
    mean, level = (np.add.reduceat(values, starts) / count for values in (value, scale))
    return mean[whole], level[whole], part[starts][whole], number[starts][whole], length * dt


def _second_differences(
    mean: FloatArray, level: FloatArray, block: IntArray, owner: IntArray, lag: int
) -> tuple[FloatArray, FloatArray]:
    """Second differences over ``lag`` blocks and the scale in their middle."""
    before, middle, after = slice(None, -2 * lag or None), slice(lag, -lag or None), slice(2 * lag, None)
    close = (owner[after] == owner[before]) & (block[after] - block[before] == 2 * lag)
    second = mean[after] - 2.0 * mean[middle] + mean[before]
    return second[close], level[middle][close]
