"""OpenCV's detector of people, histograms of oriented gradients (Dalal and Triggs, CVPR 2005): it needs no download."""

import numpy as np
from numpy.typing import NDArray

from vbbench.boxes import suppress
from vbbench.errors import VbbenchError, needs_extra
from vbbench.exchange.detection import Detections

with needs_extra("render", "finding people in pictures"):
    import cv2

ENLARGE = 2.0
"""The detector's window is 128 px high and contains a person of 96 px; pictures are enlarged to find smaller people."""
LEAST_MARGIN = 0.5
"""Detections nearer than this to the support vector machine's plane are not reported."""
EVEN_MARGIN, MARGIN_STEEPNESS = 0.65, 3.5
"""The score at which half of the windows are right, and the slope of their share in log-odds, on rendered streets."""
SAME = 0.4
"""Of two windows that overlap by more than this (intersection over union), only the better is kept."""
_STEP, _MARGIN, _SCALES = (8, 8), (16, 16), 1.05
_SIDES, _ABOVE = 16.0 / 64.0, 16.0 / 128.0
"""The margin around the person in the training pictures, as shares of the window."""


class HogDetector:
    """Finds upright people, at all scales.

    Raises VbbenchError if this OpenCV does not have it.
    """

    def __init__(self) -> None:
        if not hasattr(cv2, "HOGDescriptor"):
            problem = f"OpenCV {cv2.__version__} has no HOG detector"
            raise VbbenchError(f"{problem}; install one that has: pip install 'opencv-python-headless<5'")
        self._hog = cv2.HOGDescriptor()
        self._hog.setSVMDetector(np.asarray(cv2.HOGDescriptor.getDefaultPeopleDetector(), dtype=np.float32))

    def detect(self, rgb: NDArray[np.uint8], period: float | None = None) -> Detections:
        """See `vbbench.exchange.detection.Detector`; a panorama is continued beyond its seam."""
        picture = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
        if period is not None:
            picture = np.concatenate([picture, picture[:, : picture.shape[1] // 6]], axis=1)
        enlarged = cv2.resize(picture, None, fx=ENLARGE, fy=ENLARGE, interpolation=cv2.INTER_LINEAR)
        windows, weights = self._hog.detectMultiScale(
            enlarged, hitThreshold=LEAST_MARGIN, winStride=_STEP, padding=_MARGIN, scale=_SCALES, groupThreshold=0
        )
        left, top, width, height = np.asarray(windows, dtype=np.float64).reshape(-1, 4).T / ENLARGE
        sizes = (1 - 2 * _SIDES) * width, (1 - 2 * _ABOVE) * height
        boxes = np.stack([left + _SIDES * width, top + _ABOVE * height, *sizes], axis=-1)
        margins = np.asarray(weights, dtype=np.float64).reshape(-1)
        scores = 1.0 / (1.0 + np.exp(-MARGIN_STEEPNESS * (margins - EVEN_MARGIN)))
        kept = suppress(boxes, scores, SAME, period)
        return Detections(boxes=boxes[kept], scores=scores[kept])
