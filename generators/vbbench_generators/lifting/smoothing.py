"""Smooths tracks on the ground; how strongly, follows from how much of their jitter is noise of the boxes.

Second differences of positions at time steps τ have variance 6·r + ⅔·q·τ³: r is the noise of a mean over a block, q the
density of a white-noise acceleration (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking
and Navigation, 2001, section 6.2). One grows with τ and the other does not, so several τ separate them. Blocks are as
long as the gaps between an annotator's key boxes often are, so that interpolated noise counts as what it is.

The smoother is a Kalman filter and the one of Rauch, Tung and Striebel, one coordinate at a time. State: position and
velocity under that acceleration. Frames without a box are predicted over.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.scene import Scene
from vbbench_generators import _core
from vbbench_generators.lifting.camera import GroundCamera
from vbbench_generators.lifting.heads import Heads

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
    dt : seconds per frame.
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


def smooth(value: FloatArray, variance: FloatArray, row: IntArray, starts: IntArray, q: float, dt: float) -> FloatArray:
    """Smoothed coordinate [M], gaps filled.

    Parameters
    ----------
    value, variance : [N] measured coordinate and variance of its noise, in m and m².
    row : [N] where in the result each stands; ascending.
    starts : [K + 1] where each piece of a track begins in the result; the last is M. Pieces begin and end with a box.
    q : density of acceleration in m²/s³.
    dt : seconds per frame.
    """
    known, noise = np.full(starts[-1], np.nan), np.zeros(starts[-1])
    known[row], noise[row] = value, variance
    return _core.smooth(known, noise, starts, q, dt)


_LEAST_STD = 1e-6
_LEAST_ACCELERATION = 1e-6


@dataclass(frozen=True, kw_only=True)
class Smoothed:
    """Tracks as a scene, and the root mean square of what the smoother took off them, in m and in px."""

    scene: Scene
    residual_m: float
    residual_px: float


def smooth_tracks(heads: Heads, camera: GroundCamera, head_size: float, name: str) -> Smoothed:
    """Put heads on the ground and smooth their tracks, with gaps filled; the strength is estimated from the tracks."""
    ground, jacobian = camera.to_ground(heads.x, heads.nu), camera.jacobian(heads.x, heads.nu)
    size = head_size / np.hypot(jacobian[:, 0, 0], jacobian[:, 1, 0])
    scale = size[:, None] * np.hypot(jacobian[:, :, 0], jacobian[:, :, 1])
    starts, row = _rows(heads)
    smoothed = np.empty((int(starts[-1]), 2))
    for axis in range(2):
        strength = estimate_strength(ground[:, axis], scale[:, axis], heads.frame, heads.track, dt=heads.dt)
        variance = (strength.noise * scale[:, axis]) ** 2 / heads.dt + _LEAST_STD**2
        density = max(strength.acceleration, _LEAST_ACCELERATION)
        smoothed[:, axis] = smooth(ground[:, axis], variance, row, starts, density, heads.dt)
    off = ground - smoothed[row]
    moved = np.linalg.solve(jacobian, off[:, :, None])[:, :, 0]
    return Smoothed(
        scene=_scene(heads, smoothed, starts, name),
        residual_m=float(np.sqrt(np.mean((off**2).sum(axis=1)))),
        residual_px=float(np.sqrt(np.mean((moved**2).sum(axis=1)))),
    )


def _rows(heads: Heads) -> tuple[IntArray, IntArray]:
    """Where each track begins [K + 1] in a table with a row a frame from its first to its last, and each head's row."""
    first = np.flatnonzero(np.r_[True, heads.track[1:] != heads.track[:-1]])
    last = np.r_[first[1:], len(heads.track)] - 1
    spans = heads.frame[last] - heads.frame[first] + 1
    starts = np.r_[0, np.cumsum(spans)]
    row = heads.frame + np.repeat(starts[:-1] - heads.frame[first], last - first + 1)
    return starts, row


def _scene(heads: Heads, smoothed: FloatArray, starts: IntArray, name: str) -> Scene:
    people, first = np.unique(heads.track, return_index=True)
    spans = np.diff(starts)
    column = np.repeat(np.arange(len(people)), spans)
    frame = np.arange(len(smoothed)) - np.repeat(starts[:-1] - heads.frame[first], spans)
    positions = np.full((int(frame.max()) + 1, len(people), 2), np.nan)
    positions[frame, column] = smoothed
    return Scene(name=name, dt=heads.dt, people=people, positions=positions, heights=np.full(len(people), np.nan))
