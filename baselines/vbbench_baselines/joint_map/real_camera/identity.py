"""Whom the newest boxes show: the people that their tracks showed before, others who are known, or somebody else.

A tracker's tracks change hands where people pass one another. Every person is expected somewhere, with a spread, before
the newest boxes count; a box shows each of them, or somebody else nearby, with a density. The likeliest way to tell
boxes and people apart, in which nobody is seen twice, is taken.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.common.ego_motion import wrapped
from vbbench_baselines.joint_map.motion.walks import REACH, innovation, reweigh
from vbbench_baselines.joint_map.real_camera.certainty import add_spread, put_own_spread
from vbbench_baselines.joint_map.real_camera.cholesky import factor, solve
from vbbench_baselines.joint_map.real_camera.cues import CUES, PERSON, residuals_of, whiten
from vbbench_baselines.joint_map.real_camera.elimination import Person, Scratch, eliminate, scratch_for
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen, boxes_of
from vbbench_baselines.joint_map.real_camera.recovery import follow
from vbbench_baselines.joint_map.real_camera.window import SOMEBODY

ASIDE, FARTHER = 0.4, 0.3
"""Where somebody else is beside the one expected: standard deviations across the ray, as a share of the box's height,
and along it, as a share of the distance."""

DOUBT = 6.0
"""A box is asked for whom it shows if it is so many squared standard deviations off."""

IMPOSSIBLE, UNLIKELY = 1e6, -1e3
"""A cost; and the log density of a cut box by somebody unknown: what is left of it does not tell that somebody came."""

BESIDE = 1.5
"""In heights of a box: whoever is expected farther aside is not in it."""

HEAVY = 6.0
"""Degrees of freedom of how boxes are off."""

EXPECTING, SHORT = 4, 0.05
"""Most rounds of foreseeing somebody, and the step in m that is the last."""

TOLD = 0.25
"""The share of changes of hands that lead to a given one of the people around."""


class Expected(NamedTuple):
    """Of K people in the newest frame, before its boxes count.

    Attributes
    ----------
    known : [K] 1 if anything is.
    place, numbers : [K, 2] each.
    alone : [K, 2, 2] covariance of the place as if the numbers were sure.
    by_numbers, inner : [K, 2, 2] how the place moves with the numbers, and their covariance.
    behind, fresh : [K, 3] what of the last box's residuals lasts, and the variance of what comes anew.
    """

    known: IntArray
    place: FloatArray
    numbers: FloatArray
    alone: FloatArray
    by_numbers: FloatArray
    inner: FloatArray
    behind: FloatArray
    fresh: FloatArray


@kernel
def expect(point: Point, seen: Seen, model: Model) -> Expected:
    """Of people who are followed to the newest frame, whose boxes are hidden in ``seen``."""
    people, newest = len(seen.first), len(point.frames) - 1
    known, place, numbers = np.zeros(people, np.int64), np.empty((people, 2)), np.empty((people, PERSON))
    alone, by_numbers, inner = np.empty((people, 2, 2)), np.empty((people, 2, PERSON)), np.empty((people, 2, 2))
    behind, fresh = np.zeros((people, CUES)), np.ones((people, CUES))
    scratch = scratch_for(len(point.frames))
    for k in range(people):
        first = int(seen.first[k])
        if int(seen.last[k]) != newest or first >= newest:
            continue
        track, taller, person = _foresee(k, point, seen, model, scratch)
        put_own_spread(person, newest - first, by_numbers[k], alone[k])
        for a in range(2):
            place[k, a], numbers[k, a] = track[-1, a], taller[a]
            for b in range(2):
                inner[k, a, b] = person.inner[a, b]
        found, known[k] = person.found, int(np.isfinite(track[-1, 0] + track[-1, 1]))
        if len(found.frame) > 0:
            apart = newest - first - found.frame[-1]
            for j in range(CUES):
                if found.counts[-1, j] == 1.0 and apart < REACH:
                    rho = np.exp(-apart * model.dt / model.noise.tau[j])
                    behind[k, j], fresh[k, j] = rho * found.value[-1, j], 1.0 - rho * rho
    return Expected(known, place, numbers, alone, by_numbers, inner, behind, fresh)


@kernel
def _foresee(k: int, point: Point, seen: Seen, model: Model, scratch: Scratch) -> tuple[FloatArray, FloatArray, Person]:
    """The track [n, 2] of person ``k``, its numbers [2], and it eliminated about them, up to the newest frame.

    Where somebody was may have been told since it was believed, and then all that was believed of them is another.
    """
    first, last = int(seen.first[k]), int(seen.last[k])
    track, numbers, given = (
        point.places[first : last + 1, k].copy(),
        point.people[k].copy(),
        seen.given[first:, k].copy(),
    )
    for i in range(len(track)):
        for a in range(2):
            if not np.isnan(given[i, a]):
                track[i, a] = given[i, a]
            elif i > 0 and np.isnan(track[i, a]):
                track[i, a] = track[i - 1, a]
    weights, still = np.zeros(len(track)), np.zeros(point.frames.shape)
    for rounds in range(1, EXPECTING + 1):
        found = residuals_of(k, first, seen.boxes, point.frames, track, numbers, model.noise)
        white = whiten(found, model.noise, model.dt)
        reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        person, _ = eliminate(
            k, first, track, given, numbers, found, white, weights, model.walk, model.people, seen.past, 0.0, scratch
        )
        moved, taller = follow(person, still)
        if rounds == EXPECTING or not max(_added(track.ravel(), moved.ravel()), _added(numbers, taller)) > SHORT:
            break
    return track, numbers, person


@kernel
def _added(target: FloatArray, step: FloatArray) -> float:
    """Add a step [n], and return how far it goes at most."""
    farthest = 0.0
    for i in range(len(target)):
        target[i] += step[i]
        farthest = max(farthest, abs(step[i]))
    return farthest


@kernel
def likelihoods(
    point: Point, seen: Seen, model: Model, expected: Expected, asked: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Log densities of the newest boxes ``asked`` [K], by each of the people [K, K], and by somebody else [K].

    −∞ where nothing is known, and of whoever is expected elsewhere.
    """
    people, newest = len(seen.first), len(point.frames) - 1
    shown, else_shown = np.full((people, people), -np.inf), np.full(people, -np.inf)
    frame = point.frames[newest]
    prior, nothing, unmoved = np.diag(model.people.std**2), np.zeros(CUES), np.zeros((2, PERSON))
    for box in range(people):
        if not asked[box]:
            continue
        for k in range(people):
            if expected.known[k] and _is_beside(expected.place[k], frame, seen, newest, box):
                place, numbers = expected.place[k], expected.numbers[k]
                by_numbers, inner = expected.by_numbers[k], expected.inner[k]
                behind, fresh = expected.behind[k], expected.fresh[k]
                shown[box, k] = _density(
                    box, newest, seen, point, model, place, numbers, expected.alone[k], by_numbers, inner, behind, fresh
                )
        if expected.known[box] and seen.boxes.cut[newest, box] != 0:
            else_shown[box] = UNLIKELY
            continue
        place = expected.place[box].copy()
        if not expected.known[box]:
            reach = np.exp(model.people.mean[0]) / seen.boxes.length[newest, box] + model.people.mean[1]
            heading = frame[2] - seen.boxes.azimuth[newest, box]
            place[0], place[1] = frame[0] + reach * np.cos(heading), frame[1] + reach * np.sin(heading)
        x, y = place[0] - frame[0], place[1] - frame[1]
        reach = np.sqrt(x * x + y * y)
        aside = ASIDE * seen.boxes.width[newest, box]
        nearby = np.empty((2, 2))
        nearby[0, 0] = FARTHER**2 * x * x + aside**2 * y * y
        nearby[1, 1] = FARTHER**2 * y * y + aside**2 * x * x
        nearby[0, 1] = nearby[1, 0] = (FARTHER**2 - aside**2) * x * y
        else_shown[box] = _density(
            box,
            newest,
            seen,
            point,
            model,
            place,
            model.people.mean,
            nearby,
            unmoved,
            prior,
            nothing,
            nothing + 1.0,
        )
    return shown, else_shown


@kernel
def _is_beside(place: FloatArray, frame: FloatArray, seen: Seen, newest: int, box: int) -> bool:
    """Whether somebody at a place may be in a newest box, by the direction."""
    angle = frame[2] - np.arctan2(place[1] - frame[1], place[0] - frame[0]) - seen.boxes.azimuth[newest, box]
    return bool(abs(wrapped(angle)) < BESIDE * seen.boxes.width[newest, box])


@kernel
def _density(
    box: int,
    newest: int,
    seen: Seen,
    point: Point,
    model: Model,
    place: FloatArray,
    numbers: FloatArray,
    alone: FloatArray,
    by_numbers: FloatArray,
    inner: FloatArray,
    behind: FloatArray,
    fresh: FloatArray,
) -> float:
    """Log density of a newest box, of somebody who is expected so."""
    track = place.copy().reshape((1, 2))
    found = residuals_of(box, newest, seen.boxes, point.frames, track, numbers, model.noise)
    slopes, taller = found.by_place[0], np.empty((CUES, PERSON))
    spread, off, volume = np.zeros((CUES, CUES)), np.empty(CUES), 0.0
    for j in range(CUES):
        count = found.counts[0, j]
        off[j] = found.value[0, j] - (behind[j] if count == 1.0 else 0.0)
        spread[j, j] = fresh[j] if count == 1.0 else 1.0 / max(count, 1e-6)
        volume += np.log(found.scale[0, j])
        for q in range(PERSON):
            by_place = slopes[j, 0] * by_numbers[0, q] + slopes[j, 1] * by_numbers[1, q]
            taller[j, q] = by_place + found.by_person[0, j, q]
    add_spread(slopes, alone, spread)
    add_spread(taller, inner, spread)
    if not factor(spread):
        return -np.inf
    weighed, away = off.copy(), 0.0
    solve(spread, weighed)
    for j in range(CUES):
        away += off[j] * weighed[j]
        volume += np.log(spread[j, j])
    return float(-volume - 0.5 * (HEAVY + CUES) * np.log(1.0 + away / HEAVY))


@kernel
def is_doubtful(point: Point, seen: Seen, model: Model) -> BoolArray:
    """[K] whose newest boxes are whole and not where those before would have them, or who have only these.

    What the picture's border leaves of a box is off by more than a share of it, and does not tell whom it shows.
    """
    doubtful, newest = np.zeros(len(seen.first), np.bool_), len(point.frames) - 1
    for k in range(len(doubtful)):
        if np.isnan(seen.boxes.azimuth[newest, k]) or not np.isnan(seen.given[newest, k, 0]):
            continue
        track, found = boxes_of(k, point, seen, model)
        off = 0.0
        for j in range(CUES):
            off += found.counts[-1, j] * found.value[-1, j] ** 2
        if len(track) > 2:
            off += innovation(track, len(track) - 1, model.walk) / point.variances[k]
        doubtful[k] = len(found.frame) < 2 or (off > DOUBT and seen.boxes.cut[newest, k] == 0)
    return doubtful


def tell_apart(
    shown: FloatArray, else_shown: FloatArray, boxes: IntArray, changing: float
) -> tuple[IntArray, FloatArray]:
    """Whom each of the ``boxes`` [M] shows, as a column or `SOMEBODY`, and how probable it is that it does not.

    Parameters
    ----------
    shown, else_shown : see `likelihoods`.
    changing : the share of boxes at which tracks change hands.
    """
    costs = -shown[boxes] - np.log(changing * TOLD)
    costs[np.arange(len(boxes)), boxes] = -shown[boxes, boxes] - np.log(1.0 - changing)
    anew = -else_shown[boxes] - np.log(changing * (1.0 - TOLD))
    people = costs.shape[1]
    costs = np.concatenate((costs, np.where(np.eye(len(boxes), dtype=bool), anew[:, None], np.inf)), axis=1)
    chances = np.exp(costs.min(axis=1, keepdims=True) - costs)
    chances /= chances.sum(axis=1, keepdims=True)
    rows, chosen = linear_sum_assignment(np.minimum(costs, IMPOSSIBLE))
    return np.where(chosen < people, chosen, SOMEBODY), 1.0 - chances[rows, chosen]
