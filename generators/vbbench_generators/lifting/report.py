"""Writes down what is known of the camera."""

from collections.abc import Callable

import numpy as np

from vbbench_generators.lifting.calibration import Calibration, Estimate
from vbbench_generators.lifting.camera import GroundCamera
from vbbench_generators.lifting.finding import Found
from vbbench_generators.lifting.settings import LiftingSettings
from vbbench_generators.lifting.tracks import Heads, Smoothed


def calibration_of(
    found: Found, heads: Heads, smoothed: Smoothed, settings: LiftingSettings, middle: float, speed: float | None
) -> Calibration:
    """The calibration, with 95 % intervals from the cameras that the evidence allows.

    Parameters
    ----------
    heads : those lifted.
    middle : row in px of the picture's centre.
    speed : median walking speed in m/s before ``found`` was scaled by it.
    """

    def estimate(figure: Callable[[GroundCamera], float]) -> Estimate:
        value = float(figure(found.camera))
        if not found.others:
            return Estimate(value=value, low=value, high=value)
        low, high = np.quantile([figure(camera) for camera in found.others], [0.025, 0.975])
        return Estimate(value=value, low=float(low), high=float(high))

    fit = found.fit
    return Calibration(
        method=found.method,
        pseudo_metric=fit is not None,
        focal=estimate(lambda camera: camera.focal),
        tilt=estimate(lambda camera: camera.tilt),
        roll=estimate(lambda camera: camera.roll),
        camera_height=estimate(lambda camera: camera.height),
        horizon=estimate(lambda camera: middle + camera.horizon),
        stretch=estimate(lambda camera: camera.focal / np.cos(camera.tilt)),
        head_size=settings.head_size * found.scale,
        head_height=settings.head_height,
        head_scatter=None if fit is None else fit.scatter,
        roundness=found.roundness,
        size_plane=None if fit is None else (fit.plane.a, fit.plane.b, fit.plane.c),
        size_plane_covariance=None if fit is None else tuple(map(tuple, fit.covariance.tolist())),
        walkers=found.walkers,
        walking_speed=speed,
        scale_applied=found.scale,
        smoothing_residual_m=smoothed.residual_m,
        smoothing_residual_px=smoothed.residual_px,
        boxes=len(heads.x),
        tracks=len(np.unique(heads.track)),
    )
