"""The estimator in C++ as a solver."""

from typing import Any

import numpy as np

from vbbench.geometry import IntArray
from vbbench.solver import CARRIERS, Carrier, Frame, FrameEstimate, Problem
from vbbench_baselines import _core
from vbbench_baselines.common.bearings import bearings_of


class Smoother:
    """Sliding-window maximum a posteriori estimate (C++).

    Parameters
    ----------
    carried_by : what carries the camera; ``None`` for what the problem states.
    constants : numbers of ``Constants`` in C++, or ``size``, ``rounds`` or ``least``.
    """

    def __init__(self, carried_by: Carrier | None = None, **constants: float) -> None:
        self._core = _core.Estimator()
        self._carried_by = carried_by
        for name, value in constants.items():
            self._core.set(name.replace("__", "[") + "]" * ("__" in name), value)

    def start(self, problem: Problem) -> None:
        """Begin a sequence."""
        self._problem = problem
        known = problem.tilt_std == 0.0 and problem.mount_height_std == 0.0 and problem.box_std == 0.0
        self._core.start(
            {
                "dt": problem.dt,
                "height_mean": problem.height_mean,
                "height_std": problem.height_std,
                "pixel_std": problem.pixel_std,
                "box_std": problem.box_std,
                "tilt_std": problem.tilt_std,
                "mount_height_std": problem.mount_height_std,
                "mount_height": problem.camera.mount_height,
                "box_edge": -1.0 if problem.box_edge is None else problem.box_edge,
                "columns": len(problem.tracks),
                "known_calibration": known,
                "covariances": problem.covariances,
                "carrier": CARRIERS.index(self._carried_by or problem.carried_by),
            }
        )

    def step(self, frame: Frame) -> FrameEstimate:
        """Answer for this frame."""
        problem, people = self._problem, len(self._problem.tracks)
        b = bearings_of(problem.camera, frame.observations)
        boxes = np.stack([b.azimuth, b.foot, b.length, b.size, b.width], axis=-1)
        odometry = frame.given.odometry
        motion = np.full(3, np.nan) if odometry is None else np.ascontiguousarray(odometry.motions[-1])
        covariance = np.zeros((3, 3)) if odometry is None else np.ascontiguousarray(odometry.covariances[-1])
        pose, spread = np.empty(3), np.full((3, 3), np.nan)
        places, spreads = np.full((people, 2), np.nan), np.full((people, 2, 2), np.nan)
        heights = np.full(people, problem.height_mean)
        converged = self._core.step(
            np.ascontiguousarray(boxes),
            np.ascontiguousarray(b.cut, np.int32),
            np.ascontiguousarray(frame.given.poses),
            np.ascontiguousarray(frame.given.positions),
            motion,
            covariance,
            pose,
            spread,
            places,
            spreads,
            heights,
        )
        report: dict[str, Any] = {}
        if problem.covariances:
            report = {"pose_covariance": spread, "position_covariances": spreads}
        return FrameEstimate(pose=pose, positions=places, converged=converged, heights=heights, **report)

    def forget(self, columns: IntArray) -> None:
        """From the next frame on these columns are new people."""
        self._core.forget(np.ascontiguousarray(columns, np.int32))
