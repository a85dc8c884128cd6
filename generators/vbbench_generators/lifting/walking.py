"""How people walk: segments of it, how well their speeds agree with a stretch of the ground, and how fast they are.

A segment of walking is where a head is at the beginning and at the end of a window of about two seconds. Its log speed
is y = μ + h(φ) + b + e: b is the person's own pace, e that of the moment, and h what truly depends on the direction φ,
a Gaussian process of harmonics. Walking is as fast in one direction as in another; with a wrong stretch of the depth, y
gains a term in φ. What is computed is the likelihood of the speeds given the directions, so nothing is assumed of how
many people walk which way; and as h can imitate the wrong stretch where all walk one way, such a crowd decides little.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators import _core
from vbbench_generators.lifting.camera import GroundCamera
from vbbench_generators.lifting.heads import Heads

HARMONICS = 6
OPPOSITE = 3.0
"""How much freer the first harmonic is than the others: streams that face each other may differ in pace."""

_MEAN_STD = 10.0


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Displacements in canonical coordinates: (P, Q) = (X, Y/g).

    Parameters
    ----------
    person : [S] ascending numbers.
    way : [S, 2] along P and Q, divided by the seconds.
    noise : [S, 2] standard deviations of ``way``.
    """

    person: IntArray
    way: FloatArray
    noise: FloatArray

    def take(self, chosen: BoolArray | IntArray) -> "Steps":
        """The steps ``chosen`` by index or mask."""
        return Steps(person=self.person[chosen], way=self.way[chosen], noise=self.noise[chosen])

    def speed(self, g: float) -> FloatArray:
        """[S] in m/s where the stretch is ``g``."""
        return np.hypot(self.way[:, 0], g * self.way[:, 1])


@dataclass(frozen=True, kw_only=True)
class Pace:
    """Standard deviations of log speed: between people, within one person, and h's harmonics."""

    between: float
    within: float
    direction: float


def log_likelihood(steps: Steps, g: float, pace: Pace, about: float) -> float:
    """Logarithm of the density of the log speeds given the directions, where the stretch is ``g``.

    Directions and the weights of segments are those at the stretch ``about``, an estimate. Otherwise the determinants
    would depend on ``g`` and favour a stretch that turns everyone into one direction, where h does not matter.
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
    """Between- and within-person spread of log speed at the stretch ``g``, from the analysis of variance."""
    log_speed, _, variance = _observed(steps, g)
    _, number, count = np.unique(steps.person, return_inverse=True, return_counts=True)
    mean = np.bincount(number, log_speed) / count
    freedom = max(len(number) - len(count), 1)
    within = float(((log_speed - mean[number]) ** 2).sum()) / freedom
    spread = float(np.var(mean, ddof=1)) - within * float(np.mean(1.0 / count))
    moment = max(within - float(variance.mean()), 1e-6)
    return Pace(between=float(np.sqrt(max(spread, 1e-6))), within=float(np.sqrt(moment)), direction=direction)


def _observed(steps: Steps, g: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log speeds [S] freed of what noise adds to them on average, directions [S], variances [S] due to noise.

    To second order, noise across the way lengthens it and noise along it takes as much off its logarithm:
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
    """Windows of tracks, by track.

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
    """Cut tracks into windows of ``window`` s that follow one another; those with too few boxes are removed."""
    frame, track = heads.frame, heads.track
    third = max(1, round(window / heads.dt / 3.0))
    opening = np.r_[True, track[1:] != track[:-1]]
    number = np.cumsum(opening) - 1
    part = (frame - frame[opening][number]) // third
    key = number * (int(part.max()) + 3) + part
    starts = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    count = np.diff(np.r_[starts, len(key)])
    values = (heads.x, heads.nu, frame * heads.dt)
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
