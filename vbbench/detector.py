"""What detectors and trackers must offer. They register under ``vbbench.detectors`` and ``vbbench.trackers``."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.arrays import FloatArray, IntArray, frozen_array


@dataclass(frozen=True, kw_only=True)
class Detections:
    """What is found in one picture.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px, 0 the picture's left and top edge.
    scores : [N] from 0 to 1: about how likely it is that somebody is there.
    """

    boxes: FloatArray
    scores: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "boxes", frozen_array("boxes", self.boxes, (None, 4)))
        object.__setattr__(self, "scores", frozen_array("scores", self.scores, (len(self.boxes),)))


class Detector(Protocol):
    """Finds people in pictures; a class that is called without arguments."""

    def detect(self, rgb: NDArray[np.uint8], period: float | None = None) -> Detections:
        """People in a picture.

        Parameters
        ----------
        rgb : [H, W, 3] sRGB, row 0 at the top.
        period : width in px of a picture that closes on itself, a panorama's; ``None`` for one with borders. Boxes on
            the seam may reach beyond it on either side.
        """


class Tracker(Protocol):
    """Links the detections of a sequence, frame after frame."""

    def step(self, detections: Detections) -> tuple[IntArray, Detections]:
        """Take in the next frame's detections; tell of the tracks that are seen in it: ids [N] and their boxes."""


class TrackerFactory(Protocol):
    """What an entry point of ``vbbench.trackers`` names."""

    def __call__(self, *, dt: float, period: float | None = None) -> Tracker:
        """A tracker of one sequence of ``dt`` seconds a frame; ``period`` as in `Detector.detect`."""
