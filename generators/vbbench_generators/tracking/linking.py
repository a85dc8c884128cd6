"""The tracker of the tier `tracked` for anybody's detections; registered as tracker ``byte``."""

import numpy as np

from vbbench.exchange.detection import Detections
from vbbench.geometry import IntArray
from vbbench_generators.tracking import tracker
from vbbench_generators.tracking.association import from_centres
from vbbench_generators.tracking.settings import get_tracking


class ByteTracker:
    """Links detections in two stages; see `vbbench.exchange.detection.TrackerFactory`."""

    def __init__(self, *, dt: float, period: float | None = None) -> None:
        self._tracker = tracker.Tracker(get_tracking().tracker, dt, period)

    def step(self, detections: Detections) -> tuple[IntArray, Detections]:
        """See `vbbench.exchange.detection.Tracker`."""
        corners, sizes = detections.boxes[:, :2], detections.boxes[:, 2:]
        centred = np.concatenate([corners + 0.5 * sizes, sizes], axis=-1)
        found = self._tracker.step(tracker.Detections(centred, detections.scores))
        return found.ids, Detections(boxes=from_centres(found.boxes), scores=found.scores)
