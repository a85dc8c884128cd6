"""The focal length, which head sizes do not determine, and with it the stretch g = f / cos θ of depths, by walking.

A segment is a head's displacement within a window of about two seconds. Its log speed is y = μ + h(φ) + b + e: b is a
deviation of the person, e one of the segment, and h a true dependence on the direction φ, a Gaussian process of
harmonics. Walking speeds are isotropic up to h; a wrong stretch of depths adds a term in φ to y. The likelihood is that
of speeds given directions: how many people walk which way does not matter. If all walk one way, h can explain a wrong
stretch, and the crowd has little information.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators import _core
from vbbench_generators.lifting.fitting import PlaneFit
from vbbench_generators.lifting.heads import HeadBoxes, Heads, LiftingSettings, Method, SizePlane, parts_of_tracks

BLOCK = 0.4
_LAGS = (1, 2, 3, 4)
_BANDS = 3
_LEAST = 20
_MEDIAN_OF_CHI2 = 0.4549


def estimate_noise(
    value: FloatArray, scale: FloatArray, frame: IntArray, track: IntArray, *, dt: float
) -> tuple[float, float]:
    """Estimate measurement and process noise of one coordinate.

    Parameters
    ----------
    value : [N] the coordinate, by track, then by frame.
    scale : [N] change of the coordinate for noise of one head size in the picture.
    frame, track : [N].
    dt : seconds per frame.

    Returns
    -------
    noise : standard deviation of the measurement noise averaged over one second, in units of ``scale``.
    acceleration : spectral density of acceleration, squared units of the coordinate / s³.
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
        return 0.0, 0.0
    weight = 1.0 / np.maximum(np.array(seen), 1e-12)
    (noise, acceleration), _ = nnls(np.array(rows) * weight[:, None], np.array(seen) * weight)
    return float(np.sqrt(noise)), float(acceleration)


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


LEAST_PEOPLE = 10
"""With fewer walkers, motion is not used."""

_GRID, _FINE, _REACH = 33, 2001, 4.5
_PLANES = 16
_ROUNDS, _CONVERGED = 12, 1e-3
_DRAWS = 40
_LEVELS = (np.arange(_DRAWS) + 0.5) / _DRAWS
_CLIP = 3.0
_WALKS = 0.3


@dataclass(frozen=True, kw_only=True)
class FocalLengths:
    """The posterior of the focal length.

    Parameters
    ----------
    focal : its median in px, for the fitted plane.
    planes, draws : [D] planes and focal lengths in px, drawn jointly.
    method : the evidence.
    walkers : number of people used as evidence.
    """

    focal: float
    planes: tuple[SizePlane, ...]
    draws: FloatArray
    method: Method
    walkers: int


def find_focal_length(fit: PlaneFit, heads: Heads, boxes: HeadBoxes, settings: LiftingSettings) -> FocalLengths:
    """Estimate the focal length by how people walk and the prior, or by the prior alone if too few walk."""
    return _by_motion(fit, heads, boxes.size[0], settings) or _by_prior(fit, boxes.size[0], settings)


def _by_prior(fit: PlaneFit, width: int, settings: LiftingSettings) -> FocalLengths:
    """The focal length by the prior of lenses alone."""
    from scipy.special import ndtri

    median = settings.focal_median * width
    draws = median * np.exp(settings.focal_spread * ndtri(_LEVELS))
    return _close(median, fit.resampled, [draws for _ in fit.resampled], "prior", 0)


def _by_motion(fit: PlaneFit, heads: Heads, width: int, settings: LiftingSettings) -> FocalLengths | None:
    """The focal length by the likelihood of walking speeds and the prior; ``None`` if too few people walk.

    The likelihood is averaged over planes from resampled tracks, which includes the horizon's uncertainty.
    """
    segments, head_size = cut_segments(heads, settings.window), settings.head_size
    place = (fit.plane, heads.x, heads.nu, head_size)
    value, scale = canonical(*place), noise_scale(*place)
    each = [estimate_noise(value[:, n], scale[:, n], heads.frame, heads.track, dt=heads.dt) for n in range(2)]
    noise = np.array([std for std, _ in each])
    prior_log = np.linspace(-_REACH, _REACH, _GRID) * settings.focal_spread
    focal = settings.focal_median * width * np.exp(prior_log)
    steps = walking_steps(fit.plane, segments, noise, head_size)
    chosen: BoolArray = np.ones(len(steps.person), np.bool_)
    best = float(focal[_GRID // 2])
    pace = Pace(between=0.3, within=0.1, direction=settings.direction_spread)
    for _ in range(_ROUNDS):
        chosen = walkers(steps, fit.plane.stretch(best))
        if len(np.unique(steps.person[chosen])) < LEAST_PEOPLE:
            return None
        walking = steps.take(chosen)
        pace = estimate_pace(walking, fit.plane.stretch(best), settings.direction_spread)
        before = best
        best = float(_quantiles(_posterior(fit.plane, walking, focal, pace, best), focal, np.array([0.5]))[0])
        if abs(best / before - 1.0) < _CONVERGED:
            break
    posteriors = []
    for plane in fit.resampled[:_PLANES]:
        walking = walking_steps(plane, segments, noise, head_size).take(chosen)
        posteriors.append(_posterior(plane, walking, focal, pace, best))
    draws = [_quantiles(one, focal, _LEVELS) for one in posteriors]
    people = len(np.unique(steps.person[chosen]))
    return _close(best, fit.resampled[:_PLANES], draws, "motion", people)


def walking_steps(plane: SizePlane, segments: Segments, noise: FloatArray, head_size: float) -> Steps:
    """Velocities of the segments in canonical coordinates P = D·x/ŝ, Q = D/ŝ; ``noise`` [2] is the σ of P and Q.

    D is ``head_size``. The mean over a third of a window, T/2 long, has the variance σ²/(T/2), T being the time
    between the two thirds.
    """
    ends = [canonical(plane, part[:, 0], part[:, 1], head_size) for part in (segments.begin, segments.end)]
    middle = (segments.begin + segments.end) / 2.0
    scale = noise_scale(plane, middle[:, 0], middle[:, 1], head_size)
    spread = 2.0 * noise * scale / segments.duration[:, None] ** 1.5
    return Steps(person=segments.person, way=(ends[1] - ends[0]) / segments.duration[:, None], noise=spread)


def canonical(plane: SizePlane, x: FloatArray, nu: FloatArray, head_size: float) -> FloatArray:
    """Canonical coordinates (P, Q) [N, 2] of points in px from the picture's centre."""
    across, _ = plane.levelled(x, nu)
    size = plane.at(x, nu)
    return head_size * np.stack([across, np.ones_like(across)], axis=1) / size[:, None]


def noise_scale(plane: SizePlane, x: FloatArray, nu: FloatArray, head_size: float) -> FloatArray:
    """[N, 2] standard deviations of (P, Q) (see `canonical`) for isotropic noise of one head size in the picture."""
    across, _ = plane.levelled(x, nu)
    size, slope = plane.at(x, nu), plane.slope
    moved = [np.hypot(1.0, slope * across / size), slope / size]
    return head_size * np.stack(moved, axis=1)


def walkers(steps: Steps, g: float) -> BoolArray:
    """Mask [S] of segments that are precise and have a usual walking speed, where the stretch is ``g``."""
    speed = steps.speed(g)
    noise = np.hypot(steps.noise[:, 0], g * steps.noise[:, 1])
    walks = (speed > _WALKS * np.quantile(speed, 0.75)) & (noise < 0.5 * speed) if len(speed) else np.zeros(0, np.bool_)
    if not walks.any():
        return walks
    log_speed = np.log(np.where(walks, speed, 1.0))
    middle = np.median(log_speed[walks])
    spread = np.median(np.abs(log_speed[walks] - middle)) / 0.6745
    kept: BoolArray = walks & (np.abs(log_speed - middle) <= _CLIP * max(float(spread), 1e-6))
    return kept


def _posterior(plane: SizePlane, steps: Steps, focal: FloatArray, pace: Pace, about: float) -> FloatArray:
    """Log posterior density [G] of ln f at the grid ``focal`` [G] in px; ``about`` is an estimate of f."""
    prior = -0.5 * np.linspace(-_REACH, _REACH, _GRID) ** 2
    near = plane.stretch(about)
    return prior + [log_likelihood(steps, plane.stretch(float(f)), pace, near) for f in focal]


def _quantiles(log_density: FloatArray, focal: FloatArray, levels: FloatArray) -> FloatArray:
    """Focal lengths at cumulative ``levels``; the density is interpolated between the grid's points."""
    from scipy.interpolate import CubicSpline

    log_focal = np.log(focal)
    fine = np.linspace(log_focal[0], log_focal[-1], _FINE)
    density = CubicSpline(log_focal, log_density - log_density.max())(fine)
    mass = np.cumsum(np.exp(density - density.max()))
    return np.exp(np.interp(levels, (mass - 0.5 * np.exp(density - density.max())) / mass[-1], fine))


def _close(
    focal: float, planes: tuple[SizePlane, ...], draws: list[FloatArray], method: Method, walkers: int
) -> FocalLengths:
    each = [plane for plane, focals in zip(planes, draws, strict=True) for _ in focals]
    return FocalLengths(focal=focal, planes=tuple(each), draws=np.concatenate(draws), method=method, walkers=walkers)
