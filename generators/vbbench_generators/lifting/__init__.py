"""Lifts the heads of a surveillance picture to the ground: self-calibration or a homography, and smoothing."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray
from vbbench.scene import Scene
from vbbench_generators import _core
from vbbench_generators.lifting.camera import GroundCamera, camera_of_homography, camera_of_plane
from vbbench_generators.lifting.fitting import PlaneFit, fit_plane
from vbbench_generators.lifting.focal_length import cut_segments, estimate_noise, find_focal_length
from vbbench_generators.lifting.heads import (
    HeadBoxes,
    Heads,
    LiftingSettings,
    box_sizes,
    lengthening,
    roundness,
    split_at_gaps,
)

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
        noise, acceleration = estimate_noise(ground[:, axis], scale[:, axis], heads.frame, heads.track, dt=heads.dt)
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


_METHODS = {
    "motion": "self-calibrated from head sizes and from how people walk",
    "prior": "self-calibrated from head sizes, the lens by its prior",
    "homography": "by the user's homography",
}


def calibration_of(
    cameras: tuple[GroundCamera, ...],
    fit: PlaneFit | None,
    heads: Heads,
    smoothed: Smoothed,
    settings: LiftingSettings,
    middle: float,
    **found: Any,
) -> dict[str, Any]:
    """The calibration of a camera above a crowd for ``dataset.json``, with 95 % intervals by samples of the posterior.

    Parameters
    ----------
    cameras : the most probable camera, and others drawn from the posterior; none if the camera was given.
    fit : the fit of the head sizes; ``None`` if unused.
    heads : the lifted heads.
    middle : row in px of the picture's centre.
    found : ``method``, ``walkers``, ``roundness`` and ``walking_speed``.

    Returns
    -------
    summary : the calibration in words.
    method : evidence for the focal length; ``homography``: the user gave the calibration.
    pseudo_metric : whether scale and stretch are estimated from head sizes and walking.
    focal, tilt, roll : in px and rad; tilt is downwards, roll the clockwise rotation that levels the picture.
    camera_height : above the ground, in m.
    horizon : row in px, from the picture's top, where the horizon crosses the middle column.
    stretch : g = f / cos θ in px; depths are proportional to it.
    head_size, head_height : assumed size and height of heads in m.
    head_scatter : robust standard deviation of head sizes about their plane, relative to the size; ``None`` if unused.
    roundness : share, 0 to 1, of a sphere's perspective elongation off the axis that was removed from the sizes.
    size_plane : (a, b, c) of head sizes, in px, px per row and px per column; ``None`` if unused.
    size_plane_covariance : [3, 3] of these three, from resampled tracks; ``None`` if unused.
    walkers : number of people used as evidence.
    walking_speed : median speed of walkers in m/s; ``None`` if nobody walks.
    smoothing_residual_m, smoothing_residual_px : root mean square of the smoother's corrections of tracks.
    boxes, tracks : numbers after lifting, without boxes on or above the horizon; long gaps divide a track.

    From ``focal`` to ``stretch``, each has ``value``, ``low`` and ``high``; all three are equal if it was given.
    """

    def interval(figure: Callable[[GroundCamera], float]) -> dict[str, float]:
        value, *others = (float(figure(camera)) for camera in cameras)
        low, high = np.quantile(others or [value], [0.025, 0.975])
        return {"value": value, "low": float(low), "high": float(high)}

    facts = {
        "method": found["method"],
        "pseudo_metric": fit is not None,
        "focal": interval(lambda camera: camera.focal),
        "tilt": interval(lambda camera: camera.tilt),
        "roll": interval(lambda camera: camera.roll),
        "camera_height": interval(lambda camera: camera.height),
        "horizon": interval(lambda camera: middle + camera.horizon),
        "stretch": interval(lambda camera: camera.focal / np.cos(camera.tilt)),
        "head_size": settings.head_size,
        "head_height": settings.head_height,
        "head_scatter": None if fit is None else fit.scatter,
        "roundness": found["roundness"],
        "size_plane": None if fit is None else (fit.plane.a, fit.plane.b, fit.plane.c),
        "size_plane_covariance": None if fit is None else fit.covariance.tolist(),
        "walkers": found["walkers"],
        "walking_speed": found["walking_speed"],
        "smoothing_residual_m": smoothed.residual_m,
        "smoothing_residual_px": smoothed.residual_px,
        "boxes": len(heads.x),
        "tracks": len(np.unique(heads.track)),
    }
    parts = [
        f"camera height {_interval(facts['camera_height'], ' m', 2)}",
        f"tilt {_interval(facts['tilt'], '°', 1, math.degrees(1.0))}",
        f"horizon at row {_interval(facts['horizon'], ' px', 0)}",
        f"focal length {_interval(facts['focal'], ' px', 0)}",
        f"smoothing took off {smoothed.residual_m:.3f} m",
    ]
    kind = "" if fit is None else "pseudo-metric, "
    return {"summary": f"{kind}{_METHODS[found['method']]}: {'; '.join(parts)}", **facts}


def _interval(estimate: dict[str, float], unit: str, digits: int, factor: float = 1.0) -> str:
    """Text of a value with its 95 % interval, if it has one."""
    value, low, high = (f"{factor * estimate[name]:.{digits}f}" for name in ("value", "low", "high"))
    return f"{value}{unit}" + ("" if estimate["low"] == estimate["high"] else f" ({low} to {high})")


SEED = 20200830
"""Of the resampling: the same boxes give the same intervals."""

_NEAR_HORIZON = 0.05
_FEW = 0.005
_HARDLY = 0.05


@dataclass(frozen=True, kw_only=True)
class Lifted:
    """A crowd on the ground, and the calibration of its camera.

    Parameters
    ----------
    tracks : in m, X to the right and Y forward from the camera's foot, or in the frame of the user's homography.
    calibration : of the camera, as `calibration_of` returns it.
    """

    tracks: Scene
    calibration: dict[str, Any]


def lift(boxes: HeadBoxes, settings: LiftingSettings, homography: FloatArray | None = None) -> Lifted:
    """Lift a crowd's heads to the ground.

    Raises VbbenchError if the heads, or the homography, do not determine the camera.

    Parameters
    ----------
    boxes : head boxes of one recording.
    settings : the recipe's table ``[lifting]``.
    homography : [3, 3] from px to metres on the ground; without it, the camera is found from the heads.
    """
    if not len(boxes):
        raise VbbenchError(f"{boxes.name}: no head box to lift")
    heads, fit, cameras = boxes.heads(), None, tuple[GroundCamera, ...]()
    found: dict[str, Any] = {"method": "homography", "walkers": 0, "roundness": 0.0}
    try:
        if homography is not None:
            seen = boxes.centre + np.array([np.median(heads.x), np.median(heads.nu)])
            cameras = (camera_of_homography(homography, boxes.centre, seen, settings.head_height),)
        else:
            cameras, fit, found = _find_by_heads(heads, boxes, settings)
        kept = _below_horizon(cameras[0].depth(heads.x, heads.nu))
    except ValueError as error:
        advice = "is that of another picture?" if homography is not None else "give its `homography`"
        raise VbbenchError(f"{boxes.name}: the camera cannot be found: {error}; {advice}") from error
    heads = heads.take(kept)
    found["walking_speed"] = walking_speed(heads, cameras[0], settings.window)
    heads = split_at_gaps(heads, settings.gap)
    smoothed = smooth_tracks(heads, cameras[0], settings.head_size, boxes.name)
    calibration = calibration_of(cameras, fit, heads, smoothed, settings, boxes.centre[1], **found)
    return Lifted(tracks=smoothed.scene, calibration=calibration)


def _find_by_heads(
    heads: Heads, boxes: HeadBoxes, settings: LiftingSettings
) -> tuple[tuple[GroundCamera, ...], PlaneFit, dict[str, Any]]:
    """Cameras, fit and facts as `calibration_of` takes them; raises ValueError if heads do not determine the camera."""
    focal = settings.focal_median * boxes.size[0]
    seen, drawn = heads.take(boxes.whole), boxes.boxes[boxes.whole]
    for last in (False, True):
        ball = roundness(seen, drawn, focal)
        size = box_sizes(drawn) / lengthening(seen, focal) ** ball
        fit = fit_plane(seen, size, resamples=settings.resamples, seed=SEED)
        closing = find_focal_length(fit, heads.take(_below_horizon(fit.plane.at(heads.x, heads.nu))), boxes, settings)
        if last or ball < _HARDLY:
            break
        focal = closing.focal
    lenses = [(fit.plane, closing.focal), *zip(closing.planes, closing.draws.tolist(), strict=True)]
    cameras = tuple(camera_of_plane(plane, f, settings.head_size, settings.head_height) for plane, f in lenses)
    return cameras, fit, {"method": closing.method, "walkers": closing.walkers, "roundness": ball}


def _below_horizon(depth: FloatArray) -> BoolArray:
    """Mask [N] of heads whose ``depth`` is clearly positive; ValueError if the horizon cuts through the crowd."""
    kept: BoolArray = depth > _NEAR_HORIZON * np.median(depth)
    if np.mean(~kept) > _FEW:
        raise ValueError(f"the horizon goes through the crowd: {np.mean(~kept):.1%} of the heads are on it or above it")
    return kept
