"""Finds the camera: from a homography, or from head sizes and how people walk."""

from dataclasses import dataclass, replace

import numpy as np

from vbbench.arrays import BoolArray, FloatArray
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
from vbbench_generators.lifting.heads import HeadBoxes, Heads
from vbbench_generators.lifting.settings import LiftingSettings, Method
from vbbench_generators.lifting.smoothing import estimate_strength
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


def find_by_heads(heads: Heads, boxes: HeadBoxes, settings: LiftingSettings) -> Found:
    """The camera in which the heads, the centres of ``boxes``, have the sizes that they have, and walk as people do.

    Raises
    ------
    ValueError
        If sizes or positions leave the camera open.
    """
    focal = settings.focal_median * boxes.size[0]
    seen, drawn = heads.take(boxes.whole), boxes.boxes[boxes.whole]
    for last in (False, True):
        ball = roundness(seen, drawn, focal)
        size = box_sizes(drawn, settings.box) / lengthening(seen, focal, settings.box) ** ball
        fit = fit_plane(seen, size, level=settings.level, resamples=settings.resamples, seed=SEED)
        closing = _close(fit, heads.take(below_horizon(fit.plane.at(heads.x, heads.nu))), boxes, settings)
        if last or ball < _HARDLY:
            break
        focal = closing.focal

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


def _close(fit: PlaneFit, heads: Heads, boxes: HeadBoxes, settings: LiftingSettings) -> Closing:
    if settings.vertical_vanishing_point is not None:
        return close_by_vanishing_point(fit, np.array(settings.vertical_vanishing_point) - boxes.centre)
    if settings.closing == "motion":
        segments = cut_segments(heads, settings.window)
        noise = _noise(fit.plane, heads, settings.head_size)
        closing = close_by_motion(fit, segments, noise, settings.head_size, boxes.size[0], settings)
        if closing is not None:
            return closing
    return close_by_prior(fit, boxes.size[0], settings)


def _noise(plane: SizePlane, heads: Heads, head_size: float) -> FloatArray:
    """[2] noise of the canonical coordinates; see `strength`."""
    value = canonical(plane, heads.x, heads.nu, head_size)
    scale = noise_scale(plane, heads.x, heads.nu, head_size)
    each = [estimate_strength(value[:, n], scale[:, n], heads.frame, heads.track, dt=heads.dt) for n in range(2)]
    return np.array([strength.noise for strength in each])
