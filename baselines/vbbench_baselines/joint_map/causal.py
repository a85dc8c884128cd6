"""``map-causal``: the joint problem over a sliding window, solved in each frame; only the newest is reported."""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import START_FRAMES
from vbbench.sequence import Given
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common.cold_start import Astray, add_drift, begins_cold, drift_variance
from vbbench_baselines.common.facts import FITTED
from vbbench_baselines.common.odometry import Motions, motions_of
from vbbench_baselines.common.sightings import Sightings, usable
from vbbench_baselines.common.uncertainty import linearise_people, position_covariances
from vbbench_baselines.joint_map.crowd import Crowd, asks
from vbbench_baselines.joint_map.flow import Flow
from vbbench_baselines.joint_map.lost import FOUND, PATIENCE, seconds_after
from vbbench_baselines.joint_map.measurement.boxes import BoxHeights, Eye, GroundCheck, Statures, statures_of
from vbbench_baselines.joint_map.measurement.window import Window, chosen, nothing_continued
from vbbench_baselines.joint_map.motion.learning import forget, nothing_learned, only
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, let_stand, walk_of
from vbbench_baselines.joint_map.one_step import PAST, Located, locate
from vbbench_baselines.joint_map.optimiser.covariance import block_of, place_covariances, pose_covariance_of
from vbbench_baselines.joint_map.optimiser.descent import Settled, settle
from vbbench_baselines.joint_map.optimiser.marginalisation import (
    NOTHING_KEPT,
    anchor_of,
    keep,
    marginalise,
    move_kept,
    only_those,
)
from vbbench_baselines.joint_map.optimiser.state import JointProblem
from vbbench_baselines.joint_map.prior import Prior, get_prior, variants_held_out
from vbbench_baselines.joint_map.real_camera.choice import RoughCamera
from vbbench_baselines.joint_map.real_camera.settings import Settings, settings_of

CROWD = 30
"""A sequence with more tracks is a crowd."""

CROWDED_WINDOW = 8
"""Frames that suffice in a crowd, where many people constrain the poses."""

RESTING = 0.3
"""How much it counts after a cold start that people are slow, beside their pace, which moves worlds ahead alone."""


@dataclass(kw_only=True)
class MapCausal:
    """Joint maximum a posteriori, causal.

    Parameters
    ----------
    prior : how people walk.
    ego_prior : whether the observer is expected to walk like the others.
    feet : whether a box's bottom gives its distance; otherwise its height does.
    real : what is assumed of a camera that is known only roughly, which is then solved by `joint_map.real_camera`;
        ``None`` takes every camera for exact, as the two options above do if off.
    rests : whether, where too few people are seen, nobody is expected to keep a velocity for ever (`joint_map.lost`);
        nothing is expected of the observer without ``ego_prior``.
    learns : whether the true past that one-step gives also teaches how people walk.
    window : frames that are solved together; in crowds no more than `CROWDED_WINDOW`.
    rounds : maximum number of descent steps per frame.
    tolerance, certain : in m and rad, and in standard deviations; the descent ends with a step shorter than either.
    """

    facts: ClassVar[Mapping[str, str]] = FITTED
    held_out: ClassVar[Mapping[str, str]] = variants_held_out("Causal")
    """Variants with a prior that never saw the recording, by the SHA-256 of its files."""

    prior: Prior = field(default_factory=lambda: get_prior("default"))
    ego_prior: bool = True
    feet: bool = True
    rests: bool = True
    learns: bool = True
    window: int = 12
    rounds: int = 30
    tolerance: float = 1e-3
    certain: float = 0.1
    real: Settings | None = field(default_factory=Settings)

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        people = len(problem.tracks)
        self._problem, self._eye, self._heights = problem, Eye(problem, self.feet), BoxHeights(problem)
        self._ground = GroundCheck(problem) if self.feet else None
        self._known, self._unknown = (walk_of(self.prior, problem.dt, self.ego_prior, cold) for cold in (False, True))
        self.statures = statures_of(problem, self.feet)
        self._size = min(self.window, CROWDED_WINDOW) if people > CROWD else self.window
        self._rows = Window(self._size, people)
        self._boxes: deque[FloatArray] = deque(maxlen=self._size)
        self._lessons = nothing_learned(people, self._known, self.prior)
        self._kept, self._continued = NOTHING_KEPT, nothing_continued(people)
        self._covariances = problem.covariances
        self._cold = self._picks = self._adrift = False
        self._astray, self._lost = Astray(), 0.0
        self.crowd = Crowd()
        self._roughly = RoughCamera(self.settings, problem)
        self._flow = Flow(problem.dt, drives=not self.ego_prior)

    @property
    def settings(self) -> Settings | None:
        """What is assumed of a rough camera; ``None`` if every camera is taken for exact."""
        return settings_of(self.real, self.prior, promised=not (self.feet and self.ego_prior))

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        observations = usable(frame.observations)
        rough = self._roughly.step(observations, frame.given)
        if rough is not None:
            return rough
        self._look_at_ground(observations, frame.given)
        answer = self.advance(self._eye.sight(observations), frame.given)
        if not self.feet:
            return answer
        self._heights.learn(self._eye.with_feet(observations))
        return replace(answer, **self._heights.report())

    def forget(self, columns: IntArray) -> None:
        """From the next frame on the ``columns`` [M] stand for new people, of whom nothing is known.

        Costs and memory of a step are those of the people in the window, however many columns there are and stood for
        somebody before.
        """
        self._roughly.forget(columns)
        self._rows.forget(columns)
        self._continued.held[columns] = 0
        self._eye.forget(columns)
        for boxes in self._boxes:
            boxes[columns] = np.nan
        self._heights.forget(columns)
        forget(columns, self._lessons)
        if self._ground is not None:
            self._ground.forget(columns)
        self._picks = True

    def advance(self, seen: Sightings, given: Given) -> FrameEstimate:
        """The answer for the next frame, from the rays of its boxes and what `Frame.given` holds."""
        rows = self._rows
        if begins_cold(given, rows.frames):
            self._cold = self._picks = True
        rows.push(seen, self.statures, given)
        passed = self._problem.dt if rows.frames > 1 and np.isnan(rows.motions[-1, 0]) else 0.0
        self._astray.wait(passed)
        shown, told = ~np.isnan(rows.relative[-1, :, 0]), ~np.isnan(rows.given[rows.filled, :, 0])
        self._lost = seconds_after(self._lost, shown, told, not math.isnan(rows.given_poses[-1, 0]), passed)
        self._adrift = self.rests and self.ego_prior and self._is_lost and bool(np.count_nonzero(shown) < FOUND)
        learns = self.learns and not math.isnan(rows.given_poses[-2, 0])
        picked = rows.present() if self._picks and not learns else None
        located = self._locate(seen, picked, learns)
        rows.poses[-1], rows.places[-1, _columns(picked)] = located.pose, located.places
        if rows.frames > START_FRAMES and math.isnan(rows.given_poses[-3, 0] + rows.given_poses[-2, 0]):
            return self._settle(picked)
        if len(self._kept.poses) > 0:  # of frames that have moved on
            self._kept, self._continued = NOTHING_KEPT, nothing_continued(len(self._problem.tracks))
        report = self._report_located(located, picked) if self._covariances else {}
        return FrameEstimate(pose=located.pose, positions=rows.places[-1].copy(), converged=True, **report)

    @property
    def _is_lost(self) -> bool:
        return self._lost > PATIENCE

    @property
    def _walk(self) -> Walk:
        """How everybody walks; adrift nobody keeps a velocity for ever; after a cold start people's pace tells more."""
        if self._cold:
            return self._unknown._replace(rest=RESTING * self._unknown.rest)
        return self.crowd.walk(self._unknown if self._adrift else self._known)

    def _look_at_ground(self, observations: FloatArray, given: Given) -> None:
        """After a cold start, go over from feet to box heights for good as soon as the ground is not what feet need."""
        if self._ground is None:
            return
        self._boxes.append(observations)
        cold = self._cold or begins_cold(given, self._rows.frames)
        level = self._ground.look(observations)
        if self._rows.frames > 0 and (not cold or not level):
            self._ground = None
        if cold and not level:
            self._eye, self.statures = Eye(self._problem, feet=False), statures_of(self._problem, feet=False)
            self._rows.measure_again([self._eye.sight(boxes) for boxes in list(self._boxes)[:-1]], self.statures)

    def _locate(self, seen: Sightings, picked: IntArray | None, learns: bool) -> Located:
        """The newest frame on the past, of the people ``picked`` [M]."""
        rows, past = self._rows, slice(-1 - PAST, -1)
        known = chosen(rows.places[past], picked, 1), rows.poses[past], chosen(rows.given[-1], picked, 0)
        seen = Sightings(*(chosen(values, picked, 0) for values in seen))
        statures = Statures(*(chosen(values, picked, 0) for values in self.statures))
        lessons = self._lessons if picked is None else only(picked, self._lessons)
        motions = self._motions(slice(-3, None))
        motions = Motions(motions.moved[-1:], motions.information[-1:])
        return locate(seen, statures, *known, rows.given_poses[-1], self._walk, lessons, learns, motions)

    def _settle(self, picked: IntArray | None) -> FrameEstimate:
        """Solve the window with the people ``picked`` [M], and keep the information of the frame that leaves next."""
        rows = self._rows
        used, columns = rows.filled, _columns(picked)
        poses, places = rows.poses[used], chosen(rows.places[used], picked, 1)
        anchor = anchor_of(~np.isnan(rows.given_poses[used, 0]), self._kept)
        data = rows.measurements(self.statures, only_those(self._continued, picked), picked)
        problem = JointProblem(data, anchor, self._walk, self._motions(used))
        settled = settle(poses, places, problem, self.rounds, self.tolerance, self.certain)
        rows.poses[used], rows.places[used, columns] = settled.state.poses, settled.state.places
        variances = settled.state.variances
        self._lessons.variances[:-1][columns], self._lessons.variances[-1] = variances[:-1], variances[-1]
        if rows.frames >= self._size:
            begun = int(np.count_nonzero((data.first == 0) & (data.last >= REACH)))
            tells = not self._cold and asks(rows.frames, begun)
            self._kept, continued, told = marginalise(settled, problem, tells)
            keep(self._continued, continued, picked)
            if tells:
                self.crowd.learn(told, self._known)
                self._lessons.sigma[0] = self._walk.sigma
        self._follow_flow(used)
        pose, now = rows.poses[-1].copy(), rows.places[-1].copy()
        report = self._report_settled(settled, problem, picked) if self._covariances else {}
        return FrameEstimate(pose=pose, positions=now, converged=settled.converged and not self._is_lost, **report)

    def _follow_flow(self, used: slice) -> None:
        """After a cold start, move all in the rows ``used`` to where people's pace says, if nothing else has told."""
        rows = self._rows
        if not self._cold or not self._flow.is_needed(rows.given_poses[used], rows.given[used], rows.motions[used]):
            return
        moved = self._flow.follow(rows.poses[used], rows.places[used], ~np.isnan(rows.relative[used, :, 0]))
        if moved is not None:
            rows.poses[used, :2] += moved
            rows.places[used] += moved[:, None]
            self._kept = move_kept(moved[1:], self._kept, self._continued)

    def _motions(self, used: slice) -> Motions:
        """What is measured of the observer's motions into the rows ``used``, and after a cold start expected."""
        rows = self._rows
        motions = motions_of(rows.motions[used], rows.covariances[used])
        if not self._cold and not self._adrift:
            return motions
        seen = np.count_nonzero(~np.isnan(rows.relative[used, :, 0]), axis=1)
        return let_stand(motions, rows.poses[used], seen, rows.new[used], self._walk, self._problem.dt)

    def _report_located(self, located: Located, picked: IntArray | None) -> dict[str, Any]:
        pose, factors, sigma = located.pose, located.factors, np.zeros((3, 3))
        if np.isnan(self._rows.given_poses[-1, 0]):
            _, hessian = linearise_people(pose, factors)
            sigma[:] = np.linalg.inv(hessian + located.own)
        return self._report(sigma, position_covariances(pose, sigma, factors), picked)

    def _report_settled(self, settled: Settled, problem: JointProblem, picked: IntArray | None) -> dict[str, Any]:
        sigma, newest = pose_covariance_of(settled.state, problem), len(settled.state.poses) - 1
        places = place_covariances(settled.state, self._walk, sigma, newest)[newest]
        return self._report(block_of(sigma, newest, newest), places, picked)

    def _report(self, pose: FloatArray, places: FloatArray, picked: IntArray | None) -> dict[str, Any]:
        """Covariances [3, 3] of the pose and of the places [M, 2, 2] of the people ``picked``."""
        everyone = np.full((len(self._problem.tracks), 2, 2), np.nan)
        everyone[_columns(picked)] = places
        if self._cold or self._is_lost:
            lost = drift_variance(np.array(self._lost))
            add_drift(pose, everyone, np.array(self._astray.variance) if self._cold else lost)
        return {"pose_covariance": pose, "position_covariances": everyone}


def _columns(picked: IntArray | None) -> IntArray | slice:
    """As an index."""
    return slice(None) if picked is None else picked
