"""``ground-plane``: the simplest map, as an engineer would write it first, which every other solver has to beat.

A box gives the distance of a person of mean height (inverse perspective mapping). The pose comes from odometry where
there is any, else from the rigid fit of these places to where everybody is predicted. One Kalman filter a person, of
constant velocity, smooths the places.
"""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from vbbench import geometry
from vbbench.geometry import FloatArray, IntArray, relative_to_world, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common import UNTUNED
from vbbench_baselines.common.bearings import SMALLEST_BOX, usable
from vbbench_baselines.common.drift import UNRELIABLE

FLOOR = 0.03
"""In m: standard deviation of a place that no box improves on, since bodies sway."""
GIVEN = 0.01**2 * np.eye(3)
"""Covariance in m² and rad² of what is given."""
SPEED = 0.9
"""In m/s: standard deviation of a component of a new person's velocity, of 1.3 m/s in any direction."""
ACCELERATION = 1.0
"""In m²/s³: power density of a person's acceleration."""
COURSE = 0.5
MEMORY = 0.5
"""In m/s and rad/s, standard deviation of a camera's velocity about that before; in s, how long that is averaged."""


class GroundPlane:
    """The naive map: distance by box height, pose by odometry or a rigid fit, one Kalman filter a person."""

    facts: ClassVar[Mapping[str, str]] = UNTUNED

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self._problem, people, dt = problem, len(problem.tracks), problem.dt
        self._pose, self._velocity, self._doubt, self._blind = np.zeros(3), np.zeros(3), GIVEN, 0.0
        self._people, self._spread = np.full((people, 4), np.nan), np.zeros((people, 4, 4))
        self._move = np.eye(4) + dt * np.eye(4, k=2)
        noise = np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
        self._noise = ACCELERATION * np.kron(noise, np.eye(2))

    def forget(self, columns: IntArray) -> None:
        """See `vbbench.solver.ForgettingSolver.forget`."""
        self._people[columns] = np.nan

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        self._take_past(frame.given)
        self._people, self._spread = self._people @ self._move.T, self._move @ self._spread @ self._move.T + self._noise
        self._update(frame.given.positions[-1])
        relative, noise = self._measure(usable(frame.observations))
        self._move_camera(frame, relative, noise)
        axes = _axes(self._pose[2] - np.pi / 2.0)[:2, :2]
        self._update(relative_to_world(relative, self._pose), axes @ noise @ axes.T)
        levers = geometry.place_levers(self._people[:, :2], self._pose)
        return FrameEstimate(
            pose=self._pose.copy(),
            positions=np.where(np.isnan(frame.observations[:, 2:]), np.nan, self._people[:, :2]),
            converged=bool(np.trace(self._doubt[:2, :2]) <= UNRELIABLE**2),
            pose_covariance=self._doubt,
            position_covariances=self._spread[:, :2, :2] + geometry.covariance_along(levers, self._doubt),
        )

    def _take_past(self, given: Given) -> None:
        """Replace estimates of the frame before by what is given of it."""
        if not np.isnan(given.poses[-2, 0]):
            self._pose, self._doubt = given.poses[-2], GIVEN
        if not np.isnan(given.poses[-3:-1, 0]).any():
            self._velocity = _difference(given.poses[-2], given.poses[-3]) / self._problem.dt
        self._update(given.positions[-2])

    def _measure(self, boxes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places [K, 2] (right, forward) in m of boxes [K, 3], and their covariances [K, 2, 2]; NaN = none."""
        problem, boxes = self._problem, np.column_stack([boxes[:, :2], np.maximum(boxes[:, 2], SMALLEST_BOX)])
        places = problem.camera.unproject(boxes, np.full(len(boxes), problem.height_mean))
        border = (problem.pixel_std / boxes[:, 2]) ** 2 + problem.box_std**2
        across = problem.height_mean**2 * border + FLOOR**2
        along = (problem.height_std / problem.height_mean) ** 2 + 2.0 * border
        rays = places[:, :, None] * places[:, None, :]
        return places, across[:, None, None] * np.eye(2) + along[:, None, None] * rays

    def _move_camera(self, frame: Frame, relative: FloatArray, noise: FloatArray) -> None:
        """The new pose and its covariance: given, by odometry, or by a rigid fit to where people are predicted."""
        given, odometry, before, dt = frame.given, frame.given.odometry, self._pose, self._problem.dt
        if fixed := not np.isnan(given.poses[-1, 0]):
            self._pose, added = given.poses[-1], GIVEN
        elif odometry is not None and np.isfinite(odometry.motions[-1]).all():
            axes = _axes(before[2])
            self._pose = before + axes @ odometry.motions[-1]
            added = geometry.covariance_along(axes, odometry.covariances[-1])
        else:
            known = np.flatnonzero(~np.isnan(relative[:, 0] + self._people[:, 0]))
            fixed = bool((~np.isnan(given.positions[-1, known, 0])).sum() >= 2)
            course = COURSE**2 * dt * (dt + 2.0 * self._blind)
            self._blind = self._blind + dt if len(known) < 2 else 0.0
            prior = before + dt * self._velocity, 1.0 / (course + fixed * np.trace(self._doubt) / 2.0)
            spread = np.trace(self._spread[known, :2, :2] + noise[known], axis1=1, axis2=2)
            self._pose, added = rigid_fit(relative[known], self._people[known, :2], 2.0 / spread, prior)
        if frame.index > 0 and not fixed:  # what is given corrects a path and shows no speed
            self._velocity += min(1.0, dt / MEMORY) * (_difference(self._pose, before) / dt - self._velocity)
        levers = geometry.pose_levers(self._pose, before)
        self._doubt = added if fixed else added + geometry.covariance_along(levers, self._doubt)

    def _update(self, places: FloatArray, noise: FloatArray = GIVEN[:2, :2]) -> None:
        """Update the Kalman filters with measured ``places`` [K, 2], NaN = none; new people start there."""
        noise, unknown = np.broadcast_to(noise, (len(places), 2, 2)), np.isnan(self._people[:, 0])
        new, old = (np.flatnonzero(~np.isnan(places[:, 0]) & some) for some in (unknown, ~unknown))
        self._people[new] = np.pad(places[new], ((0, 0), (0, 2)))
        self._spread[new] = np.pad(noise[new], ((0, 0), (0, 2), (0, 2))) + SPEED**2 * np.diag([0.0, 0.0, 1.0, 1.0])
        spread = self._spread[old]
        gain = spread[:, :, :2] @ np.linalg.inv(spread[:, :2, :2] + noise[old])
        self._people[old] += (gain @ (places[old] - self._people[old, :2])[..., None])[..., 0]
        self._spread[old] = spread - gain @ spread[:, :2]


def rigid_fit(
    relative: FloatArray, places: FloatArray, weights: FloatArray, prior: tuple[FloatArray, float]
) -> tuple[FloatArray, FloatArray]:
    """The pose [3], and its covariance, that brings ``relative`` [N, 2] to ``places`` [N, 2] by weighted least squares.

    The ``prior``, an expected pose and its weight, counts as two more places, 1 m to the left and right of it.
    """
    sides = np.array([[-1.0, 0.0], [1.0, 0.0]])
    there = relative_to_world(np.concatenate([relative, sides]), np.zeros(3))
    places = np.concatenate([places, relative_to_world(sides, prior[0])])
    weights = np.append(weights, 0.5 * prior[1] * np.ones(2))
    share = weights / weights.sum()
    centre, target = share @ there, share @ places
    a, b = there - centre, places - target
    yaw = np.arctan2(share @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), share @ (a * b).sum(axis=1))
    pose = np.array([*target, yaw]) - _axes(yaw) @ [*centre, 0.0]
    levers = geometry.place_levers(places, pose)
    return pose, np.linalg.inv(np.einsum("n,nij,nik->jk", weights, levers, levers))


def _difference(after: FloatArray, before: FloatArray) -> FloatArray:
    """The difference [3] of two poses, with the angle wrapped."""
    return np.array([*(after - before)[:2], wrap_angle(after[2] - before[2])])


def _axes(yaw: float) -> FloatArray:
    """The rotation [3, 3] of (forward, left, turn) of a camera with this ``yaw`` into (x, y, yaw)."""
    sin, cos = np.sin(yaw), np.cos(yaw)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
