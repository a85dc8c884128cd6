"""Whether a camera is as exact as its model says, or only roughly known."""

import math
from typing import NamedTuple

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
"""Frames after which it is decided where places are given."""

PATIENT = 50
"""Frames after which it is decided after a cold start: robots are often switched on where nobody is in sight."""

FEWEST, SEVERAL = 4, 2
"""Boxes that can tell, of people whose places are given, or of so many people after a cold start."""

MOST_OFF, SPREAD = 1.2, 2.5
"""The median foot may be so many px off, and so many times as many as the boxes' noise spreads a median."""


class RoughCamera:
    """Looks whether the camera is known only roughly, and answers from then on if so.

    It is where the problem says so, or where `FirstLooks` finds it out; then all frames so far are gone through again.

    Parameters
    ----------
    settings : what is assumed of such a camera; ``None`` = none is looked for.
    problem : of the sequence that begins.
    """

    def __init__(self, settings: Settings | None, problem: Problem) -> None:
        self._settings, self._problem = settings, problem
        self._tracking: Tracking | None = None
        self._looks, self._early = FirstLooks(problem), list[_Frame]()
        self._forgotten = _NOBODY
        if settings is not None and is_told(problem):
            self._tracking = Tracking(settings, problem)

    def step(self, boxes: FloatArray, given: Given) -> FrameEstimate | None:
        """The answer for the next frame, if the camera is a rough one."""
        if self._settings is None:
            return None
        if self._tracking is None and not self._looks.over:
            self._early.append(_Frame(self._forgotten, boxes, given))
            self._forgotten = _NOBODY
            if self._looks.look(boxes, given):
                self._tracking = self._followed(self._settings)
            if self._looks.over:
                self._early.clear()
        return None if self._tracking is None else self._tracking.step(boxes, given)

    def _followed(self, settings: Settings) -> Tracking:
        """As it stands before the newest frame."""
        tracking = Tracking(settings, self._problem)
        for frame in self._early[:-1]:
            tracking.forget(frame.forgotten)
            tracking.step(frame.boxes, frame.given)
        tracking.forget(self._early[-1].forgotten)
        return tracking

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people from now on."""
        if self._tracking is not None:
            self._tracking.forget(columns)
        elif not self._looks.over:
            self._looks.forget(columns)
            self._forgotten = np.union1d(self._forgotten, columns)


class _Frame(NamedTuple):
    """An early frame: the columns that stand for new people from it on, boxes, and what is given."""

    forgotten: IntArray
    boxes: FloatArray
    given: Given


_NOBODY: IntArray = np.zeros(0, np.int64)


class FirstLooks:
    """What the first frames tell of a camera: the feet of people whose places are given, or heights after a cold start.

    After a cold start it is rough as soon as the heights that feet imply are no people's, and in the end where next to
    nobody was seen: cameras of which nothing is known are seldom exact.

    Parameters
    ----------
    problem : of the sequence that begins.

    Attributes
    ----------
    over : whether it is decided.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem, self._ground = problem, GroundCheck(problem)
        self._frames, self.over = 0, False
        self._before: FloatArray

    def look(self, boxes: FloatArray, given: Given) -> bool:
        """Whether the camera is rough, after one more frame of boxes [K, 3]; ``given`` [≥ 2 from the second on]."""
        self._frames += 1
        level = self._ground.look(boxes)
        if self._frames < LOOKS:
            self._before = boxes
            return False
        if self._frames == LOOKS and not begins_cold(given, LOOKS - 1):
            self.over = True
            return is_contradicted(self._problem, np.stack((self._before, boxes)), given.frames(slice(-LOOKS, None)))
        last = self._frames == PATIENT
        self.over = last or not level
        return not level or (last and not self._has_told)

    @property
    def _has_told(self) -> bool:
        boxes = self._ground.boxes
        return bool(boxes.sum() >= FEWEST and np.count_nonzero(boxes) >= SEVERAL)

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self._ground.forget(columns)


def is_rough(problem: Problem, boxes: FloatArray, given: Given) -> bool:
    """Whether the camera of a whole sequence of boxes [T, K, 3] is known only roughly."""
    if is_told(problem):
        return True
    looks = FirstLooks(problem)
    for t in range(len(boxes)):
        if looks.over:
            break
        if looks.look(boxes[t], given.frames(slice(max(0, t - 1), t + 1))):
            return True
    return False


def is_told(problem: Problem) -> bool:
    """Whether the problem says that tilt, mount or box sizes are not exact."""
    return problem.tilt_std > 0.0 or problem.mount_height_std > 0.0 or problem.box_std > 0.0


def is_contradicted(problem: Problem, boxes: FloatArray, given: Given) -> bool:
    """Whether feet are not where an exact camera on flat ground shows them, by the first boxes [T, K, 3] in px.

    Those of people whose places are ``given`` tell. Hidden feet and boxes that are wrong are few; a tilt moves all feet
    alike.
    """
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
