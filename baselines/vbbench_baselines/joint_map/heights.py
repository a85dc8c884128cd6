"""How tall people are, from their boxes alone.

A box stands with its foot on the ground, v + l/2 = c_y + f·h_0/r, and is l = f·h/r high: h = h_0·l/(v + l/2 − c_y),
whatever the distance, and wherever the camera is. With independent errors of σ px in top and bottom edge,

    var h = σ² (h_0² + (h_0 − h)²)/(v + l/2 − c_y)².

All boxes of a person and the prior N(μ_h, σ_h²) are put together by their precisions.
"""

from typing import TypedDict

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench.solver import Problem
from vbbench_baselines.joint_map.sighted import horizon

FLOOR = 1e-4
"""Standard deviation in m that every measured height has at least, exact boxes or not."""

LOWEST_FOOT = 1.0
"""Boxes that end less than so many px below the horizon are too far away, or too high, to measure anybody."""


class Heights:
    """Everybody's height as believed so far.

    Attributes
    ----------
    precision, weighted : [K] Σ 1/var in 1/m² and Σ h/var in 1/m, the prior's among them.
    """

    def __init__(self, problem: Problem) -> None:
        people, known = len(problem.tracks), 1.0 / max(problem.height_std, FLOOR) ** 2
        self.precision = np.full(people, known)
        self.weighted = np.full(people, known * problem.height_mean)
        self._facts = horizon(problem.camera), problem.camera.mount_height, problem.pixel_std

    def learn(self, boxes: FloatArray) -> None:
        """Take in the boxes [K, 3] of a frame, or [T, K, 3], in px; NaN = none."""
        _learn(boxes if boxes.ndim == 3 else boxes[None], *self._facts, self.precision, self.weighted)

    def report(self) -> "Report":
        """What is believed so far."""
        return {"heights": self.weighted / self.precision, "height_variances": 1.0 / self.precision}


class Report(TypedDict, total=False):
    """What an estimate says of heights: means [K] in m and variances [K] in m²."""

    heights: FloatArray
    height_variances: FloatArray


@kernel
def _learn(
    boxes: FloatArray, horizon: float, mount: float, std: float, precision: FloatArray, weighted: FloatArray
) -> None:
    for t in range(boxes.shape[0]):
        for k in range(boxes.shape[1]):
            foot = boxes[t, k, 1] + 0.5 * boxes[t, k, 2] - horizon
            if foot >= LOWEST_FOOT:
                height = mount * boxes[t, k, 2] / foot
                known = 1.0 / (FLOOR**2 + (std / foot) ** 2 * (mount**2 + (mount - height) ** 2))
                precision[k] += known
                weighted[k] += known * height
