"""The newest frames of a joint problem alone, as if what was found of those before them were known.

A new frame tells most of itself and of the few before it. Solved alone these are a problem a tenth as large, in which
other ways to begin can be tried. A round over all frames then carries what was found to the others.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_baselines.common.bearings import each
from vbbench_baselines.common.odometry import Motions
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.cues import PITCH
from vbbench_baselines.joint_map.real_camera.descent import Settled, settle
from vbbench_baselines.joint_map.real_camera.drift import Drift
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen
from vbbench_baselines.joint_map.real_camera.observer import VEHICLE, surprises
from vbbench_baselines.joint_map.real_camera.past import nothing_past

NEWEST = 8
"""Frames that are solved alone, after `REACH` that are known."""

SURE = 1e-3
"""The camera before them is known to so small a share of its steps."""

ROUNDS = 4
"""Most rounds of their descent."""

SET_OFF, FEW = 3, 2
"""For how many newest frames it is tried that a vehicle which seems to stand moves already, and the rounds after which
that must be more probable, if only a little."""

SURER_BY = 40.0
"""How much lower the deviance must be then: frames are not as independent as the model takes them to be."""

FADING = 4.0
"""In s: a doubt fades to a third."""

DOUBTFUL_BY = 20.0
"""From how much lower a deviance on it may as well be so; the covariance says by how far the camera is off then."""


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
    doubt : [3, 3] what has to be added to the covariance of the newest pose, since a vehicle that is taken to stand
        may have set off.
    """

    point: Point
    chosen: int
    doubt: FloatArray


def solve_newest(starts: list[Start], seen: Seen, model: Model, doubt: FloatArray, *, from_rest: bool) -> Found:
    """The most probable of the ``starts``, each with its newest frames solved.

    ``from_rest``: whether it is tried that a vehicle sets off which seems to stand; ``doubt`` [3, 3] : of the frame
    before.
    """
    solved = [_solved(start.point, seen, model) for start in starts]
    chosen = int(np.argmin([start.unlikely + found[1].deviance for start, found in zip(starts, solved, strict=True)]))
    point, best, part, alone = solved[chosen]
    if from_rest and seems_to_stand(best, part):
        best, doubt = set_off(best, part, alone, doubt)
    else:
        doubt = np.zeros((3, 3))
    return Found(with_newest(point, best.point), chosen, doubt)


def _solved(point: Point, seen: Seen, model: Model) -> tuple[Point, Settled, Seen, Model]:
    alone, part, believed = newest_of(point, seen, model)
    return point, settle(alone, part, believed, ROUNDS, len(part.fixed), False), part, believed


def newest_of(point: Point, seen: Seen, model: Model) -> tuple[Point, Seen, Model]:
    """The problem of the newest frames: of the `REACH` before them poses and places are given.

    People who were seen by then have known numbers. Steps before them tell of the laws what they did.
    """
    start = max(len(point.frames) - NEWEST - REACH, 0)
    if start == 0:
        return point._replace(variances=point.variances.copy()), seen, model
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


def seems_to_stand(settled: Settled, seen: Seen) -> bool:
    """Whether a vehicle probably stands during the newest step, of which boxes alone tell."""
    told = seen.fixed[-1] or seen.blind[-1] or not seen.free[-1]
    return not told and min(settled.shares.laws[VEHICLE], settled.shares.standing[-1]) > 0.5


def set_off(best: Settled, seen: Seen, model: Model, doubt: FloatArray) -> tuple[Settled, FloatArray]:
    """Where the descent ends if a vehicle that was taken to stand moves in the newest frames, if that is surer.

    If it is so by less than `SURER_BY`, by how far it is off then is the doubt [3, 3] in that it stands. The ``doubt``
    of the frame before fades: what told of setting off is soon taken for people who changed their ways.
    """
    start, size = best.point._replace(variances=best.point.variances.copy()), len(seen.fixed)
    going = model._replace(observer=model.observer._replace(going=SET_OFF))
    tried = settle(start, seen, going, FEW, size, False)
    if tried.deviance < best.deviance:
        tried = settle(settle(tried.point, seen, going, ROUNDS, size, False).point, seen, model, ROUNDS, size, False)
    surer = best.deviance - tried.deviance
    if surer > SURER_BY:
        return tried, np.zeros((3, 3))
    apart = tried.point.frames[-1, :3] - best.point.frames[-1, :3]
    newest = min(max(surer / DOUBTFUL_BY, 0.0), 1.0) * np.outer(apart, apart)
    return best, max(newest, doubt * np.exp(-model.dt / FADING), key=np.trace)
