"""``cv`` and ``sf``: baselines that extrapolate people and the observer; boxes only show who is present.

People without a known position are placed on the ray of their box at the mean height, as seen from the extrapolated
pose.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.geometry import IntArray, relative_to_world
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines._core import fit_pose, localise, measure
from vbbench_baselines.cascade import Factors
from vbbench_baselines.common import TUNED, UNTUNED
from vbbench_baselines.common.bearings import sight, usable
from vbbench_baselines.common.cold_start import PEOPLE_SPEED
from vbbench_baselines.common.drift import ACCELERATION, RUNNING, TURN, UNRELIABLE, Drift
from vbbench_baselines.common.motion import History, Spreads
from vbbench_baselines.motion_models import MotionModel, SocialForceWalk, StraightWalk, expect, kept_shares

EXACT = Spreads(motion=0.0, stay=0.0, estimate=0.0)
"""The expectation is the answer; its uncertainty does not matter."""


class ConstantVelocity:
    """x = 2x' − x''; people with one known past position stay there; the observer's yaw is held.

    After a cold start, boxes also give all velocities once: in the first frame in which a person is seen again.
    """

    facts: ClassVar[Mapping[str, str]] = UNTUNED

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self._problem = problem
        self._history, self._drift = History(len(problem.tracks)), Drift()
        self._exact = EXACT._replace(reach=RUNNING * problem.dt)

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        history, problem = self._history, self._problem
        history.advance(frame.given)
        history.seen = ~np.isnan(usable(frame.observations)[:, 2])
        if history.cold and not history.moving:
            return self._set_moving(frame)
        everyone = np.ones(len(frame.observations), np.bool_)
        expected, _, walk, _ = expect(self.model(), history, everyone, self._exact, problem.dt)
        pose = np.where(np.isnan(history.poses[2]), walk, history.poses[2])
        boxes = problem.camera.unproject(usable(frame.observations), np.full(len(everyone), problem.height_mean))
        positions = np.where(np.isnan(expected), relative_to_world(boxes, pose), expected)
        positions[np.isnan(frame.observations[:, 2])] = np.nan
        return history.store(walk, positions, converged=self._is_near())

    def _is_near(self) -> bool:
        """Whether the extrapolated pose is still reliable: its drift is below `UNRELIABLE`."""
        history, drift, dt = self._history, self._drift, self._problem.dt
        drift.advance(history, kept_shares(history, dt)[1], dt, measured=False)
        if not history.pose_given[2]:
            drift.add((ACCELERATION * dt**2) ** 2, TURN**2 * dt)
        return drift.std <= UNRELIABLE

    def forget(self, columns: IntArray) -> None:
        """From the next frame on the ``columns`` [M] stand for new people, of whom nothing is known."""
        self._history.forget(columns)

    def _set_moving(self, frame: Frame) -> FrameEstimate:
        """The pose and all places by the boxes of this frame and by people's places in the frame before."""
        history, problem = self._history, self._problem
        everyone = np.ones(len(frame.observations), np.bool_)
        seen = sight(problem.camera, usable(frame.observations), problem.pixel_std)
        height, variance = np.full((2, len(everyone)), ((problem.height_mean,), (problem.height_std**2,)))
        spreads = Spreads(motion=0.0, stay=PEOPLE_SPEED * problem.dt, estimate=0.0)
        expected = expect(self.model(), history, everyone, spreads, problem.dt)
        relative, covariance = measure(seen, height, variance)
        factors = Factors(relative, covariance, *expected)
        history.moving = not np.isnan(factors.std + factors.relative[:, 0]).all()
        pose = fit_pose(factors)
        return history.store(pose, localise(pose, factors), converged=self._is_near())

    def model(self) -> MotionModel:
        """How people walk."""
        return StraightWalk()


@dataclass(kw_only=True)
class SocialForce(ConstantVelocity):
    """Constant velocity, drawn towards the mean velocity w of the people nearby: v ← v + dt (w − v)/η.

    The alignment term of arXiv 2111.05060 (eq. 11) in seconds; the observer is a walker like the others.

    Parameters
    ----------
    relaxation : η in s.
    radius : distance in m within which people at t−1 walk together.
    """

    facts: ClassVar[Mapping[str, str]] = TUNED

    relaxation: float = 0.5
    radius: float = 1.0

    def model(self) -> MotionModel:
        """How people walk."""
        return SocialForceWalk(relaxation=self.relaxation, radius=self.radius, implicit=False)
