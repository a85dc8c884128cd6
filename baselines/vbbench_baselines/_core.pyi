"""The extension module: sources in ``baselines/cpp``, built by ``CMakeLists.txt``."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray, IntArray

Singles = NDArray[np.float32]

class Estimator:
    """Sliding-window maximum a posteriori estimate of poses, calibration and people's paths.

    All arrays are of float64 in C order, or int32 where they count; NaN = absent. Anything else is a `VbbenchError`.
    """

    def __init__(self) -> None: ...
    def set(self, name: str, value: float) -> None:
        """Set one of the constants of ``constants.hpp``, or ``size``, ``rounds`` or ``least``."""

    def start(self, facts: dict[str, Any]) -> None:
        """Begin a recording."""

    def step(
        self,
        boxes: FloatArray,
        cut: IntArray,
        poses: FloatArray,
        positions: FloatArray,
        motion: FloatArray,
        motion_covariance: FloatArray,
        pose: FloatArray,
        pose_covariance: FloatArray,
        places: FloatArray,
        place_covariances: FloatArray,
        heights: FloatArray,
    ) -> bool:
        """Take a frame, and write its estimate into the last five arrays; whether it converged.

        Parameters
        ----------
        boxes : [K, 5] azimuth, foot, length, pixels, width, as `Bearings` has them.
        cut : [K] what the border cuts off.
        poses, positions : [3, 3] and [3, K, 2] given in the last three frames.
        motion, motion_covariance : [3] and [3, 3] of odometry.
        pose, pose_covariance : [3] and [3, 3].
        places, place_covariances : [K, 2] and [K, 2, 2].
        heights : [K] in m.
        """

    def forget(self, columns: IntArray) -> None:
        """From the next frame on these columns [M] are new people."""

    def gradient_errors(self) -> list[float]:
        """Largest relative errors of the gradient by path, height, own edge, calibration and camera."""

    def cost(self) -> float:
        """Negative log posterior of the window, up to a constant."""

    def linear_system(self) -> dict[str, FloatArray]:
        """The window's rows and its Gaussian priors.

        ``residuals``, ``weights`` [R] and ``jacobian`` [R, N] of the rows, ``information`` [N, N] and ``gradient`` [N]
        of the priors, and which of the N variables are ``free``.
        """

    def eliminated_step(self) -> FloatArray:
        """The undamped Gauss–Newton step [N] of the window, by elimination; empty where there is none."""

    def calibration(self) -> list[float]:
        """Pitch, roll, mount height, column offset, edge, odometry's scale and turn."""

    def modes(self) -> list[float]:
        """Posterior of the motion modes in the newest step."""

class FormerNetwork:
    """The learned network with its weights, which are float32 in C order; see `former.inference`.

    Raises
    ------
    VbbenchError
        If the weights are not those of a network.
    """

    def __init__(self, weights: Mapping[str, Singles], feet: bool, heads: bool) -> None: ...
    def advance(
        self,
        people: Singles,
        observer: Singles,
        sights: Singles,
        given: Singles,
        dt: float,
        spread: float,
        pose: Singles,
        places: Singles,
    ) -> None:
        """Take a frame of ``dt`` s: renew what is remembered, and write the answer into the last two arrays.

        Parameters
        ----------
        people, observer : [K, 49] and [56], records `WALKER` and `OBSERVER`.
        sights, given : [K, 15] and [11], records `SIGHT` and `GIVEN`.
        spread : the standard deviation of heights, as a share of their mean.
        pose, places : [9] and [K, 4], records `POSE` and `PLACE`.
        """
