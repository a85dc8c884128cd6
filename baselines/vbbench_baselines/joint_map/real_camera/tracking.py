"""The joint problem of a real camera, solved over a window anew with every frame; only the newest is reported."""

import math
from typing import Any

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, relative_to_world, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import FrameEstimate, Problem
from vbbench_baselines.common.bearings import Bearings, bearings_of
from vbbench_baselines.common.cold_start import Astray, begins_cold, drift_variance
from vbbench_baselines.common.cold_start import add_drift as add_common_drift
from vbbench_baselines.common.drift import RUNNING
from vbbench_baselines.joint_map.flow import Flow
from vbbench_baselines.joint_map.lost import PATIENCE, beyond_patience, seconds_after
from vbbench_baselines.joint_map.real_camera.alone import places_alone
from vbbench_baselines.joint_map.real_camera.arrivals import UncertainPose, corrected
from vbbench_baselines.joint_map.real_camera.behind import add_behind, carried
from vbbench_baselines.joint_map.real_camera.certainty import HELD
from vbbench_baselines.joint_map.real_camera.cues import PITCH
from vbbench_baselines.joint_map.real_camera.descent import Settled, settle
from vbbench_baselines.joint_map.real_camera.gaps import fill
from vbbench_baselines.joint_map.real_camera.hands import Hands
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen, let_first_go
from vbbench_baselines.joint_map.real_camera.newest import Start, solve_newest
from vbbench_baselines.joint_map.real_camera.noise import residual_densities
from vbbench_baselines.joint_map.real_camera.observer import LAWS, VEHICLE, step_of, surprise
from vbbench_baselines.joint_map.real_camera.past import turn
from vbbench_baselines.joint_map.real_camera.relocation import Relocation, relocate
from vbbench_baselines.joint_map.real_camera.rest import Rest
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.shares import Shares
from vbbench_baselines.joint_map.real_camera.sitting import seated
from vbbench_baselines.joint_map.real_camera.window import NOBODY, Window

LATE = 2
"""Frames after which a residual teaches the noise: by then later frames have told where the box should be."""

COLD_SPEEDS = (0.0, 1.5, 5.0, 10.0)
"""In m/s forward: starts of the first frames after a cold start."""

COLD_FRAMES = 5

CARRIED = 2.0
"""What is unknown of the camera is known of a frame that is left to so many of its steps."""

TURNED = 0.02
"""In rad after a second, growing as its root: how far all may seem to turn together after a cold start; people who walk
to one side look like a camera that turns to the other. Places are far less sure by how far all drift."""


class Tracking:
    """A solver of frames over a window.

    Parameters
    ----------
    settings : the constants.
    problem : tells camera, frame rate, and the prior of heights.

    Attributes
    ----------
    rows : the window.
    learner : of the boxes' noise.
    age : frames that came.
    bearings : what the newest boxes tell.
    shares : what the steps in the window tell of the laws.
    rest : whether a camera that is taken to stand may have set off.
    """

    def __init__(self, settings: Settings, problem: Problem) -> None:
        self._settings, self._problem = settings, problem
        self._cold, self.age, self._astray, self._lost = False, 0, Astray(), 0.0
        self._odds = np.zeros(LAWS)
        self.bearings: Bearings
        self._hands = Hands(len(problem.tracks))
        self.learner = settings.noise_learner(problem)
        self._people, self._drift = settings.people(problem), settings.drift(problem)
        self._dress(cold=False)
        self.rows = Window(settings.window, len(problem.tracks), self._people.mean, self._walk.sigma**2)
        self.shares = Shares(np.exp(self._observer.odds), np.zeros(0), 0.0)
        self._behind, self._early, self._newest = np.zeros((3, 3, 3))
        self.rest = Rest()
        self._flow = Flow(problem.dt, drives=True)

    def _dress(self, cold: bool) -> None:
        self._walk = self._settings.walk(self._problem.dt, cold)
        self._observer = self._settings.observer(self._problem.dt, self._walk, cold)

    @property
    def model(self) -> Model:
        """What is believed now."""
        problem = self._problem
        camera = self._walk, self._observer, self._drift, self._odds
        return Model(self.learner.noise, self._people, *camera, problem.dt, self._cold)

    def step(self, boxes: FloatArray, given: Given) -> FrameEstimate:
        """The answer for the next frame, from its boxes [K, 3] in px and what is given of it and the two before."""
        rows = self.rows
        if begins_cold(given, self.age):
            self._cold = True
            self._dress(cold=True)
        if len(rows.frames) == rows.size and self._nothing_given(2):
            told = np.zeros(LAWS)
            surprise(rows.frames, 2, self._observer, told)
            self._odds -= told
            self._odds -= self._odds.max()
        if len(rows.frames) == rows.size:
            self._let_go()
        rows.leave()
        rows.forget(np.flatnonzero(self._leaping(given.positions)))
        self.bearings = bearings_of(self._problem.camera, boxes)
        rows.push(self.bearings, given, self._expected())
        self.age += 1
        passed = self._problem.dt if self.age > 1 and np.isnan(rows.motions[-1, 0]) else 0.0
        self._astray.wait(passed)
        shown, placed = ~np.isnan(rows.boxes.azimuth), ~np.isnan(rows.given[..., 0])
        self._lost = seconds_after(self._lost, shown[-1], placed, not self._nothing_given(-1), passed)
        elsewhere = self._relocation()
        if elsewhere is None and self._held and self._nothing_given(-1):
            self._correct()
        before = rows.places.copy(), rows.numbers.copy(), rows.variances.copy()
        point, seen, columns, elsewhere = self._begin(elsewhere)
        if elsewhere is not None:
            before = elsewhere.moved(before[0]), *before[1:]
        changed = self._hands.changes(rows, self.model, Point(rows.frames, *before), point, seen, columns)
        if changed:
            rows.reseat(changed)
            _, seen, columns, _ = self._begin(self._relocation())
        settled = self._settle(seen, columns)
        self.learner.learn(residual_densities(settled.point, seen, self.model, len(rows.frames) - 1 - LATE))
        self._follow_flow()
        return self._answer(settled, columns)

    def _follow_flow(self) -> None:
        """After a cold start, move all to where people's pace says, unless anything else has told how fast all move."""
        rows = self.rows
        if self._cold and self._flow.is_needed(rows.given_poses, rows.given, rows.motions):
            moved = self._flow.follow(rows.frames, rows.places, ~np.isnan(rows.boxes.azimuth))
            if moved is not None:
                rows.move(moved)

    def _let_go(self) -> None:
        """Carry on what the oldest frame tells of people and of the camera, which the window loses."""
        rows = self.rows
        seen, columns = rows.seen(held=self._held)
        if self._nothing_given(HELD):
            steps = rows.frames[HELD - 1], rows.frames[HELD], self._early
            self._behind = carried(self._behind, *steps, measured=not seen.free[HELD])
        else:
            self._behind = np.zeros((3, 3))
        self._drift = self._drift._replace(mean=rows.frames[1, PITCH:].copy(), std=CARRIED * self._drift.step)
        let_first_go(self._point(rows.frames, seen, columns), seen, self.model, 0)
        rows.carry_on(seen, columns)

    def _leaping(self, places: FloatArray) -> BoolArray:
        """[K] whose newest given places [n, K, 2] are of somebody else than those before, since nobody is so fast."""
        step = np.diff(places[-2:], axis=0)
        return np.asarray((np.hypot(step[..., 0], step[..., 1]) > RUNNING * self._problem.dt).any(axis=0))

    def forget(self, columns: IntArray) -> None:
        """From the next frame on the ``columns`` [M] stand for new people."""
        self.rows.forget(columns)

    def _nothing_given(self, row: int) -> bool:
        return bool(np.isnan(self.rows.given_poses[row, 0]))

    def _expected(self) -> FloatArray:
        """The next frame [7], before anything of it is seen."""
        frames = self.rows.frames
        if len(frames) == 0:
            origin: FloatArray = np.concatenate((np.zeros(3), self._drift.mean))
            return origin
        start: FloatArray = frames[-1].copy()
        if len(frames) > 1:
            last = step_of(frames[-2], frames[-1])
            if self.shares.laws[VEHICLE] > 0.5:
                start[2] += last.turned
                heading = frames[-1, 2] + 0.5 * last.turned
                sin, cos = math.sin(heading), math.cos(heading)
                start[:2] += (cos * last.forward + sin * last.right, sin * last.forward - cos * last.right)
            else:
                start[:2] += frames[-1, :2] - frames[-2, :2]
        return start

    def _correct(self) -> None:
        """Move all that is believed by what people who have just arrived tell of the pose that is held."""
        rows = self.rows
        held = UncertainPose(rows.frames[HELD - 1, :3].copy(), self._behind)
        newest = UncertainPose(rows.frames[-1, :3], self._newest)
        found = corrected(held, newest, rows.given, rows.boxes, self._people.mean)
        if found is not None:
            rows.move_as_one(held.pose, found.pose)
            self._behind = found.covariance

    def _relocation(self) -> Relocation | None:
        rows = self.rows
        return relocate(rows.frames, rows.given, rows.boxes, np.isnan(rows.given_poses[:, 0]), self._people.mean)

    def _begin(self, elsewhere: Relocation | None) -> tuple[Point, Seen, IntArray, Relocation | None]:
        """Solve the newest frames; what is found is kept in the window's rows.

        It is tried that the camera is ``elsewhere``; the last is set if all has moved.
        """
        rows = self.rows
        seen, columns = rows.seen(held=self._held)
        starts = [Start(self._point(rows.frames, seen, columns))]
        if self._cold and 1 < self.age <= COLD_FRAMES:
            starts += [Start(self._point(self._at_speed(speed), seen, columns)) for speed in COLD_SPEEDS]
        starts += seated(starts[0].point, seen, self._people.mean[0])
        if elsewhere is not None:
            starts += elsewhere.starts(starts[0].point, seen.given)
        found, chosen = solve_newest(starts, seen, self.model, self.rest if self.age > 2 else None)
        self._keep(found, columns)
        if elsewhere is None or chosen < len(starts) - 1:
            return found, seen, columns, None
        if elsewhere.since == 0:
            turn(rows.past, elsewhere.believed, elsewhere.pose)
            self._behind = elsewhere.covariance
        return found, seen, columns, elsewhere

    def _settle(self, seen: Seen, columns: IntArray) -> Settled:
        """A round over the window; what is found is kept in its rows. With covariances of the newest frame."""
        size = len(self.rows.frames)
        point, people = self._point(self.rows.frames, seen, columns), self._problem.covariances
        settled = settle(point, seen, self.model, 1, size - 1, people)
        self._keep(settled.point, columns)
        self.shares, self._early = settled.shares, settled.early
        self._newest = settled.pose_covariances[0].copy()
        self.rows.told[:, columns] = settled.told
        return settled

    @property
    def _held(self) -> int:
        return HELD if self.age > self.rows.size else 0

    def _point(self, frames: FloatArray, seen: Seen, columns: IntArray) -> Point:
        """``frames`` [n, 7] with what is known or guessed of people."""
        rows = self.rows
        places = rows.places.take(columns, axis=1)
        fill(places, frames, seen, rows.numbers[columns])
        return Point(frames.copy(), places, rows.numbers[columns], rows.variances[columns])

    def _keep(self, point: Point, columns: IntArray) -> None:
        rows = self.rows
        rows.frames[:] = point.frames
        rows.places[:, columns] = point.places
        rows.numbers[columns], rows.variances[columns] = point.people, point.variances

    def _at_speed(self, speed: float) -> FloatArray:
        """The frames as of an observer who goes straight ahead at ``speed`` m/s from the first on."""
        frames: FloatArray = self.rows.frames.copy()
        yaw = frames[0, 2]
        along = np.arange(len(frames)) * speed * self._problem.dt
        frames[:, 0], frames[:, 1] = frames[0, 0] + along * math.cos(yaw), frames[0, 1] + along * math.sin(yaw)
        frames[:, 2] = yaw
        return frames

    def _answer(self, settled: Settled, columns: IntArray) -> FrameEstimate:
        """What is reported of the newest frame, of whose people the ``columns`` are."""
        rows, column = self.rows, self.rows.column
        pose = rows.frames[-1, :3].copy()
        pose[2] = wrap_angle(pose[2])
        known = np.flatnonzero(column != NOBODY)
        heights: FloatArray = np.full(len(column), self._problem.height_mean)
        heights[known] = np.exp(rows.numbers[column[known], 0])
        here = known[~np.isnan(rows.boxes.azimuth[-1, column[known]])]
        places = np.full((len(column), 2), np.nan)
        places[here] = rows.places[-1, column[here]]
        report: dict[str, Any] = {}
        if self._problem.covariances:
            spread, everyone = settled.pose_covariances[0], np.full((len(column), 2, 2), np.nan)
            everyone[here] = settled.place_covariances[0, np.searchsorted(columns, column[here])]
            everyone[here] += self._hands.doubts[here, None, None] * self._apart(here)
            newest = rows.frames[-1:], places[None], spread[None], everyone[None]
            add_behind(self.rest.doubt, rows.frames[-1], *newest)
            if self._held:
                add_behind(self._behind, rows.frames[HELD - 1], *newest)
            astray = self._astray
            self.add_drift(spread, everyone, *map(np.array, (astray.variance, astray.seconds, self._lost)))
            report = {"pose_covariance": spread, "position_covariances": everyone}
        converged = settled.converged and self._lost <= PATIENCE
        return FrameEstimate(pose=pose, positions=places, converged=converged, heights=heights, **report)

    def add_drift(
        self, poses: FloatArray, places: FloatArray, astray: FloatArray, unmeasured: FloatArray, lost: FloatArray
    ) -> None:
        """Add what being ``lost`` [...] s leaves, or a cold start, ``astray`` [...] m² in ``unmeasured`` [...] s."""
        add_common_drift(poses, places, astray if self._cold else drift_variance(beyond_patience(lost)))
        if self._cold:
            poses[..., 2, 2] += TURNED**2 * unmeasured

    def _apart(self, tracks: IntArray) -> FloatArray:
        """[M, 2, 2] in m², how far ``tracks`` are from where their newest boxes alone would have them, squared."""
        rows, mean = self.rows, self._people.mean
        columns = rows.column[tracks]
        shown = places_alone(rows.boxes.azimuth[-1, columns], rows.boxes.length[-1, columns], mean)
        off = relative_to_world(shown, rows.frames[-1]) - rows.places[-1, columns]
        return np.asarray(off[:, :, None] * off[:, None, :])
