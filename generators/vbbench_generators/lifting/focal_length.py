"""The focal length, which head sizes do not determine, and with it the stretch g = f / cos θ of depths."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_generators.lifting.fitting import PlaneFit
from vbbench_generators.lifting.heads import HeadBoxes, Heads, LiftingSettings, Method, SizePlane
from vbbench_generators.lifting.walking import (
    Pace,
    Segments,
    Steps,
    cut_segments,
    estimate_pace,
    estimate_strength,
    log_likelihood,
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
    each = [estimate_strength(value[:, n], scale[:, n], heads.frame, heads.track, dt=heads.dt) for n in range(2)]
    noise = np.array([strength.noise for strength in each])
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
