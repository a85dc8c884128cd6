"""Walking speeds as evidence for the stretch of depths, and the smoother of tracks.

A segment is a head's displacement within a window of about two seconds. Its log speed is y = μ + h(φ) + b + e: b is a
deviation of the person, e one of the segment, and h a true dependence on the direction φ, a Gaussian process of
harmonics. Walking speeds are isotropic up to h; a wrong stretch of depths adds a term in φ to y. The likelihood is that
of speeds given directions: how many people walk which way does not matter. If all walk one way, h can explain a wrong
stretch, and the crowd has little information.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scene import Scene
from vbbench_generators import _core
from vbbench_generators.lifting.camera import GroundCamera
from vbbench_generators.lifting.heads import Heads, parts_of_tracks

BLOCK = 0.4
_LAGS = (1, 2, 3, 4)
_BANDS = 3
_LEAST = 20
_MEDIAN_OF_CHI2 = 0.4549


class Strength(NamedTuple):
    """Measurement and process noise of one coordinate.

    Attributes
    ----------
    noise : standard deviation of the measurement noise averaged over one second, in units of ``scale``.
    acceleration : spectral density of acceleration, squared units of the coordinate / s³.
    """

    noise: float
    acceleration: float


def estimate_strength(value: FloatArray, scale: FloatArray, frame: IntArray, track: IntArray, *, dt: float) -> Strength:
    """Estimate measurement and process noise of one coordinate.

    Parameters
    ----------
    value : [N] the coordinate, by track, then by frame.
    scale : [N] change of the coordinate for noise of one head size in the picture.
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
    (noise, acceleration), _ = nnls(np.array(rows) * weight[:, None], np.array(seen) * weight)
    return Strength(noise=float(np.sqrt(noise)), acceleration=float(acceleration))


def _blocks(
    value: FloatArray, scale: FloatArray, frame: IntArray, track: IntArray, dt: float
) -> tuple[FloatArray, FloatArray, IntArray, IntArray, float]:
    """Means of coordinate and scale over blocks of frames, number and track of each block, and its length in s."""
    length = max(1, round(BLOCK / dt))
    number, part, starts, count = parts_of_tracks(frame, track, length)
    whole = count == length
    mean, level = (np.add.reduceat(values, starts) / count for values in (value, scale))
    return mean[whole], level[whole], part[starts][whole], number[starts][whole], length * dt


def _second_differences(
    mean: FloatArray, level: FloatArray, block: IntArray, owner: IntArray, lag: int
) -> tuple[FloatArray, FloatArray]:
    """Second differences over ``lag`` blocks, and the scale in their middle."""
    before, middle, after = slice(None, -2 * lag or None), slice(lag, -lag or None), slice(2 * lag, None)
    close = (owner[after] == owner[before]) & (block[after] - block[before] == 2 * lag)
    second = mean[after] - 2.0 * mean[middle] + mean[before]
    return second[close], level[middle][close]


_LEAST_STD = 1e-6
_LEAST_ACCELERATION = 1e-6


@dataclass(frozen=True, kw_only=True)
class Smoothed:
    """Smoothed tracks as a scene, and the root mean square of the smoother's corrections in m and in px."""

    scene: Scene
    residual_m: float
    residual_px: float


def smooth_tracks(heads: Heads, camera: GroundCamera, head_size: float, name: str) -> Smoothed:
    """Lift heads to the ground and smooth their tracks, with gaps filled; noise is estimated from the tracks."""
    ground, jacobian = camera.to_ground(heads.x, heads.nu), camera.jacobian(heads.x, heads.nu)
    size = head_size / np.hypot(jacobian[:, 0, 0], jacobian[:, 1, 0])
    scale = size[:, None] * np.hypot(jacobian[:, :, 0], jacobian[:, :, 1])
    first = np.flatnonzero(np.r_[True, heads.track[1:] != heads.track[:-1]])
    spans = heads.frame[np.r_[first[1:], len(heads.track)] - 1] - heads.frame[first] + 1
    starts = np.r_[0, np.cumsum(spans)]  # of tracks in a table with a row for each frame of a track
    row = heads.frame + np.repeat(starts[:-1] - heads.frame[first], np.diff(np.r_[first, len(heads.track)]))
    smoothed = np.empty((int(starts[-1]), 2))
    for axis in range(2):
        noise, acceleration = estimate_strength(ground[:, axis], scale[:, axis], heads.frame, heads.track, dt=heads.dt)
        known, variance = np.full(len(smoothed), np.nan), np.zeros(len(smoothed))
        known[row], variance[row] = ground[:, axis], (noise * scale[:, axis]) ** 2 / heads.dt + _LEAST_STD**2
        smoothed[:, axis] = _core.smooth(known, variance, starts, max(acceleration, _LEAST_ACCELERATION), heads.dt)
    frame = np.arange(len(smoothed)) - np.repeat(starts[:-1] - heads.frame[first], spans)
    people, unknown = heads.track[first], np.full(len(first), np.nan)
    positions = np.full((int(frame.max()) + 1, len(people), 2), np.nan)
    positions[frame, np.repeat(np.arange(len(people)), spans)] = smoothed
    off = ground - smoothed[row]
    moved = np.linalg.solve(jacobian, off[:, :, None])[:, :, 0]
    return Smoothed(
        scene=Scene(name=name, dt=heads.dt, people=people, positions=positions, heights=unknown),
        residual_m=float(np.sqrt(np.mean((off**2).sum(axis=1)))),
        residual_px=float(np.sqrt(np.mean((moved**2).sum(axis=1)))),
    )


HARMONICS = 6
OPPOSITE = 3.0
"""How much freer the first harmonic is than the others: streams that face each other may differ in pace."""

_MEAN_STD = 10.0


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Velocities of segments in canonical coordinates (P, Q) = (X, Y/g).

    Parameters
    ----------
    person : [S] number of the person, ascending.
    way : [S, 2] along P and Q, per second.
    noise : [S, 2] standard deviations of ``way``.
    """

    person: IntArray
    way: FloatArray
    noise: FloatArray

    def take(self, chosen: BoolArray | IntArray) -> "Steps":
        """The steps ``chosen`` by index or mask."""
        return Steps(person=self.person[chosen], way=self.way[chosen], noise=self.noise[chosen])

    def speed(self, g: float) -> FloatArray:
        """Speeds [S] in m/s where the stretch is ``g``."""
        return np.hypot(self.way[:, 0], g * self.way[:, 1])


@dataclass(frozen=True, kw_only=True)
class Pace:
    """Standard deviations of log speed: between people, within one person, and h's harmonics."""

    between: float
    within: float
    direction: float


def log_likelihood(steps: Steps, g: float, pace: Pace, about: float) -> float:
    """Log likelihood of the stretch ``g``: density of the log speeds given the directions.

    Directions and weights of segments are those at the stretch ``about``, an estimate. Otherwise the determinants would
    depend on ``g`` and favour a stretch that turns all segments into one direction, where h does not matter.
    """
    log_speed = _observed(steps, g)[0]
    _, phi, variance = _observed(steps, about)
    prior = np.full(2 * HARMONICS + 1, 1.0 / pace.direction**2)
    prior[0], prior[1:3] = 1.0 / _MEAN_STD**2, prior[1:3] / OPPOSITE**2
    weight = 1.0 / (pace.within**2 + variance)
    normal, right, square, log_det = _core.whiten(log_speed, phi, weight, steps.person, pace.between**2)
    factor = np.linalg.cholesky(normal + np.diag(prior))
    half = np.linalg.solve(factor, right)
    log_det += 2.0 * float(np.log(np.diag(factor)).sum()) - float(np.log(prior).sum())
    return -0.5 * (square - float(half @ half) + log_det)


def estimate_pace(steps: Steps, g: float, direction: float) -> Pace:
    """Estimate deviations of log speed between and within people at the stretch ``g``, by an analysis of variance."""
    log_speed, _, variance = _observed(steps, g)
    _, number, count = np.unique(steps.person, return_inverse=True, return_counts=True)
    mean = np.bincount(number, log_speed) / count
    freedom = max(len(number) - len(count), 1)
    within = float(((log_speed - mean[number]) ** 2).sum()) / freedom
    spread = float(np.var(mean, ddof=1)) - within * float(np.mean(1.0 / count))
    moment = max(within - float(variance.mean()), 1e-6)
    return Pace(between=float(np.sqrt(max(spread, 1e-6))), within=float(np.sqrt(moment)), direction=direction)


def _observed(steps: Steps, g: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log speeds [S] without their bias by noise, directions [S] in rad, and variances [S] by noise.

    To second order, noise across a displacement raises its log length, and noise along it lowers that:
    E ln|v + e| = ln|v| + (σ⊥² − σ∥²)/(2|v|²).
    """
    right, forward = steps.way[:, 0], g * steps.way[:, 1]
    square = right**2 + forward**2
    cos2, sin2 = right**2 / square, forward**2 / square
    noise = steps.noise**2 * np.array([1.0, g * g])
    along = (noise[:, 0] * cos2 + noise[:, 1] * sin2) / square
    across = (noise[:, 0] * sin2 + noise[:, 1] * cos2) / square
    return 0.5 * np.log(square) - 0.5 * (across - along), np.arctan2(forward, right), along


_LEAST_SHARE = 0.8


@dataclass(frozen=True, kw_only=True)
class Segments:
    """Displacements of heads within windows of tracks, by track.

    Parameters
    ----------
    person : [S] number of the track, ascending.
    begin, end : [S, 2] mean (x, ν) in px over a window's first and last third, in px from the picture's centre.
    duration : [S] seconds between the two.
    """

    person: IntArray
    begin: FloatArray
    end: FloatArray
    duration: FloatArray

    def __len__(self) -> int:
        return len(self.person)


def cut_segments(heads: Heads, window: float) -> Segments:
    """Cut tracks into consecutive windows of ``window`` s; windows with too few boxes are removed."""
    third = max(1, round(window / heads.dt / 3.0))
    number, part, starts, count = parts_of_tracks(heads.frame, heads.track, third)
    key = number * (int(part.max()) + 3) + part
    values = (heads.x, heads.nu, heads.frame * heads.dt)
    mean = np.stack([np.add.reduceat(value, starts) / count for value in values], axis=1)
    opens = np.flatnonzero(part[starts] % 3 == 0)
    opens = opens[opens + 2 < len(starts)]
    full = np.minimum(count[opens], count[opens + 2]) >= _LEAST_SHARE * third
    opens = opens[full & (key[starts[opens + 2]] == key[starts[opens]] + 2)]
    return Segments(
        person=number[starts[opens]],
        begin=mean[opens, :2],
        end=mean[opens + 2, :2],
        duration=mean[opens + 2, 2] - mean[opens, 2],
    )


_SLOWEST = 0.3
"""People slower than this share of the upper quartile are standing."""


def walking_speed(heads: Heads, camera: GroundCamera, window: float) -> float | None:
    """Median speed of walkers in m/s, from windows of ``window`` s; ``None`` if there are no such windows."""
    segments = cut_segments(heads, window)
    if not len(segments):
        return None
    way = camera.to_ground(*segments.end.T) - camera.to_ground(*segments.begin.T)
    speed = np.hypot(way[:, 0], way[:, 1]) / segments.duration
    median = float(np.median(speed[speed >= _SLOWEST * np.quantile(speed, 0.75)]))
    return median if median > 0.0 else None
