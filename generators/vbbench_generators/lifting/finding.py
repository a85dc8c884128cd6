"""Finds the camera: from a homography, or from head sizes and how people walk."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vbbench.arrays import BoolArray, FloatArray
from vbbench_generators.lifting.calibration import Method
from vbbench_generators.lifting.camera import GroundCamera, camera_of_homography, camera_of_plane
from vbbench_generators.lifting.fitting import PlaneFit, fit_plane
from vbbench_generators.lifting.focal_length import (
    Closing,
    canonical,
    close_by_motion,
    close_by_prior,
    close_by_vanishing_point,
    noise_scale,
)
from vbbench_generators.lifting.head_sizes import SizePlane, box_sizes, lengthening, roundness
from vbbench_generators.lifting.settings import LiftingSettings
from vbbench_generators.lifting.smoothing import Heads, estimate_strength
from vbbench_generators.lifting.walking import cut_segments

SEED = 20200830
"""Of the resampling: the same boxes give the same intervals."""

_NEAR_HORIZON = 0.05
_FEW = 0.005
_HARDLY = 0.05


@dataclass(frozen=True, kw_only=True)
class Found:
    """A camera, and others that the same evidence allows.

    Parameters
    ----------
    camera : the one to use.
    others : drawn from what is known; empty if the camera was given.
    method : what closed the focal length.
    walkers : people whose motion was asked.
    fit : of the head sizes; ``None`` if unasked.
    roundness : how much of a ball's lengthening off the axis was taken off the sizes, 0 to 1.
    scale : factor by which all lengths were multiplied.
    """

    camera: GroundCamera
    others: tuple[GroundCamera, ...]
    method: Method
    walkers: int
    fit: PlaneFit | None
    roundness: float = 0.0
    scale: float = 1.0

    def scaled(self, factor: float, head_height: float) -> "Found":
        """The same in a world ``factor`` times as large, but for the height in m at which heads are."""
        camera = self.camera.scaled(factor, head_height)
        others = tuple(other.scaled(factor, head_height) for other in self.others)
        return replace(self, camera=camera, others=others, scale=self.scale * factor)


def find_by_homography(homography: FloatArray, heads: Heads, centre: FloatArray, settings: LiftingSettings) -> Found:
    """The camera of a homography from the picture, in px from its corner, to the ground.

    Raises
    ------
    ValueError
        If it has no such camera.
    """
    seen = centre + np.array([np.median(heads.x), np.median(heads.nu)])
    camera = camera_of_homography(homography, centre, seen, settings.head_height)
    return Found(camera=camera, others=(), method="homography", walkers=0, fit=None)


def find_by_heads(
    heads: Heads, boxes: FloatArray, whole: BoolArray, picture: tuple[int, int], settings: LiftingSettings
) -> Found:
    """The camera in which the heads have the sizes that they have, and walk as people do.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px.
    whole : [N] boxes that the picture's edge does not cut.
    picture : width and height in px.

    Raises
    ------
    ValueError
        If sizes or positions leave the camera open.
    """
    focal = settings.focal_median * picture[0]
    seen, drawn = heads.take(whole), boxes[whole]
    for last in (False, True):
        ball = roundness(seen.x, seen.nu, drawn, seen.track, focal)
        size = box_sizes(drawn, settings.box) / lengthening(seen.x, seen.nu, focal, settings.box) ** ball
        fit = _fit(seen, size, settings)
        closing = _close(fit, heads.take(below_horizon(fit.plane.at(heads.x, heads.nu))), picture, settings)
        if last or ball < _HARDLY:
            break
        focal = closing.focal
    return _found(fit, closing, ball, settings)


def _fit(heads: Heads, size: FloatArray, settings: LiftingSettings) -> PlaneFit:
    options: dict[str, Any] = {"level": settings.level, "resamples": settings.resamples, "seed": SEED}
    return fit_plane(heads.x, heads.nu, size, heads.track, **options)


def _found(fit: PlaneFit, closing: Closing, ball: float, settings: LiftingSettings) -> Found:
    def camera(plane: SizePlane, focal: float) -> GroundCamera:
        return camera_of_plane(plane, focal, settings.head_size, settings.head_height)

    return Found(
        camera=camera(fit.plane, closing.focal),
        others=tuple(camera(plane, float(f)) for plane, f in zip(closing.planes, closing.draws, strict=True)),
        method=closing.method,
        walkers=closing.walkers,
        fit=fit,
        roundness=ball,
    )


def below_horizon(depth: FloatArray) -> BoolArray:
    """Which heads [N] are on the ground in front of the camera; ``depth`` vanishes on the horizon.

    Raises
    ------
    ValueError
        If the horizon goes through the crowd.
    """
    kept: BoolArray = depth > _NEAR_HORIZON * np.median(depth)
    if np.mean(~kept) > _FEW:
        raise ValueError(f"the horizon goes through the crowd: {np.mean(~kept):.1%} of the heads are on it or above it")
    return kept


def _close(fit: PlaneFit, heads: Heads, picture: tuple[int, int], settings: LiftingSettings) -> Closing:
    if settings.vertical_vanishing_point is not None:
        centre = np.array(picture) / 2.0
        return close_by_vanishing_point(fit, np.array(settings.vertical_vanishing_point) - centre)
    if settings.closing == "motion":
        segments = cut_segments(heads.x, heads.nu, heads.frame, heads.track, dt=heads.dt, window=settings.window)
        noise = _noise(fit.plane, heads, settings.head_size)
        closing = close_by_motion(fit, segments, noise, settings.head_size, picture[0], settings)
        if closing is not None:
            return closing
    return close_by_prior(fit, picture[0], settings)


def _noise(plane: SizePlane, heads: Heads, head_size: float) -> FloatArray:
    """[2] noise of the canonical coordinates; see `strength`."""
    value = canonical(plane, heads.x, heads.nu, head_size)
    scale = noise_scale(plane, heads.x, heads.nu, head_size)
    each = [estimate_strength(value[:, n], scale[:, n], heads.frame, heads.track, dt=heads.dt) for n in range(2)]
    return np.array([strength.noise for strength in each])
