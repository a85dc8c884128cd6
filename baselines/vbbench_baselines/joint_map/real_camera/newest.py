"""The newest frames of a joint problem alone, as if what was found of those before them were known.

A new frame tells most of itself and of the few before it. Solved alone these are a problem a tenth as large, in which
other ways to begin can be tried. A round over all frames then carries what was found to the others.
"""

from typing import NamedTuple

import numpy as np

from vbbench_baselines.common.bearings import each
from vbbench_baselines.common.odometry import Motions
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.cues import PITCH
from vbbench_baselines.joint_map.real_camera.descent import Settled, copied, settle
from vbbench_baselines.joint_map.real_camera.drift import Drift
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen
from vbbench_baselines.joint_map.real_camera.observer import surprises
from vbbench_baselines.joint_map.real_camera.past import nothing_past
from vbbench_baselines.joint_map.real_camera.rest import Rest

NEWEST = 8
"""Frames that are solved alone, after `REACH` that are known."""

SURE = 1e-3
"""The camera before them is known to so small a share of its steps."""

ROUNDS = 3
"""Most rounds of their descent."""


class Start(NamedTuple):
    """Where a descent begins, and −ln of how probable it is beforehand beside the others."""

    point: Point
    unlikely: float = 0.0


class Found(NamedTuple):
    """The newest frames solved.

    Attributes
    ----------
    point : where all frames are.
    chosen : from which start.
    """

    point: Point
    chosen: int


def solve_newest(starts: list[Start], seen: Seen, model: Model, rest: Rest | None) -> Found:
    """The most probable of the ``starts``, each with its newest frames solved; a vehicle may have left its ``rest``."""
    solved = [_solved(start.point, seen, model) for start in starts]
    chosen = int(np.argmin([start.unlikely + found[1].deviance for start, found in zip(starts, solved, strict=True)]))
    point, best, part, alone = solved[chosen]
    if rest is None:
        return Found(with_newest(point, best.point), chosen)
    point = with_newest(point, rest.left_at_once(best, part, alone).point)
    return Found(rest.left_before(point, seen, model) if len(starts) == 1 else point, chosen)


def _solved(point: Point, seen: Seen, model: Model) -> tuple[Point, Settled, Seen, Model]:
    alone, part, believed = newest_of(point, seen, model)
    return point, settle(alone, part, believed, ROUNDS, len(part.fixed), False), part, believed


def newest_of(point: Point, seen: Seen, model: Model) -> tuple[Point, Seen, Model]:
    """The problem of the newest frames: of the `REACH` before them poses and places are given.

    People who were seen by then have known numbers. Steps before them tell of the laws what they did.
    """
    start = max(len(point.frames) - NEWEST - REACH, 0)
    if start == 0:
        return copied(point), seen, model
    block = slice(start, None)
    frames, places = point.frames[block], point.places[block]
    given, fixed = seen.given[block].copy(), seen.fixed[block].copy()
    given[:REACH] = np.where(np.isnan(given[:REACH]), places[:REACH], given[:REACH])
    fixed[:REACH] = True
    part = Seen(
        boxes=each(lambda rows: rows[block], seen.boxes),
        given=given,
        fixed=fixed,
        free=seen.free[block],
        blind=seen.blind[block],
        first=np.maximum(seen.first - start, 0),
        last=seen.last - start,
        sure=seen.first < start + REACH,
        motions=Motions(seen.motions.moved[block], seen.motions.information[block]),
        past=nothing_past(len(seen.first)),
        told=seen.told[block],
    )
    told = surprises(point.frames, seen.free, start + 2, model.observer)
    camera = Drift(frames[0, PITCH:], SURE * model.drift.step, model.drift.step, model.drift.nu)
    alone = Point(frames, places, point.people, point.variances.copy())
    return alone, part, model._replace(odds=model.odds - told, drift=camera, cold=False)


def with_newest(point: Point, found: Point) -> Point:
    """The ``point`` with what was ``found`` of its newest frames and their people."""
    frames, places = point.frames.copy(), point.places.copy()
    frames[-len(found.frames) :], places[-len(found.places) :] = found.frames, found.places
    return Point(frames, places, found.people, found.variances)
