"""Lifts the heads of a surveillance picture to the ground: finds the camera, and smooths the tracks."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray
from vbbench.scene import Scene
from vbbench_generators.lifting.camera import GroundCamera, camera_of_homography, camera_of_plane
from vbbench_generators.lifting.fitting import PlaneFit, fit_plane
from vbbench_generators.lifting.focal_length import find_focal_length
from vbbench_generators.lifting.heads import (
    HeadBoxes,
    Heads,
    LiftingSettings,
    Method,
    box_sizes,
    lengthening,
    roundness,
    split_at_gaps,
)
from vbbench_generators.lifting.walking import Smoothed, smooth_tracks, walking_speed


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A value and its 95 % interval; all three are equal if the value was given."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """A static camera above a crowd, calibrated from the heads in its picture.

    Parameters
    ----------
    method : evidence for the focal length; ``homography``: the user gave the calibration.
    pseudo_metric : whether scale and stretch are estimated from head sizes and walking.
    focal : focal length in px.
    tilt, roll : in rad; tilt is downwards, roll the clockwise rotation that levels the picture.
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
    """

    method: Method
    pseudo_metric: bool
    focal: Interval
    tilt: Interval
    roll: Interval
    camera_height: Interval
    horizon: Interval
    stretch: Interval
    head_size: float
    head_height: float
    head_scatter: float | None
    roundness: float
    size_plane: tuple[float, float, float] | None
    size_plane_covariance: tuple[tuple[float, ...], ...] | None
    walkers: int
    walking_speed: float | None
    smoothing_residual_m: float
    smoothing_residual_px: float
    boxes: int
    tracks: int


def calibration_of(
    cameras: tuple[GroundCamera, ...],
    fit: PlaneFit | None,
    heads: Heads,
    smoothed: Smoothed,
    settings: LiftingSettings,
    middle: float,
    **found: Any,
) -> Calibration:
    """The calibration, with 95 % intervals from samples of the posterior.

    Parameters
    ----------
    cameras : the most probable camera, and others drawn from the posterior; none if the camera was given.
    fit : the fit of the head sizes; ``None`` if unused.
    heads : the lifted heads.
    middle : row in px of the picture's centre.
    found : ``method``, ``walkers``, ``roundness`` and ``walking_speed``.
    """

    def interval(figure: Callable[[GroundCamera], float]) -> Interval:
        value, *others = (float(figure(camera)) for camera in cameras)
        low, high = np.quantile(others or [value], [0.025, 0.975])
        return Interval(value=value, low=float(low), high=float(high))

    return Calibration(
        pseudo_metric=fit is not None,
        focal=interval(lambda camera: camera.focal),
        tilt=interval(lambda camera: camera.tilt),
        roll=interval(lambda camera: camera.roll),
        camera_height=interval(lambda camera: camera.height),
        horizon=interval(lambda camera: middle + camera.horizon),
        stretch=interval(lambda camera: camera.focal / np.cos(camera.tilt)),
        head_size=settings.head_size,
        head_height=settings.head_height,
        head_scatter=None if fit is None else fit.scatter,
        size_plane=None if fit is None else (fit.plane.a, fit.plane.b, fit.plane.c),
        size_plane_covariance=None if fit is None else tuple(map(tuple, fit.covariance.tolist())),
        smoothing_residual_m=smoothed.residual_m,
        smoothing_residual_px=smoothed.residual_px,
        boxes=len(heads.x),
        tracks=len(np.unique(heads.track)),
        **found,
    )


_METHODS = {
    "motion": "self-calibrated from head sizes and from how people walk",
    "prior": "self-calibrated from head sizes, the lens by its prior",
    "homography": "by the user's homography",
}


def describe_calibration(calibration: Calibration) -> dict[str, Any]:
    """The calibration for ``dataset.json``, with a ``summary`` in words."""
    c, degrees = calibration, math.degrees(1.0)
    parts = [
        f"camera height {_interval(c.camera_height, ' m', 2)}",
        f"tilt {_interval(c.tilt, '°', 1, degrees)}",
        f"horizon at row {_interval(c.horizon, ' px', 0)}",
        f"focal length {_interval(c.focal, ' px', 0)}",
        f"smoothing took off {c.smoothing_residual_m:.3f} m",
    ]
    kind = "pseudo-metric, " if c.pseudo_metric else ""
    return {"summary": f"{kind}{_METHODS[c.method]}: {'; '.join(parts)}", **asdict(c)}


def _interval(estimate: Interval, unit: str, digits: int, factor: float = 1.0) -> str:
    """Text of a value with its 95 % interval, if it has one."""
    value, low, high = (f"{factor * x:.{digits}f}" for x in (estimate.value, estimate.low, estimate.high))
    return f"{value}{unit}" + ("" if estimate.low == estimate.high else f" ({low} to {high})")


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
    calibration : the camera, with intervals.
    """

    tracks: Scene
    calibration: Calibration


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
