"""The joint problem of a real camera, solved over a window anew with every frame; only the newest is reported."""

import math
from typing import Any

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, wrap_angle
from vbbench.kernels import kernel
from vbbench.sequence import Given
from vbbench.solver import FrameEstimate, Problem
from vbbench_baselines.common.cold_start import add_drift as add_common_drift
from vbbench_baselines.common.cold_start import begins_cold
from vbbench_baselines.joint_map.motion.walks import innovation
from vbbench_baselines.joint_map.real_camera.bearings import bearings_of
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, residuals_of
from vbbench_baselines.joint_map.real_camera.joint import SOFTEST, Model, Point, Seen, Settled, linearise, settle
from vbbench_baselines.joint_map.real_camera.noise import SIGMAS, TAUS, NoiseLearner, densities
from vbbench_baselines.joint_map.real_camera.observer import LAWS, VEHICLE, normaliser, step_of, surprises
from vbbench_baselines.joint_map.real_camera.recovery import place_covariance
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.window import NOBODY, Window

ROUNDS, TOLERANCE = 8, 1e-3
"""Of a frame's descent: most rounds, and the step in m and rad that is short enough."""

LATE = 2
"""Frames after which a residual teaches the noise: by then later frames have told where the box should be."""

COLD_SPEEDS = (0.0, 1.5, 5.0, 10.0)
"""In m/s forward: starts of the first frames after a cold start."""

COLD_FRAMES = 5

MOST_JUMPS = 0.34
"""The share of people in view who may be somebody else at once."""

LEAST = 1e-12
"""In m² and rad²; no variance is told to be less."""

JUMP, FASTEST = 100.0, 6.0
"""A track begins anew where column and walk are so many squared standard deviations off, or at so many m/s."""


class Tracking:
    """A solver of frames over a window.

    Parameters
    ----------
    settings : the constants.
    problem : tells camera, frame rate, and the prior of heights.
    """

    def __init__(self, settings: Settings, problem: Problem) -> None:
        self._settings, self._problem = settings, problem
        self._cold, self.age, self._astray = False, 0, 0.0
        self._odds = np.zeros(LAWS)
        self.jumped: list[int] = []
        first = settings.noise_at_first(problem)
        self.learner = NoiseLearner(first, settings.noise_spread, settings.noise_staying)
        self._people, self._drift = settings.people(problem), settings.drift(problem)
        self._dress(cold=False)
        self.rows = Window(settings.window, len(problem.tracks), self._people.mean, self._walk.sigma**2)
        self._shares = np.exp(self._observer.odds)

    def _dress(self, cold: bool) -> None:
        dt = self._problem.dt
        self._walk, self._observer = self._settings.walk(dt, cold), self._settings.observer(dt, cold)
        self._normalisers = np.array([normaliser(nu) for nu in self._settings.vehicle_nu])

    @property
    def model(self) -> Model:
        """What is believed now."""
        return Model(
            self.learner.noise,
            self._people,
            self._walk,
            self._observer,
            self._normalisers,
            self._drift,
            self._odds,
            self._problem.dt,
        )

    def step(self, boxes: FloatArray, given: Given) -> FrameEstimate:
        """The answer for the next frame, from its boxes [K, 3] in px and what is given of it and the two before."""
        rows = self.rows
        if begins_cold(given, self.age):
            self._cold = True
            self._dress(cold=True)
        if len(rows.frames) == rows.size and self._nothing_given(2):
            self._odds += surprises(rows.frames, 2, self._observer, self._normalisers) * -1.0
            self._odds -= self._odds.max()
        rows.leave()
        rows.push(bearings_of(self._problem.camera, boxes), given, self._expected())
        self.age += 1
        if self.age > 1 and (given.odometry is None or np.isnan(given.odometry.motions[-1, 0])):
            self._astray += self._problem.dt
        settled, seen, columns = self._settle()
        self.jumped = self._jumps(settled, seen, columns)
        if self.jumped:
            rows.begin_anew(self.jumped)
            settled, seen, columns = self._settle()
        self._learn(settled, seen)
        return self._answer(settled, seen, columns)

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
            if self._shares[VEHICLE] > 0.5:
                start[2] += last.turned
                heading = frames[-1, 2] + 0.5 * last.turned
                sin, cos = math.sin(heading), math.cos(heading)
                start[:2] += (cos * last.forward + sin * last.right, sin * last.forward - cos * last.right)
            else:
                start[:2] += frames[-1, :2] - frames[-2, :2]
        return start

    def _settle(self) -> tuple[Settled, Seen, IntArray]:
        """Solve the window; what is found is kept in its rows."""
        rows, columns = self.rows, self.rows.present()
        full = len(rows.frames) == rows.size and self.age > rows.size
        seen = rows.seen(columns, np.arange(2 if full else 0))
        starts = [rows.frames]
        if self._cold and 1 < self.age <= COLD_FRAMES:
            starts += [self._at_speed(speed) for speed in COLD_SPEEDS]
        ends = [self._settle_from(frames, seen, columns) for frames in starts]
        best = min(ends, key=lambda settled: settled.deviance)
        rows.frames = best.point.frames
        rows.places[:, columns] = best.point.places
        rows.numbers[columns], rows.variances[columns] = best.point.people, best.point.variances
        self._shares = best.shares
        return best, seen, columns

    def _settle_from(self, frames: FloatArray, seen: Seen, columns: IntArray) -> Settled:
        """Descend from ``frames`` [n, 7] and the places that are known."""
        rows = self.rows
        places = rows.places.take(columns, axis=1)
        fill(places, frames, seen, rows.numbers[columns])
        point = Point(frames.copy(), places, rows.numbers[columns], rows.variances[columns])
        return settle(point, seen, self.model, ROUNDS, TOLERANCE)

    def _at_speed(self, speed: float) -> FloatArray:
        """The frames as of an observer who goes straight ahead at ``speed`` m/s from the first on."""
        frames = self.rows.frames.copy()
        yaw = frames[0, 2]
        along = np.arange(len(frames)) * speed * self._problem.dt
        frames[:, 0], frames[:, 1] = frames[0, 0] + along * math.cos(yaw), frames[0, 1] + along * math.sin(yaw)
        frames[:, 2] = yaw
        return frames

    def _jumps(self, settled: Settled, seen: Seen, columns: IntArray) -> list[int]:
        """Tracks whose newest box shows somebody else."""
        jumped: list[int] = []
        off = jumps(settled.point, seen, self.model)
        if np.count_nonzero(off) > MOST_JUMPS * np.count_nonzero(~np.isnan(seen.boxes.azimuth[-1])):
            return []  # it is the pose that is wrong
        for column in columns[off]:
            jumped += np.flatnonzero(self.rows.column == column).tolist()
        return jumped

    def _learn(self, settled: Settled, seen: Seen) -> None:
        told = residual_densities(settled.point, seen, self.model, len(self.rows.frames) - 1 - LATE)
        self.learner.learn(told)

    def _answer(self, settled: Settled, seen: Seen, columns: IntArray) -> FrameEstimate:
        rows = self.rows
        pose = rows.frames[-1, :3].copy()
        pose[2] = wrap_angle(pose[2])
        here = (rows.column != NOBODY) & ~np.isnan(self._newest(rows.boxes.azimuth))
        places = np.full((len(rows.column), 2), np.nan)
        places[here] = rows.places[-1, rows.column[here]]
        report: dict[str, Any] = {}
        if self._problem.covariances:
            report = self._covariances(settled, seen, columns, here)
        known = rows.column != NOBODY
        heights: FloatArray = np.full(len(known), self._problem.height_mean)
        heights[known] = np.exp(rows.numbers[rows.column[known], 0])
        return FrameEstimate(pose=pose, positions=places, converged=settled.converged, heights=heights, **report)

    def add_drift(self, poses: FloatArray, places: FloatArray) -> None:
        """Add to covariances what a cold start leaves open, up to the newest frame."""
        if self._cold:
            add_common_drift(poses, places, np.array(self._astray))

    def _newest(self, rows: FloatArray) -> FloatArray:
        """[K] the newest row by track, NaN for those who are nowhere."""
        column = self.rows.column
        newest: FloatArray = np.append(rows[-1], np.nan)[column]  # nobody is the last
        return newest

    def _covariances(self, settled: Settled, seen: Seen, columns: IntArray, here: FloatArray) -> dict[str, Any]:
        pose, some = (rows[0] for rows in covariances_of(settled.point, seen, self.model, len(self.rows.frames) - 1))
        everyone = np.full((len(self.rows.column), 2, 2), np.nan)
        order = {int(column): i for i, column in enumerate(columns)}
        for track in np.flatnonzero(here):
            everyone[track] = some[order[int(self.rows.column[track])]]
        self.add_drift(pose, everyone)
        return {"pose_covariance": pose, "position_covariances": everyone}


@kernel
def fill(places: FloatArray, frames: FloatArray, seen: Seen, numbers: FloatArray) -> None:
    """Where people may be whose places [T, K, 2] are not known yet: as they walked, or as high as their box says."""
    boxes = seen.boxes
    for k in range(places.shape[1]):
        known = -1
        for t in range(seen.first[k], seen.last[k] + 1):
            if np.isnan(places[t, k, 0]):
                if not np.isnan(seen.given[t, k, 0]):
                    places[t, k] = seen.given[t, k]
                elif t - 2 >= seen.first[k] and not np.isnan(places[t - 1, k, 0] + places[t - 2, k, 0]):
                    places[t, k] = 2.0 * places[t - 1, k] - places[t - 2, k]
                elif not np.isnan(boxes.azimuth[t, k]):
                    reach = np.exp(numbers[k, 0]) / boxes.length[t, k] + numbers[k, 1]
                    side, ahead = reach * np.sin(boxes.azimuth[t, k]), reach * np.cos(boxes.azimuth[t, k])
                    sin, cos = np.sin(frames[t, 2]), np.cos(frames[t, 2])
                    places[t, k, 0] = frames[t, 0] + side * sin + ahead * cos
                    places[t, k, 1] = frames[t, 1] - side * cos + ahead * sin
            if not np.isnan(places[t, k, 0]):
                for missing in range(known + 1, t if known >= 0 else known + 1):
                    share = (missing - known) / (t - known)
                    places[missing, k] = (1.0 - share) * places[known, k] + share * places[t, k]
                known = t


@kernel
def jumps(point: Point, seen: Seen, model: Model) -> BoolArray:
    """[K] whose newest box shows somebody else than those before."""
    jumped, last = np.zeros(len(seen.first), np.bool_), len(point.frames) - 1
    for k in range(len(jumped)):
        first = int(seen.first[k])
        if int(seen.last[k]) != last or first == last:
            continue
        track, before = point.places[first:, k].copy(), last - 1
        while before > first and np.isnan(seen.boxes.azimuth[before, k] + seen.given[before, k, 0]):
            before -= 1
        moved = track[-1] - track[before - first]
        told = not np.isnan(seen.given[last, k, 0] + seen.given[before, k, 0])
        if told and np.sqrt(moved[0] ** 2 + moved[1] ** 2) > FASTEST * model.dt * (last - before):
            jumped[k] = True
        elif len(track) > 2 and seen.boxes.cut[last, k] == 0 and not np.isnan(seen.boxes.azimuth[last, k]):
            found = residuals_of(k, first, seen.boxes, point.frames, track, point.people[k], model.noise)
            off = found.value[-1, 0] ** 2 + innovation(track, len(track) - 1, model.walk) / point.variances[k]
            jumped[k] = off > JUMP
    return jumped


@kernel
def residual_densities(point: Point, seen: Seen, model: Model, t: int) -> FloatArray:
    """The log densities of what the boxes of frame ``t`` add, see `noise.densities`."""
    told = np.zeros((CUES, len(SIGMAS), len(TAUS)))
    for k in range(len(seen.first)):
        first, last = int(seen.first[k]), int(seen.last[k])
        if t < 0 or not first <= t <= last or np.isnan(seen.boxes.azimuth[t, k]):
            continue
        track = point.places[first : last + 1, k].copy()
        found = residuals_of(k, first, seen.boxes, point.frames, track, point.people[k], model.noise)
        sizes = seen.boxes.size[first:, k][found.frame]
        for i in range(len(found.frame)):
            if first + found.frame[i] == t:
                densities(found, sizes, i, model.noise.nu, model.dt, told)
    return told


@kernel
def covariances_of(point: Point, seen: Seen, model: Model, since: int) -> tuple[FloatArray, FloatArray]:
    """[n, 3, 3] of the poses and [n, K, 2, 2] of the places of the frames from ``since`` on, NaN where no box is."""
    system = linearise(point, seen, model, 0.0)
    frames = len(point.frames)
    matrix = system.hessian
    for p in range(len(matrix)):
        matrix[p, p] += SOFTEST
        matrix[p, p + 1 :] = matrix[p + 1 :, p]
    covariance = np.ascontiguousarray(np.linalg.inv(matrix))
    for t in range(frames):
        if seen.fixed[t]:
            covariance[FRAME * t : FRAME * t + 3] = 0.0
            covariance[:, FRAME * t : FRAME * t + 3] = 0.0
    poses, places = np.empty((frames - since, 3, 3)), np.full((frames - since, len(seen.first), 2, 2), np.nan)
    for t in range(since, frames):
        poses[t - since] = covariance[FRAME * t : FRAME * t + 3, FRAME * t : FRAME * t + 3] + LEAST * np.eye(3)
        for person in system.people:
            k = person.number
            if person.first <= t <= int(seen.last[k]) and not np.isnan(seen.boxes.azimuth[t, k]):
                places[t - since, k] = place_covariance(person, t - person.first, covariance)
    return poses, places
