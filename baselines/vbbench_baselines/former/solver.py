"""``vb-former``: a network that learned view birdification on simulated crowds, frame by frame.

The network works relative to the last pose. This module composes poses in the world, in float64, and transforms what is
given there.
"""

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from vbbench.estimate import LARGEST
from vbbench.geometry import FloatArray, IntArray
from vbbench.sequence import Given, Odometry
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common import SIMULATED
from vbbench_baselines.common.bearings import usable
from vbbench_baselines.common.motion import SMALLEST, SURE
from vbbench_baselines.former.certainty import Certainty
from vbbench_baselines.former.inference import Weights, bundled_weights
from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.network import Answer, Birdifier
from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.pose_fit import Measured, Motion
from vbbench_baselines.former.scene import LocalGiven, Sights, sights_of
from vbbench_baselines.former.state import State, nothing_seen

FEWEST = 2
"""With fewer people who are seen, and expected somewhere, what is expected of the observer decides."""

DOUBTFUL = 1.0
"""In m; with a greater standard deviation of its place the pose may be far off."""

FASTEST = 60.0
"""In m/s; no observer moves faster."""

LONGEST_AWAY = 16.0
"""In s: as long as windows that were trained on; whoever is away for longer counts as away for so long."""

GIVEN = 1e-6
"""In m²: the variance of places that are given."""

TRUSTED = 10.0
"""Odometry that is sure counts as so many times its information: what is wrong with a box is so for several frames, and
the network, which learned without odometry, takes it for new in each."""

_STANDING = Motion(np.complex64(0.0), np.float32(0.0))


@dataclass(kw_only=True)
class VbFormer:
    """A learned solver: people and observer attend to one another, and the pose is fitted with the weights they choose.

    Parameters
    ----------
    weights : of the network, see `layers.shapes`; ``None`` for those that come with the package.
    heads : whether the fit includes the factor of an observer's head that follows its motion (`heads`).
    """

    facts: ClassVar[Mapping[str, str]] = SIMULATED

    weights: Weights | None = None
    heads: bool = True

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self._problem, self._people = problem, len(problem.tracks)
        weights = bundled_weights() if self.weights is None else self.weights
        self._network = Birdifier(Network(Operations(), weights), heads=self.heads)
        self._dt = problem.dt
        self._stature_spread = np.float32(problem.height_std / problem.height_mean)
        self._state, self._begun = _nothing_seen(self._people), False
        self._pose, self._certainty = np.zeros(3), Certainty(problem.dt)
        self._nowhere = np.zeros(self._people, np.complex64)

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        given = frame.given
        self._take_in_past(given)
        sights = sights_of(self._problem, usable(frame.observations))
        local = self._from_last_pose(given, sights)
        expected = np.count_nonzero((self._state.people.seen + local.placed) * sights.seen)
        answer = self._advance(sights, local)
        before, self._begun = self._pose, True
        self._pose = moved(before, answer.motion) if np.isnan(given.poses[2]).any() else np.array(given.poses[2])
        self._grow_unsure(before, answer, local, given.odometry)
        positions = in_world(self._pose, answer.places)
        placed = ~np.isnan(given.positions[2])
        positions = np.where(np.isnan(frame.observations[:, 2:]), np.nan, positions)
        positions = np.where(placed, given.positions[2], positions)
        covariances: dict[str, FloatArray] = {}
        if self._problem.covariances:
            everyone = self._certainty.of_places(self._pose, positions, sights.ray, answer.place_spread)
            everyone[local.placed > 0.5] = GIVEN * np.eye(2)
            everyone[sights.seen < 0.5] = np.nan
            covariances = {"pose_covariance": self._certainty.pose.copy(), "position_covariances": everyone}
        return FrameEstimate(
            pose=self._pose.copy(),
            positions=positions,
            fallback=bool(not local.moved and expected < FEWEST),
            converged=bool(self._certainty.pose[0, 0] + self._certainty.pose[1, 1] <= DOUBTFUL**2),
            heights=self._problem.height_mean * np.exp(self._state.people.offsets[:, 0].astype(np.float64)),
            **covariances,
        )

    def forget(self, columns: IntArray) -> None:
        """From the next frame on the ``columns`` [M] stand for new people, of whom nothing is known."""
        people, observer = self._state
        for values in people:
            values[columns] = 0.0
        people.away[columns] = observer.frames * self._dt
        self._state = _as_trained(self._state)

    def _take_in_past(self, given: Given) -> None:
        """Replace estimates of the two frames before by what is given of them."""
        before, last = given.poses[0], given.poses[1]
        if not self._begun or np.isnan(last).any():
            return
        self._pose = np.array(last)
        self._certainty.know()
        if np.isnan(before).any():
            return
        motion, back = motion_between(before, last), np.exp(np.complex64(-1j) * np.float32(last[2] - before[2]))
        people, own = self._state
        for row, place, exact in ((1, people.place, people.exact), (0, people.place_before, people.exact_before)):
            known = ~np.isnan(given.positions[row, :, 0])
            if known.any():
                place[known] = seen_from(last, given.positions[row])[known]
                exact[known] = 1.0
        step, turn = np.complex64(motion.step * back / self._dt), np.float32(motion.turn / self._dt)
        self._state = State(people, own._replace(step=step, turn=turn, given=np.float32(1.0)))

    def _from_last_pose(self, given: Given, sights: Sights) -> LocalGiven:
        """What is given of this frame, relative to the last pose; the first frame's pose is the world's origin."""
        pose = given.poses[2]
        unknown = bool(np.isnan(pose).any())
        if not self._begun:
            self._pose = self._pose if unknown else np.array(pose)
        there, fixed = ~np.isnan(given.positions[2, :, 0]), not (unknown and self._begun)
        return LocalGiven(
            places=seen_from(self._pose, given.positions[2]) if there.any() else self._nowhere,
            placed=there.astype(np.float32) * sights.seen,
            motion=_STANDING if unknown else motion_between(self._pose, pose),
            moved=np.float32(fixed),
            measured=None if fixed else measured_motion(given.odometry),
        )

    def _advance(self, sights: Sights, given: LocalGiven) -> Answer:
        """The network's answer; if that is not plausible, one with the pose unchanged and places by boxes alone."""
        with np.errstate(all="ignore"):
            state, answer = self._network.advance(
                self._state, sights, given, np.float32(self._dt), self._stature_spread
            )
        self._state = _as_trained(state)
        plausible = abs(answer.motion.step) <= FASTEST * self._dt and abs(answer.motion.turn) <= np.pi
        if plausible and all(np.isfinite(values).all() for values in answer[1:]):
            return answer
        self._state = _nothing_seen(self._people)
        places, unsure = sights.ray * np.exp(sights.by_height), np.full((self._people + 2, 2), np.inf)
        return Answer(given.motion, places, unsure.ravel()[:3], unsure[2:])

    def _grow_unsure(self, before: FloatArray, answer: Answer, given: LocalGiven, odometry: Odometry | None) -> None:
        """Propagate the covariance of the pose from the pose ``before`` [3]."""
        if given.placed.any():
            self._certainty.cold = False
        if given.moved:
            self._certainty.know()
            return
        motion, sure = None, False
        if given.measured is not None and odometry is not None:
            motion, sure = odometry.covariances[-1], bool(given.measured.sure)
        self._certainty.follow(before, self._pose, answer.pose_spread, motion, sure=sure)


def _nothing_seen(people: int) -> State:
    """The state of so many people before frame 0."""
    return nothing_seen(lambda *n: np.zeros(n, np.float32), lambda *n: np.zeros(n, np.complex64), people)


def _as_trained(state: State) -> State:
    """The state within the range of the training's windows: people who were never seen are at the observer."""
    people = state.people
    place = people.place * (people.seen > 0.5)
    return state._replace(people=people._replace(place=place, away=np.minimum(people.away, np.float32(LONGEST_AWAY))))


def seen_from(pose: FloatArray, positions: FloatArray) -> NDArray[np.complex64]:
    """Positions [..., 2] in the world as forward + i·left of a pose [3]; 0 for NaN."""
    apart = np.nan_to_num(positions) - pose[:2]
    turned: NDArray[np.complex128] = (apart[..., 0] + 1j * apart[..., 1]) * np.exp(-1j * pose[2])
    return np.where(np.isnan(positions[..., 0]), 0.0, turned).astype(np.complex64)


def in_world(pose: FloatArray, places: Array) -> FloatArray:
    """The inverse of `seen_from`: places [..., 2] in the world, clipped to the range of valid answers."""
    x, y, yaw = pose.tolist()
    points = complex(x, y) + places.astype(np.complex128) * cmath.rect(1.0, yaw)
    made: FloatArray = points[..., None].view(np.float64).clip(-LARGEST, LARGEST)
    return made


def motion_between(before: FloatArray, pose: FloatArray) -> Motion:
    """The motion from one pose [3] to another."""
    turn = math.remainder(pose[2] - before[2], math.tau)
    return Motion(seen_from(before, pose[:2])[()], np.float32(turn))


def moved(pose: FloatArray, motion: Motion) -> FloatArray:
    """The pose [3] after a motion; the yaw is within ±π."""
    x, y = in_world(pose, motion.step)
    return np.array((x, y, math.remainder(pose[2] + float(motion.turn), math.tau)))


def measured_motion(odometry: Odometry | None) -> Measured | None:
    """The motion into the newest frame by odometry; ``None`` without it."""
    if odometry is None or not np.isfinite(odometry.motions[-1]).all():
        return None
    variances = odometry.covariances[-1].diagonal() + SMALLEST**2
    if not np.isfinite(odometry.covariances[-1]).all():
        return None
    forward, left, turn = odometry.motions[-1].tolist()
    motion = Motion(np.complex64(complex(forward, left)), np.float32(math.remainder(turn, math.tau)))
    sure = bool(variances.max() < SURE**2)
    return Measured(motion, ((TRUSTED if sure else 1.0) / variances).astype(np.float32), np.float32(sure))
