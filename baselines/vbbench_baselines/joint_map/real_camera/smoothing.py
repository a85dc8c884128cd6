"""The joint problem of a real camera over a whole sequence, from the answer of the frames as they came."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import Estimate, Problem
from vbbench.solving.runner import given_at
from vbbench_baselines.common.cold_start import astray_after
from vbbench_baselines.joint_map.flow import flow_of, is_untold
from vbbench_baselines.joint_map.lost import PATIENCE, seconds_lost
from vbbench_baselines.joint_map.optimiser.descent import unwrapped
from vbbench_baselines.joint_map.real_camera.behind import add_behind
from vbbench_baselines.joint_map.real_camera.certainty import HELD
from vbbench_baselines.joint_map.real_camera.descent import Settled, copied, settle
from vbbench_baselines.joint_map.real_camera.gaps import fill
from vbbench_baselines.joint_map.real_camera.heights import is_short
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen, deviance_of, let_first_go
from vbbench_baselines.joint_map.real_camera.observer import Observer
from vbbench_baselines.joint_map.real_camera.rest import standing
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.tracking import Tracking
from vbbench_baselines.joint_map.real_camera.window import NOBODY, Window

BLOCK, STRIDE = 80, 40
"""Frames that are solved together, and from one block to the next."""

ROUNDS = 20
"""Most rounds of a block's descent."""

HINDSIGHT = (1.3, 1.35)
"""By how much more than `MODEL_ERROR` squared errors of poses and places are larger than the model says, where later
frames were looked at: chosen with it, on the same recordings."""

SURER_BY = 40.0
"""By how much lower a block's deviance must be if the camera moves where it was taken to stand."""


class Course(NamedTuple):
    """What was found when each frame was the newest.

    Attributes
    ----------
    columns : [T, K] where each track was.
    found : [T, K] whether it had a place.
    doubts : [T, 3, 3] of the camera, as of `Rest`.
    still : [T] whether the camera probably stood during the step into it, as long as the window told.
    """

    columns: IntArray
    found: BoolArray
    doubts: FloatArray
    still: BoolArray


def _no_course(size: int, people: int) -> Course:
    nobody, nowhere = np.full((size, people), NOBODY), np.zeros((size, people), np.bool_)
    return Course(nobody, nowhere, np.zeros((size, 3, 3)), np.zeros(size, np.bool_))


def smooth(settings: Settings, problem: Problem, boxes: FloatArray, given: Given) -> Estimate:
    """The estimate of all frames [T, K, 3], revised by those after them; the rest as of `Tracking`."""
    tracking = Tracking(settings, replace(problem, covariances=False))
    last, (size, people) = tracking.rows, boxes.shape[:2]
    rows = Window(size, people, tracking.model.people.mean, tracking.model.walk.sigma**2)
    course, by_name = _no_course(size, people), dict[int, int]()
    for t in range(size):
        shown = given_at(given, t)
        course.found[t] = ~np.isnan(tracking.step(boxes[t], shown).positions[:, 0])
        seated = np.flatnonzero(last.column != NOBODY)
        names = last.names[last.column[seated]].tolist()
        rows.column[seated] = [by_name.get(name, NOBODY) for name in names]
        rows.push(tracking.bearings, shown, last.frames[-1])
        by_name.update(zip(names, rows.column[seated].tolist(), strict=True))
        course.columns[t], course.doubts[t] = rows.column, tracking.rest.doubt
        _revise(rows, last, by_name, tracking.model.people.mean[0])
        stands = _standing(tracking)
        course.still[t + 1 - len(stands) : t + 1] = stands
    rows.frames[:] = unwrapped(rows.frames)
    return _settle_blocks(tracking, rows, course, problem)


def _revise(rows: Window, last: Window, by_name: Mapping[int, int], mean: float) -> None:
    """Take over what is now believed of the ``last`` frames; people have columns of their own in ``rows``.

    Of people's numbers only of those who are short, beside the ``mean``: from others' the descent finds its way.
    """
    block, known = slice(len(rows.frames) - len(last.frames), None), last.present()
    own = np.array([by_name[name] for name in last.names[known].tolist()], np.int64)
    rows.frames[block], rows.places[block, own] = last.frames, last.places[:, known]
    numbers = last.numbers[known]
    short = is_short(numbers[:, 0], mean)
    rows.numbers[own[short]] = numbers[short]


def _with_told(point: Point, seen: Seen, model: Model) -> tuple[Point, Seen]:
    """After a cold start, what boxes tell of places as it is a round later, and the point there."""
    if not model.cold:
        return point, seen
    settled = settle(point, seen, model, 2, len(seen.fixed), False)
    return settled.point, seen._replace(told=settled.told)


def _standing(tracking: Tracking) -> BoolArray:
    """[n - 1] whether a vehicle probably stands during the steps of the window, of which boxes alone tell."""
    rows = tracking.rows
    told = ~np.isnan(rows.given_poses[:, 0]) | ~np.isnan(rows.motions[:, 0]) | np.isnan(rows.boxes.azimuth).all(axis=1)
    return np.asarray((standing(tracking.shares) & ~told)[1:])


def _settle_block(
    point: Point, seen: Seen, model: Model, still: BoolArray, since: int, *, covariances: bool
) -> Settled:
    """Where the descent ends; the camera stays where it stood ``still`` [T], unless it surely moved.

    After a cold start standing is hardly told from going with the crowd, and not held to.
    """
    if model.cold or not still.any():
        return settle(point, seen, model, ROUNDS, since, covariances)
    rest = settle(point, _at_rest(seen, still, model.observer), model, ROUNDS, since, covariances)
    surest = deviance_of(copied(rest.point), seen, model) - SURER_BY
    freed = settle(copied(rest.point), seen, model, ROUNDS, since, covariances)
    return freed if freed.deviance < surest else rest


def _at_rest(seen: Seen, still: BoolArray, observer: Observer) -> Seen:
    """The same, as if odometry said of the ``still`` frames [T] that the camera stands."""
    moved, turned = observer.still
    information = seen.motions.information.copy()
    information[still] = np.diag((moved**-2, moved**-2, turned**-2))
    return seen._replace(motions=seen.motions._replace(information=information))


class _Spreads(NamedTuple):
    """Covariances of all frames: [T, 3, 3] of poses and [T, K, 2, 2] of tracks' places, NaN where nobody is."""

    poses: FloatArray
    places: FloatArray

    def take(self, block: slice, settled: Settled, columns: IntArray, chosen: IntArray) -> None:
        """Take over those of a block's frames; tracks are in ``columns`` [T, K], of which ``chosen`` were solved."""
        places = HINDSIGHT[1] * settled.place_covariances
        poses = HINDSIGHT[0] * settled.pose_covariances
        if block.start:
            held, frames = block.start + HELD - 1, settled.point.frames
            add_behind(self.poses[held], frames[HELD - 1], frames, settled.point.places, poses, places)
        self.poses[block] = poses
        order = np.full(max(columns.max(initial=0), chosen.max(initial=0)) + 2, NOBODY)  # the last is that of NOBODY
        order[chosen] = np.arange(len(chosen))
        for t in range(block.start, block.stop):
            here = order[columns[t]]
            known = here != NOBODY
            self.places[t, known] = places[t - block.start, here[known]]


def _settle_blocks(tracking: Tracking, rows: Window, course: Course, problem: Problem) -> Estimate:
    """Solve block after block; a later one overwrites an earlier one."""
    size, people = course.columns.shape
    spreads = _Spreads(np.full((size, 3, 3), np.nan), np.full((size, people, 2, 2), np.nan))
    converged = np.zeros(size, np.bool_)
    for first in range(0, max(size - BLOCK, 0) + STRIDE, STRIDE):
        block = slice(first, min(first + BLOCK, size))
        seen, chosen = rows.seen(block, HELD if first else 0)
        settled, seen = _solved(rows, block, seen, chosen, course.still[block], tracking.model, problem.covariances)
        rows.frames[block], rows.numbers[chosen] = settled.point.frames, settled.point.people
        rows.places[block, chosen], rows.variances[chosen] = settled.point.places, settled.point.variances
        converged[block] = settled.converged
        if problem.covariances:
            spreads.take(block, settled, course.columns, chosen)
        if block.stop < size:
            for t in range(STRIDE):
                let_first_go(settled.point, seen, tracking.model, t)
            rows.carry_on(seen, chosen)
    return _estimate(tracking, rows, course, converged, spreads if problem.covariances else None)


def _solved(
    rows: Window, block: slice, seen: Seen, chosen: IntArray, still: BoolArray, model: Model, covariances: bool
) -> tuple[Settled, Seen]:
    """A block of frames and the people in it who are ``chosen``, solved; and what its boxes told of places."""
    places = rows.places[block].take(chosen, axis=1)
    fill(places, rows.frames[block], seen, rows.numbers[chosen])
    start = Point(rows.frames[block].copy(), places, rows.numbers[chosen], rows.variances[chosen])
    point, seen = _with_told(start, seen, model)
    since = 0 if covariances else len(seen.fixed)
    return _settle_block(point, seen, model, still, since, covariances=covariances), seen


def _estimate(
    tracking: Tracking, rows: Window, course: Course, converged: BoolArray, spreads: _Spreads | None
) -> Estimate:
    """What is reported when all blocks are solved."""
    dt, (size, people) = tracking.model.dt, course.columns.shape
    if tracking.model.cold and is_untold(rows.given_poses, rows.given, rows.motions):
        rows.move(flow_of(rows.frames, rows.places, ~np.isnan(rows.boxes.azimuth), dt, drives=True))
    shown, told = ~np.isnan(rows.boxes.azimuth), ~np.isnan(rows.given[..., 0])
    waits = np.where(np.isnan(rows.motions[:, 0]), dt, 0.0)
    waits[0] = 0.0
    lost = seconds_lost(shown, told, ~np.isnan(rows.given_poses[:, 0]), waits)
    poses, positions, heights = rows.frames[:, :3].copy(), np.full((size, people, 2), np.nan), np.full(people, np.nan)
    poses[:, 2] = wrap_angle(poses[:, 2])
    for t in range(size):
        here = course.found[t]
        positions[t, here] = rows.places[t, course.columns[t, here]]
        heights[here] = np.exp(rows.numbers[course.columns[t, here], 0])
    report: dict[str, Any] = {}
    if spreads is not None:
        _add_doubts(course.doubts, poses, positions, *spreads)
        tracking.add_drift(*spreads, astray_after(waits), np.cumsum(waits), lost)
        report = {"pose_covariances": spreads.poses, "position_covariances": spreads.places}
    return Estimate(
        poses=poses, positions=positions, converged=converged & (lost <= PATIENCE), heights=heights, **report
    )


def _add_doubts(
    doubts: FloatArray, poses: FloatArray, places: FloatArray, poses_spread: FloatArray, places_spread: FloatArray
) -> None:
    """Add in every frame how unsure it was, when it was the newest, that a camera taken to stand did."""
    for t in np.flatnonzero(doubts.any(axis=(1, 2))):
        here = slice(t, t + 1)
        add_behind(doubts[t], poses[t], poses[here], places[here], poses_spread[here], places_spread[here])
