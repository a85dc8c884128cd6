"""Whether a camera is as exact as its model says, or only roughly known."""

import math

import numpy as np

from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.sequence import Given
from vbbench.solver import FrameEstimate, Problem
from vbbench_baselines.common.bearings import bearings_of
from vbbench_baselines.common.cold_start import begins_cold
from vbbench_baselines.joint_map.measurement.boxes import GroundCheck
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.tracking import Tracking

LOOKS = 2
"""Frames after which it is decided."""

FEWEST = 4
"""Boxes of people whose places are given that can tell."""

MOST_OFF, SPREAD = 1.2, 2.5
"""The median foot may be so many px off, and so many times as many as the boxes' noise spreads a median."""


class RoughCamera:
    """Looks whether the camera is known only roughly, and answers from then on if so.

    It is where the problem says so, where feet of given people tell in the first two frames, and after a cold start,
    where nobody's place is given, where the heights that feet imply are no people's in the end.

    Parameters
    ----------
    settings : what is assumed of such a camera; ``None`` = none is looked for.
    problem : of the sequence that begins.
    """

    def __init__(self, settings: Settings | None, problem: Problem) -> None:
        self._settings, self._problem = settings, problem
        self._tracking: Tracking | None = None
        self._early: list[tuple[FloatArray, Given]] = []
        if settings is not None and is_told(problem):
            self._tracking = Tracking(settings, problem)

    def step(self, boxes: FloatArray, given: Given) -> FrameEstimate | None:
        """The answer for the next frame, if the camera is a rough one."""
        if self._settings is None:
            return None
        if self._tracking is None and len(self._early) < LOOKS:
            self._early.append((boxes, given))
            if len(self._early) == LOOKS and self._is_rough(given):
                self._tracking = Tracking(self._settings, self._problem)
                for before in self._early[:-1]:
                    self._tracking.step(*before)
        return None if self._tracking is None else self._tracking.step(boxes, given)

    def _is_rough(self, given: Given) -> bool:
        boxes = np.stack([boxes for boxes, _ in self._early])
        return is_contradicted(self._problem, boxes, given.frames(slice(-LOOKS, None)))

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people from now on."""
        if self._tracking is not None:
            self._tracking.forget(columns)


def is_rough(problem: Problem, boxes: FloatArray, given: Given) -> bool:
    """Whether the camera of a whole sequence of boxes [T, K, 3] is known only roughly."""
    if is_told(problem):
        return True
    return len(boxes) >= LOOKS and is_contradicted(problem, boxes[:LOOKS], given.frames(slice(LOOKS)))


def is_told(problem: Problem) -> bool:
    """Whether the problem says that tilt, mount or box sizes are not exact."""
    return problem.tilt_std > 0.0 or problem.mount_height_std > 0.0 or problem.box_std > 0.0


def is_contradicted(problem: Problem, boxes: FloatArray, given: Given) -> bool:
    """Whether feet are not where an exact camera on flat ground shows them, by the first boxes [T, K, 3] in px.

    Those of people whose places are ``given`` tell. Hidden feet and boxes that are wrong are few; a tilt moves all feet
    alike. If nobody's place is ever given, the heights tell that feet imply.
    """
    if begins_cold(given, len(boxes) - 1):
        return not GroundCheck(problem).look(boxes)
    seen = bearings_of(problem.camera, boxes)
    place = world_to_relative(given.positions, given.poses)
    with np.errstate(invalid="ignore", divide="ignore"):
        off = (
            (seen.foot - problem.camera.mount_height / np.hypot(place[..., 0], place[..., 1])) * seen.size / seen.length
        )
    off = off[np.isfinite(off) & (seen.cut == 0)]
    if len(off) < FEWEST:
        return False
    return bool(abs(np.median(off)) > MOST_OFF * (1.0 + SPREAD * problem.pixel_std / math.sqrt(len(off))))
