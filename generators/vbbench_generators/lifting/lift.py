"""Lifts the heads of a surveillance picture to the ground: finds the camera, and smooths the tracks."""

from dataclasses import dataclass

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray
from vbbench.scene import Scene
from vbbench_generators.lifting.calibration import Calibration, FoundCamera, calibration_of
from vbbench_generators.lifting.camera import GroundCamera, camera_of_homography, camera_of_plane
from vbbench_generators.lifting.fitting import fit_plane
from vbbench_generators.lifting.focal_length import find_focal_length
from vbbench_generators.lifting.heads import (
    HeadBoxes,
    Heads,
    LiftingSettings,
    SizePlane,
    box_sizes,
    lengthening,
    roundness,
    split_at_gaps,
)
from vbbench_generators.lifting.walking import smooth_tracks, walking_speed

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

    Parameters
    ----------
    boxes : head boxes of one recording.
    settings : the recipe's table ``[lifting]``.
    homography : [3, 3] from px to metres on the ground; without it, the camera is found from the heads.

    Raises
    ------
    VbbenchError
        If the heads, or the homography, do not determine the camera.
    """
    if not len(boxes):
        raise VbbenchError(f"{boxes.name}: no head box to lift")
    heads = boxes.heads()
    try:
        if homography is not None:
            seen = boxes.centre + np.array([np.median(heads.x), np.median(heads.nu)])
            camera = camera_of_homography(homography, boxes.centre, seen, settings.head_height)
            found = FoundCamera(camera=camera, others=(), method="homography", walkers=0, fit=None)
        else:
            found = _find_by_heads(heads, boxes, settings)
        kept = _below_horizon(found.camera.depth(heads.x, heads.nu))
    except ValueError as error:
        advice = "is that of another picture?" if homography is not None else "give its `homography`"
        raise VbbenchError(f"{boxes.name}: the camera cannot be found: {error}; {advice}") from error
    heads = heads.take(kept)
    speed = walking_speed(heads, found.camera, settings.window)
    if settings.apply_walking_speed and speed is not None and found.fit is not None:
        found = found.scaled(settings.walking_speed / speed, settings.head_height)
    heads = split_at_gaps(heads, settings.gap)
    smoothed = smooth_tracks(heads, found.camera, settings.head_size * found.scale, boxes.name)
    calibration = calibration_of(found, heads, smoothed, settings, boxes.centre[1], speed)
    return Lifted(tracks=smoothed.scene, calibration=calibration)


def _find_by_heads(heads: Heads, boxes: HeadBoxes, settings: LiftingSettings) -> FoundCamera:
    """Calibrate the camera from sizes and motion of the heads; raises ValueError if they do not determine it."""
    focal = settings.focal_median * boxes.size[0]
    seen, drawn = heads.take(boxes.whole), boxes.boxes[boxes.whole]
    for last in (False, True):
        ball = roundness(seen, drawn, focal)
        size = box_sizes(drawn, settings.box) / lengthening(seen, focal, settings.box) ** ball
        fit = fit_plane(seen, size, level=settings.level, resamples=settings.resamples, seed=SEED)
        closing = find_focal_length(fit, heads.take(_below_horizon(fit.plane.at(heads.x, heads.nu))), boxes, settings)
        if last or ball < _HARDLY:
            break
        focal = closing.focal

    def camera(plane: SizePlane, focal: float) -> GroundCamera:
        return camera_of_plane(plane, focal, settings.head_size, settings.head_height)

    return FoundCamera(
        camera=camera(fit.plane, closing.focal),
        others=tuple(camera(plane, float(f)) for plane, f in zip(closing.planes, closing.draws, strict=True)),
        method=closing.method,
        walkers=closing.walkers,
        fit=fit,
        roundness=ball,
    )


def _below_horizon(depth: FloatArray) -> BoolArray:
    """Mask [N] of heads whose ``depth`` is clearly positive; ValueError if the horizon cuts through the crowd."""
    kept: BoolArray = depth > _NEAR_HORIZON * np.median(depth)
    if np.mean(~kept) > _FEW:
        raise ValueError(f"the horizon goes through the crowd: {np.mean(~kept):.1%} of the heads are on it or above it")
    return kept
