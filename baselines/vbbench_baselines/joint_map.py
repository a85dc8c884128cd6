"""``map-causal`` and ``map-batch``: maximum a posteriori estimates of all people and frames of a window, in C++.

One estimator (``baselines/cpp/estimator``) for known and uncertain calibrations, with odometry or without, at any frame
rate. docs/map-solver.md has its factors.
"""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from vbbench.estimate import Estimate
from vbbench.geometry import FloatArray, IntArray, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import CARRIERS, Carrier, Frame, FrameEstimate, Problem
from vbbench.solving.runner import given_at
from vbbench_baselines import _core
from vbbench_baselines.common import DEVELOPED
from vbbench_baselines.common.bearings import bearings_of, usable


class MapCausal:
    """Joint maximum a posteriori over a sliding window; each frame's answer uses the boxes up to it.

    Raises VbbenchError if no constant has such a name, or a number is not possible.

    Parameters
    ----------
    carried_by : what carries the camera; ``None`` for what the problem states.
    constants : numbers of ``constants.hpp``, or ``size`` (frames of the window), ``rounds`` (most steps of a solution),
        ``least`` (decrease of the cost in nats below which it stops).
    """

    facts: ClassVar[Mapping[str, str]] = DEVELOPED

    def __init__(self, carried_by: Carrier | None = None, **constants: float) -> None:
        self._core = _core.Estimator()
        self._carried_by = carried_by
        for name, value in constants.items():
            self._core.set(name.replace("__", "[") + "]" * ("__" in name), value)

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
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
        """See `vbbench.solver.FrameSolver.step`."""
        problem, people = self._problem, len(self._problem.tracks)
        seen = bearings_of(problem.camera, usable(frame.observations))
        odometry = frame.given.odometry
        pose, spread, places, spreads = _unknown(people)
        heights = np.full(people, problem.height_mean)
        converged = self._core.step(
            np.stack([seen.azimuth, seen.foot, seen.length, seen.size, seen.width], axis=-1),
            np.ascontiguousarray(seen.cut, np.int32),
            np.ascontiguousarray(frame.given.poses),
            np.ascontiguousarray(frame.given.positions),
            np.full(3, np.nan) if odometry is None else np.ascontiguousarray(odometry.motions[-1]),
            np.zeros((3, 3)) if odometry is None else np.ascontiguousarray(odometry.covariances[-1]),
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

    def ages(self) -> list[int]:
        """Frames of the window, counted from the start."""
        return self._core.ages()

    def smoothed(self, index: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Frame ``index`` of the window by all boxes so far.

        Returns
        -------
        pose [3], its covariance [3, 3], places [K, 2], and theirs [K, 2, 2]; NaN where nothing is known.
        """
        answer = _unknown(len(self._problem.tracks))
        self._core.smoothed(index, *answer)
        return answer

    def forget(self, columns: IntArray) -> None:
        """See `vbbench.solver.ForgettingSolver.forget`."""
        self._core.forget(np.ascontiguousarray(columns, np.int32))


class MapBatch:
    """A fixed-lag smoother: a frame's answer uses later boxes, up to the frame's departure from a longer window.

    Time is linear in frames. Frames between key frames receive the corrections of the nearest key frames. Parameters
    are those of `MapCausal`.
    """

    facts: ClassVar[Mapping[str, str]] = DEVELOPED
    LAG = 40
    """Frames of the window, unless ``size`` is another."""

    def __init__(self, carried_by: Carrier | None = None, **constants: float) -> None:
        constants = {"size": self.LAG, **constants}
        self._causal, self._size = MapCausal(carried_by, **constants), int(constants["size"])
        self._latest: tuple[Problem, FloatArray, FloatArray] | None = None

    def solve(self, problem: Problem, observations: FloatArray, given: Given) -> Estimate:
        """See `vbbench.solver.SequenceSolver.solve`."""
        if not np.isnan(given.poses[:-1]).any():
            return self._newest(problem, observations, given)
        self._latest = None
        self._causal.start(problem)
        answers: list[FrameEstimate] = []
        smooth: dict[int, tuple[FloatArray, ...]] = {}
        for t in range(len(observations)):
            answers.append(self._step(observations, given, t))
            ages = self._causal.ages()
            if len(ages) == self._size and ages[-1] == t:
                smooth[ages[0]] = self._causal.smoothed(0)
        for index, age in enumerate(self._causal.ages()):
            smooth[age] = self._causal.smoothed(index)
        return _corrected(Estimate.of_frames(answers), smooth)

    def _newest(self, problem: Problem, observations: FloatArray, given: Given) -> Estimate:
        """The causal answer of the last frame, used where all poses before it are given.

        If the sequence extends the one solved before by one frame, its solution is continued.
        """
        first = 0
        if self._latest is not None:
            known, seen, poses = self._latest
            longer = known is problem and len(observations) == len(seen) + 1
            same = longer and np.array_equal(observations[:-1], seen, equal_nan=True)
            first = len(seen) if same and np.array_equal(given.poses[: len(seen) - 1], poses[:-1]) else 0
        if first == 0:
            self._causal.start(problem)
        answers = [self._step(observations, given, t) for t in range(first, len(observations))]
        self._latest = problem, observations.copy(), given.poses.copy()
        return _after(Estimate.of_frames(answers[-1:]), given)

    def _step(self, observations: FloatArray, given: Given, t: int) -> FrameEstimate:
        return self._causal.step(Frame(index=t, observations=observations[t], given=given_at(given, t)))


def _unknown(people: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """A pose [3] and places [K, 2], each before its covariance, all NaN."""
    pose, places = np.full(3, np.nan), np.full((people, 2), np.nan)
    return pose, np.full((3, 3), np.nan), places, np.full((people, 2, 2), np.nan)


def _corrected(causal: Estimate, smooth: Mapping[int, tuple[FloatArray, ...]]) -> Estimate:
    """The ``causal`` estimate with ``smooth`` answers at key frames; frames between receive their corrections."""
    keys = np.array(sorted(smooth))
    poses, spreads, places, place_spreads = (np.stack(rows) for rows in zip(*(smooth[k] for k in keys), strict=True))
    moved = poses - causal.poses[keys]
    moved[:, 2] = wrap_angle(moved[:, 2])
    frames = np.arange(len(causal.poses))
    correction = np.stack([np.interp(frames, keys, column) for column in moved.T], axis=-1)
    found_poses = causal.poses + correction
    found_poses[:, 2] = wrap_angle(found_poses[:, 2])
    aside = places - causal.positions[keys]
    positions = causal.positions.copy()
    for k in range(positions.shape[1]):
        known = ~np.isnan(aside[:, k, 0])
        for axis in range(2):
            shift = np.interp(frames, keys[known], aside[known, k, axis]) if known.any() else correction[:, axis]
            positions[:, k, axis] += shift
    exact = ~np.isnan(places[..., 0])
    positions[keys] = np.where(exact[..., None], places, positions[keys])
    report: dict[str, Any] = {}
    if causal.pose_covariances is not None and causal.position_covariances is not None:
        pose_covariances, place_covariances = causal.pose_covariances.copy(), causal.position_covariances.copy()
        pose_covariances[keys] = spreads
        better = ~np.isnan(place_spreads[..., :1, :1])
        place_covariances[keys] = np.where(better, place_spreads, place_covariances[keys])
        report = {"pose_covariances": pose_covariances, "position_covariances": place_covariances}
    return Estimate(
        poses=found_poses, positions=positions, converged=causal.converged, heights=causal.heights, **report
    )


def _after(last: Estimate, given: Given) -> Estimate:
    """An estimate of all frames: what is given, then ``last`` as the last frame."""
    before, people, report = len(given.poses) - 1, last.positions.shape[1], dict[str, Any]()
    if last.pose_covariances is not None and last.position_covariances is not None:
        report = {
            "pose_covariances": np.concatenate([np.full((before, 3, 3), np.nan), last.pose_covariances]),
            "position_covariances": np.concatenate(
                [np.full((before, people, 2, 2), np.nan), last.position_covariances]
            ),
        }
    return Estimate(
        poses=np.concatenate([given.poses[:-1], last.poses]),
        positions=np.concatenate([given.positions[:-1], last.positions]),
        heights=last.heights,
        **report,
    )
