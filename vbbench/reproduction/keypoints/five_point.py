"""Relative poses by OpenCV: the five-point method of Nistér (2004) within RANSAC, and the pose of its matrix.

What OpenCV returns is the essential matrix of the best sample of five points; no other point corrects it.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vbbench.errors import needs_extra
from vbbench.geometry import BoolArray, FloatArray
from vbbench.reproduction.keypoints.views import Views

FEWEST = 5
ANY_DISTANCE = 1e9
"""A reach that leaves no point out."""


@dataclass(frozen=True, kw_only=True)
class Method:
    """How OpenCV is called; the defaults are its own.

    Parameters
    ----------
    sampling : the consensus that chooses a sample: its flag in OpenCV.
    threshold : largest distance in px of a point from its epipolar line, if it is to agree.
    confidence : that the best sample was found.
    reach : points count in the choice among the four poses of a matrix up to so many lengths of the translation.
    """

    sampling: Literal["RANSAC", "LMEDS", "USAC_MAGSAC"] = "RANSAC"
    threshold: float = 1.0
    confidence: float = 0.999
    reach: float = 50.0


OPENCVS = Method()


@dataclass(frozen=True, kw_only=True)
class Poses:
    """Poses of the second cameras of N trials.

    Parameters
    ----------
    rotation : [N, 3, 3] R.
    direction : [N, 3] from the first camera to the second, of length 1; 0 where there was no answer.
    """

    rotation: FloatArray
    direction: FloatArray

    @property
    def answered(self) -> BoolArray:
        """[N] whether there was an answer."""
        return np.asarray(self.direction.any(axis=-1))


def check_opencv() -> None:
    """Raise MissingExtraError if OpenCV is not installed."""
    with needs_extra("render", "the five-point method"):
        import cv2  # noqa: F401


def five_point(views: Views, method: Method, seed: int) -> Poses:
    """The pose of every trial; where there is none, the camera is said not to have moved.

    Raises
    ------
    MissingExtraError
        If OpenCV is not installed.
    """
    with needs_extra("render", "the five-point method"):
        import cv2
    cv2.setRNGSeed(seed % 2**31)
    trials = len(views.centre)
    rotation, direction = np.tile(np.eye(3), (trials, 1, 1)), np.zeros((trials, 3))
    camera, flag = views.camera.intrinsics, getattr(cv2, method.sampling)
    for trial, (first, second) in enumerate(zip(views.first, views.second, strict=True)):
        known = ~np.isnan(first[:, 0])
        if known.sum() < FEWEST:
            continue
        pair = first[known], second[known]
        matrix, agree = cv2.findEssentialMat(*pair, camera, flag, method.confidence, method.threshold)
        if matrix is None:
            continue
        # A sample may have several matrices, one below the other.
        found = cv2.recoverPose(matrix[:3], *pair, camera, distanceThresh=method.reach, mask=agree)
        rotation[trial], direction[trial] = found[1], -(found[1].T @ found[2])[:, 0]
    return Poses(rotation=rotation, direction=direction)
